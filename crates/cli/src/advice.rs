//! The options and commands that help after an error of a library. A library knows the reason, the program knows its options.

use profivac_client::address::AddressError;
use profivac_client::names::TargetError;
use profivac_client::records::{RecordError, Unavailable};
use profivac_client::settings::SettingsFileError;
use profivac_client::{AccessReason, Advice, ClientError};
use profivac_devices::model::AccessPath;
use profivac_host::port::PortError;

/// What to do where octets arrive and no telegram is among them.
pub const NO_TELEGRAM: &str = "exchange the wires A and B, connect the grounds, check the termination at both ends; docs/adapters.md has the pins";

/// The error with what to do next.
pub fn sentence(error: &ClientError) -> String {
    format!("{error}{}", advice(error))
}

/// The error of a record with what to do next.
pub fn record_sentence(error: &RecordError) -> String {
    match error {
        RecordError::Unavailable(reason) => format!("{error}{}", other_path(reason)),
        _ => error.to_string(),
    }
}

fn advice(error: &ClientError) -> String {
    match error {
        ClientError::NoAnswer(_) => "; `profivac scan` shows the stations of the bus".to_owned(),
        ClientError::UnknownDevice { .. } => {
            "; `profivac read --octets SLOT/INDEX` reads the records of any slave with DP-V1".to_owned()
        }
        ClientError::Target(error) => unknown_name(error).to_owned(),
        ClientError::BeyondRange { .. } => "; to write it all the same add --force".to_owned(),
        ClientError::Access { reason: AccessReason::OtherPath { path, .. }, .. } => {
            format!("; say --via {}", option(*path))
        }
        ClientError::Access { reason: AccessReason::CyclicOnly { .. }, .. } => {
            "; `profivac monitor` shows those".to_owned()
        }
        ClientError::Refused { advice: Some(Advice::CheckRange), .. } => {
            "; `profivac list` shows the values it accepts".to_owned()
        }
        ClientError::Unavailable { reason, .. } => other_path(reason).to_owned(),
        _ => String::new(),
    }
}

/// The option that chooses a service.
const fn option(path: AccessPath) -> &'static str {
    match path {
        AccessPath::Class2 => "ms2",
        AccessPath::Class1 => "ms1",
        AccessPath::ParameterChannel => "pkw",
    }
}

/// Another service, if one may help.
const fn other_path(reason: &Unavailable) -> &'static str {
    match reason {
        Unavailable::NoDpv1 | Unavailable::NoMs1 | Unavailable::NothingReadable => "; say --via pkw",
        Unavailable::TooLongForChannel => "; say --via ms2",
        _ => "",
    }
}

/// What to do after a name that is unknown and similar to none.
fn unknown_name(error: &TargetError) -> &'static str {
    match error {
        TargetError::Unknown { alike, .. } if alike.is_empty() => "; `profivac list` shows all",
        _ => "",
    }
}

/// What to do after an error in a settings file.
pub fn after_settings_file(error: &SettingsFileError) -> &'static str {
    match error {
        SettingsFileError::UnknownParameter { error, .. } => unknown_name(error),
        _ => "",
    }
}

/// What to do after a change of an address.
pub const fn after_address_change(error: &AddressError) -> &'static str {
    match error {
        AddressError::Unconfirmed { .. } | AddressError::NotFound { .. } => "; `profivac scan` shows where it is",
        _ => "",
    }
}

/// What to do after an error of a port.
pub const fn after_port(error: &PortError) -> &'static str {
    match error {
        PortError::NoBaudRate(_) => ": give the rate as a number (--baud 19200)",
        _ => "",
    }
}
