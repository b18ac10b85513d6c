//! What a rule expects of the slave, and why a rule was not tested. The sentences are composed here and nowhere else.

use profivac_wire::diag::StationStatus;
use std::fmt;

/// The expectation that a slave did not meet.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Expected {
    /// No answer, for this reason.
    Silence(Unanswered),
    /// A valid answer within the slot time.
    Answer,
    /// SD1 with status OK.
    FdlStatus,
    /// The station type of a passive station in FC.
    PassiveStation,
    /// These addresses in the answer.
    Addresses {
        /// Destination: the requester.
        da: u8,
        /// Source: the slave.
        sa: u8,
    },
    /// These access points in the answer.
    AccessPoints {
        /// Destination: that of the requester.
        dsap: Option<u8>,
        /// Source: that of the slave.
        ssap: Option<u8>,
    },
    /// SC, or SD1 with NR.
    Acknowledgement,
    /// RS, for this reason.
    Closed(Closed),
    /// Data of low priority.
    DataLow,
    /// As many octets.
    Octets(usize),
    /// These octets of data.
    Image(Vec<u8>),
    /// The telegram of the answer before, octet by octet.
    SameAnswer(Vec<u8>),
    /// An answer of its own, and not the telegram of the answer before.
    NewAnswer,
    /// A diagnosis of 6 to 244 octets.
    Diagnosis,
    /// These bits in the diagnosis.
    Bits {
        /// The bits.
        bits: StationStatus,
        /// Whether they are 1.
        set: bool,
    },
    /// This octet as Diag_Master_Add.
    MasterAdd(u8),
    /// This Ident_Number in the diagnosis.
    Ident(u16),
    /// Blocks of Ext_Diag_Data that end with the diagnosis.
    DiagnosisBlocks,
    /// The identifiers of a configuration.
    Configuration,
    /// A configuration in which no identifier has the number 15 of manufacturer octets.
    ClosedConfiguration,
    /// Inputs as the answer to Data_Exchange within a second after Chk_Cfg.
    Ready,
    /// Inputs as the answer to Data_Exchange.
    Exchange,
    /// No inputs as the answer to Data_Exchange.
    NoExchange,
    /// DL without a pending diagnosis: the owner has read it.
    NotAnnounced,
    /// A PDU of DP-V1.
    Pdu(Pdu),
    /// A record length from 1 to 240.
    RecordLength,
    /// A diagnosis of at most this many octets, as the GSD file states.
    DiagnosisUpTo(usize),
    /// This service, as the GSD file states.
    Stated(Service),
}

/// The reason why no station may answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unanswered {
    /// The octet with this number is altered.
    Altered(usize),
    /// Only this many octets were sent.
    CutOff(usize),
    /// The telegram is for another station.
    OtherStation,
    /// The telegram is for all stations.
    Broadcast,
    /// The source is the slave itself.
    OwnSource,
    /// 127 is not the address of a station.
    BroadcastSource,
    /// It is a token.
    Token,
    /// It is SC.
    ShortAck,
    /// It is a response.
    Response,
    /// SDN has no answer.
    Unconfirmed,
    /// The telegram is damaged.
    Damaged,
}

/// The reason why a service answers RS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Closed {
    /// No service has this access point.
    NoSuchAccessPoint(u8),
    /// The slave is not in data exchange.
    NotExchanging,
    /// The slave is in data exchange.
    Exchanging,
    /// The service belongs to the owner of the slave.
    OtherMaster,
    /// The connection belongs to another access point.
    OtherAccessPoint,
    /// The connection is closed.
    NoConnection,
}

/// A PDU of DP-V1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pdu {
    /// The answer of the resource manager.
    ResourceManager,
    /// The positive response to Initiate.
    Initiate,
    /// The response to Idle: its own octet.
    Idle,
    /// The negative response to Read.
    ReadRefusal,
    /// An error of DP-V1 in a negative response.
    Dpv1Error,
    /// An error of the access class in a negative response.
    AccessError,
    /// Abort.
    Abort,
    /// Any response.
    Response,
}

/// The reason why a rule was not tested.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The slave breaks the rule with this name, without which this rule cannot be tested.
    After(&'static str),
    /// The rule with this name, without which this rule cannot be tested, was not tested on a line that disturbs the tests.
    Undecided(&'static str),
    /// The line or the computer has disturbed the test and each repetition of it: damaged octets, octets behind the slot time, or a
    /// stall.
    Disturbed,
    /// Repetitions of the test had different results.
    Varies,
    /// The slave did not do this when the test was prepared.
    Unprepared(Expected),
    /// The slave does not have this service.
    Without(Service),
    /// The slave does not answer any more, so its silence proves nothing.
    Silent,
    /// The link does not send the requests that the rule needs: they change the slave.
    NeedsWrites,
    /// The slave accepts other configurations.
    Adapts,
    /// The slave sends responses of DP-V1 at once, so none waits for a poll.
    RespondsAtOnce,
    /// The inputs change, so two of them cannot be compared.
    InputsChange,
    /// The GSD file does not state it, or the user parameters do not enable it.
    NotStated,
}

/// A service that a slave may lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Service {
    /// MS1: access point 51 is closed during data exchange.
    Ms1,
    /// MS2: access point 49 is closed.
    Ms2,
    /// RD_Inp: access point 56 is closed during data exchange.
    RdInp,
    /// RD_Outp: access point 57 is closed during data exchange.
    RdOutp,
    /// Sync: Not_Supported after Sync_Req.
    Sync,
    /// Freeze: Not_Supported after Freeze_Req.
    Freeze,
}

impl Expected {
    /// `bits` are 1.
    #[must_use]
    pub const fn set(bits: StationStatus) -> Self {
        Self::Bits { bits, set: true }
    }

    /// `bits` are 0.
    #[must_use]
    pub const fn clear(bits: StationStatus) -> Self {
        Self::Bits { bits, set: false }
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silence(reason) => write!(f, "no answer: {reason}"),
            Self::Answer => f.write_str("a valid answer within the slot time"),
            Self::FdlStatus => f.write_str("SD1 with status OK (0 in bits 0 to 3, 6 and 7 of FC)"),
            Self::PassiveStation => f.write_str("00 in bits 4 and 5 of FC: a passive station"),
            Self::Addresses { da, sa } => {
                write!(f, "destination {da} and source {sa}, the addresses of the request swapped")
            }
            Self::AccessPoints { dsap, ssap } => {
                let number = |sap: &Option<u8>| sap.map_or_else(|| "none".to_owned(), |sap| sap.to_string());
                write!(f, "DSAP {} and SSAP {}, the access points of the request swapped", number(dsap), number(ssap))
            }
            Self::Acknowledgement => f.write_str("SC"),
            Self::Closed(reason) => write!(f, "RS: {reason}"),
            Self::DataLow => f.write_str("DL: responses of DP-V1 have low priority"),
            Self::Octets(0) => f.write_str("no data: SC, or DH without data"),
            Self::Octets(count) => write!(f, "DL or DH with {count} octets"),
            Self::Image(octets) => write!(f, "the octets {}", Hex(octets)),
            Self::SameAnswer(octets) => write!(f, "the answer before once more: {}", Hex(octets)),
            Self::NewAnswer => f.write_str("an answer of its own, not the answer before once more"),
            Self::Diagnosis => f.write_str("DL with a diagnosis of 6 to 244 octets"),
            Self::Bits { bits, set } => write!(f, "{} in {}", u8::from(*set), BitNames(*bits)),
            Self::MasterAdd(0xFF) => f.write_str("FF (no master) as Diag_Master_Add"),
            Self::MasterAdd(master) => write!(f, "{master:02X} (master {master}) as Diag_Master_Add"),
            Self::Ident(ident) => write!(f, "{ident:04X} as Ident_Number"),
            Self::DiagnosisBlocks => f.write_str("blocks of Ext_Diag_Data whose lengths end with the diagnosis"),
            Self::Configuration => f.write_str("DL with the identifiers of a configuration"),
            Self::ClosedConfiguration => f.write_str("identifiers with 0 to 14 manufacturer octets"),
            Self::Ready => f.write_str("SC, DL or DH as the answer to Data_Exchange, within a second after Chk_Cfg"),
            Self::Exchange => f.write_str("SC, DL or DH: the slave is in data exchange with this master"),
            Self::NoExchange => f.write_str("no data and no SC: the slave is not in data exchange with this master"),
            Self::NotAnnounced => f.write_str("DL or SC: the owner has read the diagnosis"),
            Self::Pdu(pdu) => pdu.fmt(f),
            Self::RecordLength => f.write_str("a Max_Len_Data_Unit from 1 to 240"),
            Self::DiagnosisUpTo(most) => write!(f, "a diagnosis of at most {most} octets, as the GSD file states"),
            Self::Stated(service) => {
                let service = service.to_string();
                let (name, _) = service.split_once(':').unwrap_or((&service, ""));
                write!(f, "{}, as the GSD file states", name.trim_end_matches(" with these parameters"))
            }
        }
    }
}

impl fmt::Display for Unanswered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Altered(index) => write!(f, "octet {index} of the telegram is altered (the first one is octet 0)"),
            Self::CutOff(count) => write!(f, "only the first {count} octets of the telegram were sent"),
            Self::OtherStation => f.write_str("the telegram is for another station"),
            Self::Broadcast => f.write_str("the telegram is for all stations"),
            Self::OwnSource => f.write_str("the source is the address of the slave itself"),
            Self::BroadcastSource => f.write_str("127 is not the address of a station"),
            Self::Token => f.write_str("a slave does not answer a token"),
            Self::ShortAck => f.write_str("SC is not a request"),
            Self::Response => f.write_str("a response is not a request"),
            Self::Unconfirmed => f.write_str("a slave does not answer SDN"),
            Self::Damaged => f.write_str("the telegram is damaged"),
        }
    }
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchAccessPoint(sap) => write!(f, "no service has access point {sap}"),
            Self::NotExchanging => f.write_str("the slave is not in data exchange"),
            Self::Exchanging => f.write_str("the slave is in data exchange"),
            Self::OtherMaster => f.write_str("another master than the partner sent the request"),
            Self::OtherAccessPoint => f.write_str("the request has another source access point than the partner"),
            Self::NoConnection => f.write_str("the connection is closed"),
        }
    }
}

impl fmt::Display for Pdu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ResourceManager => "56, the answer of the resource manager, with a Server_SAP from 0 to 48",
            Self::Initiate => "57, a positive response to Initiate",
            Self::Idle => "48, the octet of Idle",
            Self::ReadRefusal => "DE and three octets, a negative response to Read",
            Self::Dpv1Error => "80 as Error_Decode, an error of DP-V1",
            Self::AccessError => "an error of the access class, like B2 (invalid slot)",
            Self::Abort => "58, Abort",
            Self::Response => "SC until the response is there, then DL with a response of DP-V1",
        })
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::After(rule) => write!(f, "the slave breaks {rule}"),
            Self::Undecided(rule) => write!(f, "it needs {rule}, which was not tested"),
            Self::Disturbed => f.write_str(
                "in every repetition the line delivered damaged or late octets, or the computer stopped the program; the \
                 cause may be the line, the port or the computer",
            ),
            Self::Varies => f.write_str("repetitions of the test had different results"),
            Self::Unprepared(expected) => write!(f, "the preparation expected {expected}"),
            Self::Without(service) => write!(f, "the slave has no {service}"),
            Self::Silent => f.write_str("the slave does not answer any more"),
            Self::NeedsWrites => f.write_str("it needs requests that change the slave"),
            Self::Adapts => f.write_str("the slave adapts itself to other configurations"),
            Self::RespondsAtOnce => f.write_str("the slave sends responses at once, so none waits for a poll"),
            Self::InputsChange => f.write_str("the inputs change from one request to the next"),
            Self::NotStated => f.write_str("the GSD file does not state it, or the user parameters do not enable it"),
        }
    }
}

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ms1 => "MS1 with these parameters: access point 51 is closed during data exchange",
            Self::Ms2 => "MS2: access point 49 is closed",
            Self::RdInp => "RD_Inp: access point 56 is closed during data exchange",
            Self::RdOutp => "RD_Outp: access point 57 is closed during data exchange",
            Self::Sync => "Sync: it reports Not_Supported",
            Self::Freeze => "Freeze: it reports Not_Supported",
        })
    }
}

/// Octets in hex.
struct Hex<'a>(&'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, octet) in self.0.iter().enumerate() {
            let space = if number == 0 { "" } else { " " };
            write!(f, "{space}{octet:02X}")?;
        }
        Ok(())
    }
}

/// The names of bits of Station_Status in the words of profibus-wire 2.3.
struct BitNames(StationStatus);

impl fmt::Display for BitNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names: Vec<_> = self.0.names().collect();
        if self.0.contains(StationStatus::ALWAYS_ONE) {
            names.push("bit 2 of the second octet");
        }
        if !self.0.reserved().is_empty() {
            names.push("the reserved bits");
        }
        f.write_str(&names.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_named_as_in_the_reference() {
        let bits = StationStatus::PRM_REQ | StationStatus::PRM_FAULT;
        assert_eq!(Expected::set(bits).to_string(), "1 in Prm_Fault, Prm_Req");
        assert_eq!(Expected::set(StationStatus::ALWAYS_ONE).to_string(), "1 in bit 2 of the second octet");
        let reserved = StationStatus::from_bits_retain(1 << 16);
        assert_eq!(Expected::clear(reserved).to_string(), "0 in the reserved bits");
    }

    #[test]
    fn an_answer_without_access_points_is_said_to_have_none() {
        let expected = Expected::AccessPoints { dsap: Some(62), ssap: Some(60) };
        assert_eq!(expected.to_string(), "DSAP 62 and SSAP 60, the access points of the request swapped");
        let expected = Expected::AccessPoints { dsap: None, ssap: None };
        assert_eq!(expected.to_string(), "DSAP none and SSAP none, the access points of the request swapped");
    }

    #[test]
    fn a_reason_names_the_rule_or_the_service() {
        let reason = Reason::After("start-up.exchange");
        assert_eq!(reason.to_string(), "the slave breaks start-up.exchange");
        assert_eq!(Reason::Without(Service::Ms2).to_string(), "the slave has no MS2: access point 49 is closed");
    }
}
