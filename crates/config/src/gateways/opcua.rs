//! `[opcua]`.

use super::super::error::{ConfigProblem, Located};
use super::super::names::stem;
use crate::time_span::Listen;
use profivac_host::text_file::Parsed;
use profivac_station::config::gateways::opcua::{Policy, Settings};
use profivac_web_server::auth::users::Users;
use serde::Deserialize;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The default of `listen`: loopback, the port that IANA has registered for OPC UA.
const LISTEN: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 4840);

/// `[opcua]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpcuaToml {
    /// The address. Default: `127.0.0.1:4840`.
    listen: Option<Spanned<Parsed<Listen>>>,
    /// The host in the URLs. Default: the address of `listen`.
    host: Option<Spanned<String>>,
    /// Clients need no login, on loopback only. Default on loopback: `true`.
    anonymous: Option<Spanned<bool>>,
    /// The security policies. Default: all three.
    policies: Option<Spanned<Vec<Policy>>>,
    /// The folder of the certificates. Default: the name of this file with `.opcua`.
    certificates: Option<PathBuf>,
    /// Operators and engineers write parameters. Default: `false`.
    write: Option<Spanned<bool>>,
}

impl OpcuaToml {
    /// The settings, with the defaults of the keys that are absent. Other computers always encrypt and log in.
    pub fn into_settings(self, path: &Path, users: PathBuf) -> Result<Settings, Located> {
        let listen_span = self.listen.as_ref().map_or(0..0, Spanned::span);
        let listen = self.listen.map_or_else(|| SocketAddr::from(LISTEN), |listen| listen.into_inner().0.0);
        let is_local = listen.ip().is_loopback();
        let is_anonymous = self.anonymous.as_ref().map_or(is_local, |anonymous| *anonymous.get_ref());
        if let Some(anonymous) = self.anonymous.filter(|_| is_anonymous && !is_local) {
            let expected = "anonymous = false where other computers connect: they encrypt and log in";
            return Err(problem(anonymous.span(), expected, "true"));
        }
        let policies_span = self.policies.as_ref().map_or(0..0, Spanned::span);
        let policies = self.policies.map_or_else(|| Policy::ALL.to_vec(), Spanned::into_inner);
        if policies.is_empty() && !is_anonymous {
            return Err(problem(
                policies_span,
                "at least one policy, like \"Basic256Sha256\": no client could connect",
                "[]",
            ));
        }
        if let Some(write) = self.write.as_ref().filter(|write| *write.get_ref()) {
            check_users(&users).map_err(|found| {
                let expected =
                    "write = true only where users log in; `profivac user add NAME --role engineer FILE.toml` adds one";
                problem(write.span(), expected, &found)
            })?;
            if policies.is_empty() {
                return Err(problem(policies_span, "at least one policy: with write = true users log in", "[]"));
            }
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let certificates = self.certificates.unwrap_or_else(|| PathBuf::from(format!("{}.opcua", stem(path))));
        Ok(Settings {
            listen,
            host: host(self.host, listen, listen_span)?,
            is_anonymous,
            policies,
            certificates: folder.join(certificates),
            users,
            write: self.write.is_some_and(Spanned::into_inner),
        })
    }
}

/// Checks that there are users; the error says what was found.
fn check_users(users: &Path) -> Result<(), String> {
    match Users::read(users) {
        Ok(accounts) if accounts.is_empty() => Err(format!("no user in {}", users.display())),
        Ok(_) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}

/// The host of the URLs: the key `host`, or the address at which the gateway listens.
fn host(host: Option<Spanned<String>>, listen: SocketAddr, span: std::ops::Range<usize>) -> Result<String, Located> {
    match host {
        Some(host) if is_host(host.get_ref()) => Ok(host.into_inner()),
        Some(host) => Err(Located::new(host.span(), ConfigProblem::HostName(host.into_inner()))),
        None if listen.ip().is_unspecified() => {
            let expected = "one address, or besides it host = \"...\", the name by which clients reach this computer";
            Err(problem(span, expected, &listen.to_string()))
        }
        None if listen.is_ipv6() => Ok(format!("[{}]", listen.ip())),
        None => Ok(listen.ip().to_string()),
    }
}

/// A name, an IPv4 address, or an IPv6 address in brackets.
fn is_host(host: &str) -> bool {
    let inner = host.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    match inner {
        Some(address) => address.parse::<std::net::Ipv6Addr>().is_ok(),
        None => !host.is_empty() && host.chars().all(|letter| letter.is_ascii_alphanumeric() || ".-".contains(letter)),
    }
}

fn problem(span: std::ops::Range<usize>, expected: &'static str, found: &str) -> Located {
    Located::new(span, ConfigProblem::Gateway { expected, found: found.to_owned() })
}

#[cfg(test)]
mod tests {
    use profivac_station::config::gateways::GatewaySettings;
    use std::path::Path;

    fn settings(table: &str) -> Result<super::Settings, String> {
        let plant = "[[segment]]\nname = \"hall\"\nport = \"sim:hall.toml\"\n";
        let config = crate::parse(&format!("{plant}[opcua]\n{table}"), Path::new("plants/hall.toml"));
        let config = config.map_err(|error| error.to_string())?;
        match config.gateways.into_iter().next() {
            Some(GatewaySettings::Opcua(settings)) => Ok(settings),
            other => Err(format!("{other:?}")),
        }
    }

    #[test]
    fn the_defaults_are_loopback_and_a_folder_beside_the_file() {
        let settings = settings("").unwrap();
        assert_eq!((settings.listen.to_string().as_str(), settings.is_anonymous), ("127.0.0.1:4840", true));
        assert_eq!(settings.certificates, Path::new("plants/hall.opcua"));
        assert_eq!(settings.users, Path::new("plants/hall.users.toml"));
        assert_eq!((settings.host.as_str(), settings.policies.len()), ("127.0.0.1", 3));
    }

    #[test]
    fn other_computers_encrypt_and_log_in() {
        let listen = "listen = \"10.0.0.7:4840\"\n";
        assert!(!settings(listen).unwrap().is_anonymous);
        let error = settings(&format!("{listen}anonymous = true")).unwrap_err();
        assert!(
            error.starts_with("plants/hall.toml:6:13: expected anonymous = false where other computers"),
            "{error}"
        );
        let error = settings(&format!("{listen}policies = []")).unwrap_err();
        assert!(error.contains("expected at least one policy"), "{error}");
    }

    #[test]
    fn all_addresses_need_a_host_for_the_urls() {
        let error = settings("listen = \"0.0.0.0:4840\"").unwrap_err();
        assert!(error.contains(":5:10: expected one address, or besides it host"), "{error}");
        let listen = "listen = \"0.0.0.0:4840\"\nhost = ";
        assert_eq!(settings(&format!("{listen}\"vacuum.example\"")).unwrap().host, "vacuum.example");
        assert!(settings(&format!("{listen}\"opc.tcp://a\"")).unwrap_err().contains("expected a name or an address"));
    }

    #[test]
    fn writing_needs_users() {
        assert!(!settings("").unwrap().write);
        let error = settings("write = true").unwrap_err();
        assert!(error.contains(":5:9: expected write = true only where users log in"), "{error}");
        assert!(error.contains("hall.users.toml does not exist"), "{error}");
    }

    #[test]
    fn an_unknown_policy_and_an_unknown_key_are_errors() {
        assert!(settings("policies = [\"Basic256\"]").unwrap_err().contains("Basic256Sha256"));
        assert!(settings("port = 4840").unwrap_err().contains("unknown field `port`"));
    }
}
