//! `[epics]`.

use super::super::error::{ConfigProblem, Located};
use super::write::WriteToml;
use profivac_station::config::gateways::epics::{
    Interface, MAX_NAME, OnInvalid, PLACES, Preset, ReadingState, Settings, Severity, size_of,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// The port of Channel Access, for search (UDP) and circuits (TCP). Beacons go to the next one.
const CA_PORT: u16 = 5064;

/// The port of PV Access for circuits (TCP).
const PVA_PORT: u16 = 5075;

/// The port of PV Access for search and beacons (UDP).
const PVA_SEARCH_PORT: u16 = 5076;

/// The default of `name`.
const NAME: &str = "{prefix}{GAUGE}:{signal}";

/// The longest unit in Channel Access, in octets without the end mark.
const MAX_UNIT: usize = 7;

/// `[epics]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EpicsToml {
    /// Channel Access. Default: `true`.
    ca: Option<Spanned<bool>>,
    /// PV Access. Default: `true`.
    pva: Option<bool>,
    /// Where it listens: `192.168.1.5/24` answers searches by broadcast too, `0.0.0.0` is everywhere. Default: `["127.0.0.1"]`.
    interfaces: Option<Spanned<Vec<Spanned<String>>>>,
    /// The port of Channel Access, UDP and TCP; beacons go to the next one. Default: 5064.
    ca_port: Option<u16>,
    /// The port of PV Access over TCP. Default: 5075.
    pva_port: Option<u16>,
    /// The port of searches of PV Access over UDP. Default: 5076.
    pva_search_port: Option<u16>,
    /// The template of names, with `{prefix}`, `{station}`, `{segment}`, `{gauge}`, `{GAUGE}`, `{address}`, `{device}`, `{channel}`,
    /// `{signal}`. Default: `{prefix}{GAUGE}:{signal}`.
    name: Option<Spanned<String>>,
    /// What all names begin with.
    prefix: Option<Spanned<String>>,
    /// `Pa`, `hPa`, `kPa`, `mbar`, `bar`, `ubar`, `Torr`, `mTorr`, `micron`; `EGU` is spelled as here. Default: `mbar`.
    unit: Option<Spanned<String>>,
    /// The value of a reading without a pressure: `nan` (default), or `hold` for the last one with the severity INVALID.
    on_invalid: Option<OnInvalidToml>,
    /// Severities that differ from the default.
    #[serde(default)]
    severity: SeverityToml,
    /// The names of signals as at a facility: `isis`, `dls`, `nsls2`, `lcls`, `ess`, `sirius`.
    preset: Option<Preset>,
    /// Names of signals, by the key of the signal; they precede those of `preset`.
    #[serde(default)]
    signals: BTreeMap<String, Spanned<String>>,
    /// Further names, each for `gauge.signal`.
    #[serde(default)]
    alias: BTreeMap<Spanned<String>, String>,
    /// Which clients write; without the table they only read.
    write: Option<WriteToml>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum OnInvalidToml {
    Nan,
    Hold,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct SeverityToml {
    /// Below the range. Default: `none`.
    underrange: Option<Severity>,
    /// Above the range. Default: `minor`.
    overrange: Option<Severity>,
    /// Switched off. Default: `minor`.
    off: Option<Severity>,
    /// Not measured yet. Default: `invalid`.
    starting: Option<Severity>,
    /// Invalid. Default: `invalid`.
    invalid: Option<Severity>,
    /// No gauge at the channel. Default: `invalid`.
    not_present: Option<Severity>,
    /// Nothing was received. Default: `invalid`.
    gap: Option<Severity>,
    /// The gauge reports a fault. Default: `invalid`.
    fault: Option<Severity>,
}

impl SeverityToml {
    fn into_map(self) -> BTreeMap<ReadingState, Severity> {
        let rows = [
            (ReadingState::Underrange, self.underrange),
            (ReadingState::Overrange, self.overrange),
            (ReadingState::Off, self.off),
            (ReadingState::Starting, self.starting),
            (ReadingState::Invalid, self.invalid),
            (ReadingState::NotPresent, self.not_present),
            (ReadingState::Gap, self.gap),
            (ReadingState::Fault, self.fault),
        ];
        rows.into_iter().filter_map(|(state, severity)| Some((state, severity?))).collect()
    }
}

impl EpicsToml {
    /// The settings, with the defaults of the keys that are absent. `users` is the file of the users.
    pub fn into_settings(self, users: &Path) -> Result<Settings, Located> {
        let pva = self.pva.unwrap_or(true);
        if let Some(ca) = self.ca.as_ref().filter(|ca| !ca.get_ref() && !pva) {
            return Err(wrong(
                ca.span(),
                "ca = true or pva = true; delete [epics] to switch the gateway off",
                "neither",
            ));
        }
        let ca = self.ca.is_none_or(Spanned::into_inner);
        let name = self.name.map_or_else(|| Ok(NAME.to_owned()), checked_template)?;
        let prefix = self.prefix.map_or_else(|| Ok(String::new()), checked_part)?;
        let unit = self.unit.map_or_else(|| Ok("mbar".to_owned()), checked_unit)?;
        let signals = self.signals.into_iter().map(|(key, name)| Ok((key, checked_part(name)?)));
        let aliases = self.alias.into_iter().map(|(name, target)| Ok((checked_name(name)?, target)));
        Ok(Settings {
            ca_port: ca.then(|| self.ca_port.unwrap_or(CA_PORT)),
            pva_ports: pva
                .then(|| (self.pva_port.unwrap_or(PVA_PORT), self.pva_search_port.unwrap_or(PVA_SEARCH_PORT))),
            interfaces: interfaces(self.interfaces)?,
            name,
            prefix,
            unit,
            on_invalid: match self.on_invalid {
                Some(OnInvalidToml::Hold) => OnInvalid::Hold,
                Some(OnInvalidToml::Nan) | None => OnInvalid::Nan,
            },
            severities: self.severity.into_map(),
            preset: self.preset,
            signals: signals.collect::<Result<_, Located>>()?,
            aliases: aliases.collect::<Result<_, Located>>()?,
            write: self.write.map(|write| write.into_settings(users)).transpose()?,
        })
    }
}

fn wrong(span: Range<usize>, expected: &'static str, found: &str) -> Located {
    Located::new(span, ConfigProblem::Gateway { expected, found: found.to_owned() })
}

fn interfaces(given: Option<Spanned<Vec<Spanned<String>>>>) -> Result<Vec<Interface>, Located> {
    let Some(given) = given else { return Ok(vec![Interface { address: Ipv4Addr::LOCALHOST, broadcast: None }]) };
    let span = given.span();
    let interfaces: Vec<_> = given.into_inner().into_iter().map(interface).collect::<Result<_, _>>()?;
    if interfaces.is_empty() {
        return Err(wrong(span, "at least one address, such as \"127.0.0.1\"", "none"));
    }
    Ok(interfaces)
}

fn interface(text: Spanned<String>) -> Result<Interface, Located> {
    const EXPECTED: &str = "an IPv4 address of this computer, with the length of the network's prefix if clients search by broadcast, \
                            such as \"192.168.1.5/24\"";
    let parse = |text: &str| {
        let (address, length) = text.split_once('/').map_or((text, None), |(address, length)| (address, Some(length)));
        let address: Ipv4Addr = address.parse().ok()?;
        let Some(length) = length else { return Some(Interface { address, broadcast: None }) };
        let length: u32 = length.parse().ok().filter(|length| (1..=30).contains(length))?;
        let hosts = u32::MAX.checked_shr(length)?;
        Some(Interface { address, broadcast: Some(Ipv4Addr::from(u32::from(address) | hosts)) })
    };
    parse(text.get_ref()).ok_or_else(|| wrong(text.span(), EXPECTED, text.get_ref()))
}

fn checked_unit(unit: Spanned<String>) -> Result<String, Located> {
    let is_usable = unit.get_ref().len() <= MAX_UNIT && size_of(unit.get_ref()).is_some();
    if is_usable {
        Ok(unit.into_inner())
    } else {
        Err(wrong(
            unit.span(),
            "one of Pa, hPa, kPa, mbar, bar, ubar, Torr, mTorr, micron, in upper or lower case",
            unit.get_ref(),
        ))
    }
}

/// Whether a record's name may have a character. A point separates the field.
fn is_of_name(character: char) -> bool {
    character.is_ascii_alphanumeric() || "_-+:[]<>;{}/".contains(character)
}

/// A part of a name.
fn checked_part(part: Spanned<String>) -> Result<String, Located> {
    if part.get_ref().chars().all(is_of_name) {
        Ok(part.into_inner())
    } else {
        Err(wrong(
            part.span(),
            "letters, digits and _ - + : [ ] < > ; { } / (a point separates the field)",
            part.get_ref(),
        ))
    }
}

/// A complete name.
fn checked_name(name: Spanned<String>) -> Result<String, Located> {
    if name.get_ref().is_empty() || name.get_ref().len() > MAX_NAME {
        return Err(wrong(name.span(), "a name of 1 to 60 characters", name.get_ref()));
    }
    checked_part(name)
}

/// A template: parts of names and places in braces, one of them `{signal}`.
fn checked_template(template: Spanned<String>) -> Result<String, Located> {
    const EXPECTED: &str = "a name with {signal} and other places out of {prefix} {station} {segment} {gauge} {GAUGE} {address} {device} \
                            {channel}";
    let mut rest = template.get_ref().clone();
    for place in PLACES {
        rest = rest.replace(&format!("{{{place}}}"), "");
    }
    let has_signal = rest.contains("{signal}");
    let rest = rest.replace("{signal}", "");
    if has_signal && rest.chars().all(|character| is_of_name(character) && !"{}".contains(character)) {
        Ok(template.into_inner())
    } else {
        Err(wrong(template.span(), EXPECTED, template.get_ref()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ConfigError;
    use profivac_station::config::gateways::GatewaySettings;
    use profivac_web_server::auth::Role;
    use profivac_web_server::auth::users::Users;

    fn parse(table: &str) -> Result<Settings, ConfigError> {
        let text = format!(
            "[[segment]]\nname = 'hall'\nport = '/dev/ttyUSB0'\n[[segment.gauge]]\nname = 'a'\naddress = 5\ndevice = 'bcg450'\n[epics]\n{table}"
        );
        let config = crate::parse(&text, Path::new("plant.toml"))?;
        let [GatewaySettings::Epics(settings)] = &config.gateways[..] else { panic!("one gateway") };
        Ok(settings.clone())
    }

    #[test]
    fn an_empty_table_listens_on_loopback_at_the_ports_of_epics() {
        let settings = parse("").unwrap();
        assert_eq!((settings.ca_port, settings.pva_ports), (Some(5064), Some((5075, 5076))));
        assert_eq!(settings.interfaces, [Interface { address: Ipv4Addr::LOCALHOST, broadcast: None }]);
        assert_eq!((settings.name.as_str(), settings.prefix.as_str(), settings.unit.as_str()), (NAME, "", "mbar"));
        assert!(!settings.is_open_to_network() && (settings.unit_pa() - 100.0).abs() < f64::EPSILON);
    }

    #[test]
    fn every_key_reaches_its_setting() {
        let settings = parse(
            "ca = false\npva-port = 6075\npva-search-port = 6076\ninterfaces = ['192.168.1.5/24']\nname = '{segment}:{gauge}:{signal}'\n\
             prefix = 'VAC:'\nunit = 'Torr'\non-invalid = 'hold'\nseverity = { underrange = 'minor', not-present = 'none' }\n\
             preset = 'lcls'\nsignals = { state = 'STA' }\n[epics.alias]\n'FE:C06B-VA{CCG:1}P-I' = 'chamber.pressure'",
        )
        .unwrap();
        assert_eq!((settings.ca_port, settings.pva_ports), (None, Some((6075, 6076))));
        assert_eq!(settings.interfaces[0].broadcast, Some(Ipv4Addr::new(192, 168, 1, 255)));
        assert!(settings.is_open_to_network() && (settings.unit_pa() - 133.322_368).abs() < 1e-6);
        assert_eq!(settings.severities[&ReadingState::Underrange], Severity::Minor);
        assert_eq!(settings.severities[&ReadingState::NotPresent], Severity::None);
        assert_eq!((settings.preset, settings.on_invalid), (Some(Preset::Lcls), OnInvalid::Hold));
        assert_eq!(settings.signals["state"], "STA");
        assert_eq!(settings.aliases["FE:C06B-VA{CCG:1}P-I"], "chamber.pressure");
    }

    #[test]
    fn a_gateway_in_the_network_is_a_notice() {
        let notices = |table: &str| {
            let text = format!(
                "[[segment]]\nname = 'hall'\nport = 'x'\n[[segment.gauge]]\nname = 'a'\naddress = 5\ndevice = 'bcg450'\n[epics]\n{table}"
            );
            let config = crate::parse(&text, Path::new("plant.toml")).unwrap();
            crate::notices(&config).iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert!(notices("").is_empty() && notices("interfaces = ['127.0.0.1']").is_empty());
        let open = notices("interfaces = ['0.0.0.0']");
        assert!(open[0].starts_with("[epics] listens on 0.0.0.0 without encryption and login"), "{open:?}");
    }

    #[test]
    fn writing_needs_a_user_who_may_control() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.toml");
        let parse = |table: &str| {
            let text = format!(
                "[[segment]]\nname = 'hall'\nport = 'x'\n[[segment.gauge]]\nname = 'a'\naddress = 5\ndevice = 'bcg450'\n[epics]\n{table}"
            );
            crate::parse(&text, &path)
        };
        let write = |user: &str| format!("write = {{ user = '{user}' }}");
        let error = parse(&write("epics")).unwrap_err().to_string();
        assert!(
            error.contains("plant.toml:9:18: expected an operator or engineer") && error.contains("does not exist"),
            "{error}"
        );
        let hash = profivac_web_server::auth::password::Hash::of("a password of some length").unwrap();
        Users::change(&folder.path().join("plant.users.toml"), |users| {
            users.add("watch", Role::Viewer, hash.clone())?;
            users.add("epics", Role::Operator, hash)
        })
        .unwrap();
        assert!(parse(&write("stranger")).unwrap_err().to_string().contains("stranger, who is not in"));
        assert!(parse(&write("watch")).unwrap_err().to_string().contains("watch, who is viewer in"));
        let config = parse(&write("epics")).unwrap();
        let written = config.gateways[0].writer().unwrap();
        assert_eq!(written.user, "epics");
        assert!(written.permits("127.0.0.1".parse().unwrap()) && !written.permits("10.0.0.1".parse().unwrap()));
        let notices: Vec<_> = crate::notices(&config).iter().map(ToString::to_string).collect();
        assert!(notices[0].starts_with("[epics] lets programs on 127.0.0.1/8 write as the user epics"), "{notices:?}");
        let config = parse("write = { user = 'epics', clients = ['10.0.0.0/8'] }").unwrap();
        assert!(config.gateways[0].writer().unwrap().permits("10.0.0.1".parse().unwrap()));
        assert!(parse("write = { user = 'epics', host = 'x' }").unwrap_err().to_string().contains("unknown field"));
    }

    #[test]
    fn a_wrong_value_has_its_position_and_what_is_expected() {
        let rows = [
            ("unit = 'parsec'", "9:8", "expected one of Pa"),
            ("interfaces = []", "9:14", "expected at least one address"),
            ("interfaces = ['::1']", "9:15", "expected an IPv4 address"),
            ("interfaces = ['10.0.0.1/99']", "9:15", "expected an IPv4 address"),
            ("prefix = 'VAC.'", "9:10", "a point separates the field"),
            ("name = '{gague}:{signal}'", "9:8", "expected a name with {signal}"),
            ("name = '{gauge}'", "9:8", "expected a name with {signal}"),
            ("ca = false\npva = false", "9:6", "delete [epics]"),
            ("prot = 1", "9:1", "unknown field"),
            ("severity = { under = 'none' }", "9:14", "unknown field"),
            ("severity = { off = 'loud' }", "9:20", "unknown variant"),
            ("preset = 'cern'", "9:10", "unknown variant"),
            ("[epics.alias]\n'A.B' = 'chamber.pressure'", "10:1", "a point separates the field"),
        ];
        for (table, place, text) in rows {
            let error = parse(table).unwrap_err();
            assert!(error.to_string().starts_with(&format!("plant.toml:{place}:")), "{table}: {error}");
            assert!(error.to_string().contains(text), "{table}: {error}");
        }
    }
}
