//! Descriptions of telegrams: sender, receiver, service, content.
//!
//! Each telegram is described by itself, without the previous ones. An answer with data and without access points is
//! described as Data_Exchange, the only service with such answers.

mod acyclic;

use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg;
use profivac_wire::control::{Control, FrameCount, Function, StationType, Status};
use profivac_wire::diag::{NO_MASTER, SlaveDiag};
use profivac_wire::global::{ControlCommand, GlobalControl};
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::{BROADCAST, DataTelegram, Sap, Telegram};
use std::fmt;

/// Octets as hexadecimal text: `68 05 05 68`.
#[derive(Clone, Copy, Debug)]
pub struct Hex<'a>(pub &'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, octet) in self.0.iter().enumerate() {
            let space = if index == 0 { "" } else { " " };
            write!(f, "{space}{octet:02X}")?;
        }
        Ok(())
    }
}

/// Parses two hexadecimal digits.
#[must_use]
pub fn octet(digits: &str) -> Option<u8> {
    let two = digits.len() == 2 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    u8::from_str_radix(digits, 16).ok().filter(|_| two)
}

/// A telegram in columns: addresses, service, content.
#[derive(Clone, Copy, Debug)]
pub struct Description<'a>(pub &'a Telegram<'a>);

impl fmt::Display for Description<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Telegram::ShortAck => write!(f, "{:10}  SC", ""),
            Telegram::Token { da, sa } => write!(f, "{}  Token", Route(*sa, *da)),
            Telegram::Data(telegram) => {
                write!(f, "{}  ", Route(telegram.sa, telegram.da))?;
                match telegram.control() {
                    Control::Request { function, count } => request(f, telegram, function, count),
                    Control::Response { station, status } => response(f, telegram, station, status),
                }
            }
        }
    }
}

/// `  2 -> 8  `, with `all` for the broadcast address.
struct Route(u8, u8);

impl fmt::Display for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self(sa, BROADCAST) => write!(f, "{sa:3} -> all"),
            Self(sa, da) => write!(f, "{sa:3} -> {da:<3}"),
        }
    }
}

fn request(
    f: &mut fmt::Formatter<'_>,
    telegram: &DataTelegram<'_>,
    function: Function,
    count: FrameCount,
) -> fmt::Result {
    match function {
        Function::SrdLow | Function::SrdHigh | Function::SdnLow | Function::SdnHigh => {
            let sap = Sap::from_octet(telegram.dsap);
            write!(f, "{:16} {:6}", Service(sap).to_string(), counted(count))?;
            request_data(f, sap, telegram.du)
        }
        Function::FdlStatus => f.write_str("FDL_Status ?"),
        Function::Ident => f.write_str("Ident ?"),
        Function::LsapStatus => write!(f, "LSAP_Status ?{}", data(telegram.du)),
        Function::SdaLow | Function::SdaHigh => write!(f, "SDA {}{}", counted(count), data(telegram.du)),
        Function::Other(_) => write!(f, "request {:02X}{}", telegram.fc, data(telegram.du)),
    }
}

const fn counted(count: FrameCount) -> &'static str {
    match count {
        FrameCount::Uncounted => "",
        FrameCount::First => "first",
        FrameCount::Counted(false) => "FCB 0",
        FrameCount::Counted(true) => "FCB 1",
    }
}

/// The name of a service.
#[derive(Clone, Copy, Debug)]
pub struct Service(pub Sap);

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            Sap::Default => "Data_Exchange",
            Sap::Ms2(connection) => return write!(f, "MS2 SAP {connection}"),
            Sap::ResourceManager => "MS2 Initiate",
            Sap::Alarm => "MS1 Alarm",
            Sap::Ms1 => "MS1",
            Sap::SetExtPrm => "Set_Ext_Prm",
            Sap::SetSlaveAdd => "Set_Slave_Add",
            Sap::RdInp => "RD_Inp",
            Sap::RdOutp => "RD_Outp",
            Sap::GlobalControl => "Global_Control",
            Sap::GetCfg => "Get_Cfg",
            Sap::SlaveDiag => "Slave_Diag",
            Sap::SetPrm => "Set_Prm",
            Sap::ChkCfg => "Chk_Cfg",
            Sap::Other(other) => return write!(f, "SAP {other}"),
        })
    }
}

/// Describes the data of a request. Data that do not fit the service are shown as octets.
fn request_data(f: &mut fmt::Formatter<'_>, sap: Sap, du: &[u8]) -> fmt::Result {
    let words = match sap {
        Sap::SetPrm => SetPrm::parse(du).ok().map(|prm| set_prm(&prm)),
        Sap::ChkCfg => Some(configuration(du)),
        Sap::GlobalControl => GlobalControl::parse(du).ok().map(global_control),
        Sap::SetSlaveAdd => SetSlaveAdd::parse(du).ok().map(|wanted| set_slave_add(&wanted)),
        Sap::Ms1 | Sap::Alarm | Sap::ResourceManager | Sap::Ms2(_) => acyclic::request(du).ok(),
        Sap::Default | Sap::SetExtPrm | Sap::RdInp | Sap::RdOutp | Sap::GetCfg | Sap::SlaveDiag | Sap::Other(_) => None,
    };
    f.write_str(&words.unwrap_or_else(|| data(du)))
}

/// Describes the data of an answer.
fn response_data(f: &mut fmt::Formatter<'_>, sap: Sap, du: &[u8]) -> fmt::Result {
    let words = match sap {
        Sap::SlaveDiag => SlaveDiag::parse(du).ok().map(|diag| slave_diag(&diag)),
        Sap::GetCfg => Some(configuration(du)),
        Sap::Ms1 | Sap::Alarm | Sap::ResourceManager | Sap::Ms2(_) => acyclic::response(du).ok(),
        Sap::Default | Sap::SetPrm | Sap::ChkCfg | Sap::SetExtPrm | Sap::SetSlaveAdd => None,
        Sap::RdInp | Sap::RdOutp | Sap::GlobalControl | Sap::Other(_) => None,
    };
    f.write_str(&words.unwrap_or_else(|| data(du)))
}

/// Data as octets.
fn data(du: &[u8]) -> String {
    if du.is_empty() { String::new() } else { format!(" {}", Hex(du)) }
}

/// Describes the data unit of Set_Prm: the watchdog as its two factors.
#[must_use]
pub fn set_prm(prm: &SetPrm<'_>) -> String {
    let [first, second] = prm.wd_fact;
    set_prm_with_watchdog(prm, &format!("{first} x {second}"))
}

/// Describes the data unit of Set_Prm with this text as its watchdog time. A request without the watchdog does not show it.
#[must_use]
pub fn set_prm_with_watchdog(prm: &SetPrm<'_>, watchdog: &str) -> String {
    let mut words = listed(PRM_WORDS.iter().filter(|(bit, _)| prm.status.intersects(*bit)).map(|(_, word)| *word));
    if prm.status.contains(PrmStatus::WD_ON) {
        words += &format!(", watchdog {watchdog}");
    }
    if prm.min_tsdr != 0 {
        words += &format!(", min T_SDR {}", prm.min_tsdr);
    }
    words += &format!(", ident {:04X}, groups {:02X}", prm.ident, prm.group);
    if prm.user.is_empty() { words } else { format!("{words}, user {}", Hex(prm.user)) }
}

const PRM_WORDS: [(PrmStatus, &str); 5] = [
    (PrmStatus::LOCK_REQ, "lock"),
    (PrmStatus::UNLOCK_REQ, "unlock"),
    (PrmStatus::SYNC_REQ, "sync"),
    (PrmStatus::FREEZE_REQ, "freeze"),
    (PrmStatus::RESERVED, "reserved bits"),
];

fn configuration(octets: &[u8]) -> String {
    match cfg::lengths(octets) {
        Ok(lengths) => format!(" {} out, {} in: {}", lengths.outputs, lengths.inputs, Hex(octets)),
        Err(error) => format!(" {error}: {}", Hex(octets)),
    }
}

/// Describes the data unit of Global_Control.
#[must_use]
pub fn global_control(control: GlobalControl) -> String {
    let words = CONTROL_WORDS.iter().filter(|(bit, _)| control.command.intersects(*bit)).map(|(_, word)| *word);
    let words = if control.command.is_empty() { " Operate".to_owned() } else { listed(words) };
    if control.group == 0 { words } else { format!("{words}, groups {:02X}", control.group) }
}

const CONTROL_WORDS: [(ControlCommand, &str); 6] = [
    (ControlCommand::CLEAR_DATA, "Clear_Data"),
    (ControlCommand::UNFREEZE, "Unfreeze"),
    (ControlCommand::FREEZE, "Freeze"),
    (ControlCommand::UNSYNC, "Unsync"),
    (ControlCommand::SYNC, "Sync"),
    (ControlCommand::RESERVED, "reserved bits"),
];

fn set_slave_add(wanted: &SetSlaveAdd<'_>) -> String {
    let locked = if wanted.no_add_chg == 0 { "" } else { ", locked" };
    format!(" address {}, ident {:04X}{locked}{}", wanted.address, wanted.ident, data(wanted.rem_slave_data))
}

fn response(
    f: &mut fmt::Formatter<'_>,
    telegram: &DataTelegram<'_>,
    station: StationType,
    status: Status,
) -> fmt::Result {
    let name = match status {
        Status::Ok => return f.write_str(answer_of(station)),
        Status::UserError => "UE",
        Status::NoResource => "RR",
        Status::ServiceNotActivated => "RS",
        Status::DataLow => "DL",
        Status::NoReply => "NR",
        Status::DataHigh => "DH",
        Status::DataLowNotTaken => "RDL",
        Status::DataHighNotTaken => "RDH",
        Status::Other(_) => return write!(f, "answer {:02X}{}", telegram.fc, data(telegram.du)),
    };
    if telegram.ssap.is_none() && telegram.du.is_empty() {
        return f.write_str(name);
    }
    let sap = Sap::from_octet(telegram.ssap);
    write!(f, "{:16} {name:6}", Service(sap).to_string())?;
    response_data(f, sap, telegram.du)
}

/// Describes the answer to FDL_Status.
const fn answer_of(station: StationType) -> &'static str {
    match station {
        StationType::Slave => "OK, passive station",
        StationType::MasterNotReady => "OK, active station, not ready for the ring",
        StationType::MasterReady => "OK, active station, ready for the ring",
        StationType::MasterInRing => "OK, active station, in the ring",
    }
}

fn slave_diag(diag: &SlaveDiag<'_>) -> String {
    let mut words = match diag.master_add {
        NO_MASTER => " no master".to_owned(),
        master => format!(" master {master}"),
    };
    words += &format!(", ident {:04X}", diag.ident);
    for word in diag.status.names() {
        words = words + ", " + word;
    }
    if diag.ext_diag.is_empty() { words } else { format!("{words}, {}", Hex(diag.ext_diag)) }
}

/// ` one, two, three`
fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    format!(" {}", words.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialogue::hex;

    #[test]
    fn the_telegrams_of_the_specification_are_described() {
        for (text, words) in [
            ("E5", "            SC"),
            ("DC 02 02", "  2 -> 2    Token"),
            ("10 08 02 49 53 16", "  2 -> 8    FDL_Status ?"),
            ("10 02 08 00 0A 16", "  8 -> 2    OK, passive station"),
            ("10 02 08 03 0D 16", "  8 -> 2    RS"),
            ("68 05 05 68 88 82 6D 3C 3E F1 16", "  2 -> 8    Slave_Diag       first "),
            (
                "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16",
                "  8 -> 2    Slave_Diag       DL     no master, ident 1234, Station_Not_Ready, Prm_Req",
            ),
            (
                "68 0C 0C 68 88 82 5D 3D 3E 88 0A 0A 0B 12 34 01 D0 16",
                "  2 -> 8    Set_Prm          FCB 0  lock, watchdog 10 x 10, min T_SDR 11, ident 1234, groups 01",
            ),
            ("68 07 07 68 88 82 7D 3E 3E 11 21 35 16", "  2 -> 8    Chk_Cfg          FCB 1  2 out, 2 in: 11 21"),
            ("68 07 07 68 82 88 08 3E 3B 11 21 BD 16", "  8 -> 2    Get_Cfg          DL     2 out, 2 in: 11 21"),
            ("68 05 05 68 08 02 7D AA 55 86 16", "  2 -> 8    Data_Exchange    FCB 1  AA 55"),
            ("68 05 05 68 02 08 0A 01 02 17 16", "  8 -> 2    Data_Exchange    DH     01 02"),
            ("68 07 07 68 FF 82 46 3A 3E 00 00 3F 16", "  2 -> all  Global_Control          Operate"),
            ("68 07 07 68 FF 82 46 3A 3E 20 01 60 16", "  2 -> all  Global_Control          Sync, groups 01"),
            (
                "68 09 09 68 FE 82 6D 37 3E 08 12 34 00 B0 16",
                "  2 -> 126  Set_Slave_Add    first  address 8, ident 1234",
            ),
        ] {
            assert_eq!(Description(&Telegram::parse(&hex(text)).unwrap()).to_string(), words, "{text}");
        }
    }

    #[test]
    fn every_telegram_has_a_description() {
        let mut random = crate::Random::new(1);
        for fc in 0..=0xFF {
            for sap in (0..=0xFF).map(Some).chain([None]) {
                let du: Vec<u8> = (0..random.below(20)).map(|_| random.octet()).collect();
                let telegram = DataTelegram { da: 8, sa: 2, dsap: sap, ssap: sap, fc, du: &du };
                let words = Description(&Telegram::Data(telegram)).to_string();
                assert!(words.starts_with("  2 -> 8    ") && words.len() > 13, "{telegram:?}: {words}");
            }
        }
    }

    #[test]
    fn data_that_do_not_fit_the_service_are_shown_as_octets() {
        let telegram = DataTelegram { da: 8, sa: 2, dsap: Some(61), ssap: Some(62), fc: 0x5D, du: &[0x80, 1] };
        assert_eq!(Description(&Telegram::Data(telegram)).to_string(), "  2 -> 8    Set_Prm          FCB 0  80 01");
    }
}
