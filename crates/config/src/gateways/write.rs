//! `write` in the table of a gateway: clients of a control system may write, as a user of the station.

use super::super::error::{ConfigProblem, Located};
use profivac_host::text_file::Parsed;
use profivac_station::config::gateways::modbus::Network;
use profivac_station::config::gateways::write::Write;
use profivac_web_server::auth::Role;
use profivac_web_server::auth::users::Users;
use serde::Deserialize;
use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;
use toml::Spanned;

/// `write` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WriteToml {
    /// The account of the station as which clients write, an operator or engineer.
    user: Spanned<String>,
    /// The computers that may write, as addresses or networks. Default: this computer.
    clients: Option<Vec<Parsed<Network>>>,
}

impl WriteToml {
    /// The settings. The user exists and may control; without `clients` only this computer writes.
    pub fn into_settings(self, users: &Path) -> Result<Write, Located> {
        let span = self.user.span();
        let user = self.user.into_inner();
        check_user(users, &user).map_err(|found| {
            let expected = "an operator or engineer of the file of the users, whom `profivac user add NAME --role operator FILE.toml` adds";
            Located::new(span, ConfigProblem::Gateway { expected, found })
        })?;
        let clients = match self.clients {
            Some(clients) => clients.into_iter().map(|network| network.0).collect(),
            None => vec![Network::of(IpAddr::V4(Ipv4Addr::LOCALHOST), 8)],
        };
        Ok(Write { user, users: users.to_owned(), clients })
    }
}

/// Checks that the user may control; the error says what was found.
fn check_user(users: &Path, name: &str) -> Result<(), String> {
    let file = users.display();
    let accounts = Users::read(users).map_err(|error| error.to_string())?;
    let account = accounts.get(name).ok_or_else(|| format!("{name}, who is not in {file}"))?;
    if account.role >= Role::Operator { Ok(()) } else { Err(format!("{name}, who is {} in {file}", account.role)) }
}
