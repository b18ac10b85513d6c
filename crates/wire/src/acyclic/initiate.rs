//! Initiate opens an MS2 connection of a class 2 master; the resource manager assigns the access point. profibus-wire 4.6.
//!
//! ```
//! use profivac_wire::acyclic::initiate::{AddAddr, Capabilities, Network};
//! use profivac_wire::acyclic::{Initiate, InitiateRes, Request, ResourceManager, Response};
//!
//! // The resource manager assigns access point 48; its slave needs a Send_Timeout of 1 s.
//! let Ok(Response::ResourceManager(answer)) = Response::parse(&[0x56, 48, 0, 100]) else { panic!("expected an answer") };
//! assert_eq!(answer, ResourceManager { server_sap: 48, min_send_timeout: 100 });
//!
//! let destination = AddAddr { network: Some(Network { address: [0; 6], mac: &[] }), ..AddAddr::default() };
//! let initiate = Initiate {
//!     send_timeout: answer.min_send_timeout,
//!     capabilities: Capabilities::READ_WRITE,
//!     source: AddAddr::default(),
//!     destination,
//! };
//! let mut out = [0; 32];
//! let length = Request::Initiate(initiate).emit(&mut out)?;
//! assert_eq!(Request::parse(&out[..length]), Ok(Request::Initiate(initiate)));
//!
//! // The slave exchanges the addresses, and says how long a record may be.
//! let response = InitiateRes {
//!     max_len_data_unit: 240,
//!     capabilities: Capabilities::READ_WRITE,
//!     source: initiate.destination,
//!     destination: initiate.source,
//! };
//! let length = Response::Initiate(response).emit(&mut out)?;
//! assert_eq!(Response::parse(&out[..length]), Ok(Response::Initiate(response)));
//! # Ok::<(), profivac_wire::TooLong>(())
//! ```

use super::function::{FieldError, Function, PduError};
use crate::octets::{Reader, TooLong, TooShort, Writer};

/// The capabilities of one side of a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Capabilities {
    /// Features_Supported_1 and _2; see [`DPV1_RW`](Self::DPV1_RW).
    pub features: [u8; 2],
    /// Profile_Features_Supported_1 and _2.
    pub profile_features: [u8; 2],
    /// Profile_Ident_Number, 0 for no profile.
    pub profile_ident: u16,
}

impl Capabilities {
    /// Bit 0 of Features_Supported_1: Read and Write.
    pub const DPV1_RW: u8 = 1;

    /// Read and Write, and no profile.
    pub const READ_WRITE: Self = Self { features: [Self::DPV1_RW, 0], profile_features: [0, 0], profile_ident: 0 };

    fn parse(reader: &mut Reader<'_>) -> Result<Self, TooShort> {
        Ok(Self {
            features: [reader.octet()?, reader.octet()?],
            profile_features: [reader.octet()?, reader.octet()?],
            profile_ident: reader.word()?,
        })
    }

    fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&self.features)?;
        writer.octets(&self.profile_features)?;
        writer.word(self.profile_ident)
    }
}

/// Add_Addr_Param: the additional address of an end point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AddAddr<'a> {
    /// API: number of the application process, 0 by default.
    pub api: u8,
    /// SCL: access level, 0 for none.
    pub scl: u8,
    /// Network address of an end point behind a gateway (type 1).
    pub network: Option<Network<'a>>,
}

/// The network address of an end point; only a gateway evaluates it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Network<'a> {
    /// Network address.
    pub address: [u8; 6],
    /// MAC address.
    pub mac: &'a [u8],
}

/// S_Type and S_Len, or D_Type and D_Len.
#[derive(Clone, Copy)]
struct Header {
    kind: u8,
    length: u8,
}

/// Length of API, SCL and a network address without MAC address.
const NETWORK_LENGTH: u8 = 8;

impl Header {
    fn parse(reader: &mut Reader<'_>) -> Result<Self, TooShort> {
        Ok(Self { kind: reader.octet()?, length: reader.octet()? })
    }

    /// Whether the length fits the type: 2 octets for type 0, at least 8 for type 1. Other types are not defined.
    const fn is_valid(self) -> bool {
        match self.kind {
            0 => self.length == 2,
            1 => self.length >= NETWORK_LENGTH,
            _ => false,
        }
    }

    fn address<'a>(self, reader: &mut Reader<'a>) -> Result<AddAddr<'a>, TooShort> {
        let mut octets = Reader::new(reader.take(usize::from(self.length))?);
        let (api, scl) = (octets.octet()?, octets.octet()?);
        let network = match self.kind {
            0 => None,
            _ => {
                let address = octets.take(6)?.try_into().map_err(|_| TooShort)?;
                Some(Network { address, mac: octets.rest() })
            }
        };
        Ok(AddAddr { api, scl, network })
    }
}

impl AddAddr<'_> {
    fn header(&self) -> Result<[u8; 2], TooLong> {
        let Some(network) = self.network else { return Ok([0, 2]) };
        let mac = u8::try_from(network.mac.len()).map_err(|_| TooLong)?;
        Ok([1, mac.checked_add(NETWORK_LENGTH).ok_or(TooLong)?])
    }

    fn emit(&self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.api, self.scl])?;
        let Some(network) = self.network else { return Ok(()) };
        writer.octets(&network.address)?;
        writer.octets(network.mac)
    }
}

/// Parses the source and the destination: both headers, then both addresses.
fn parse_addresses<'a>(function: Function, mut reader: Reader<'a>) -> Result<(AddAddr<'a>, AddAddr<'a>), PduError> {
    let length = |TooShort| PduError::Length(function);
    let source = Header::parse(&mut reader).map_err(length)?;
    let destination = Header::parse(&mut reader).map_err(length)?;
    if !source.is_valid() || !destination.is_valid() {
        return Err(PduError::Address);
    }
    // The check is for a minimum length, so octets after the addresses are accepted: profibus-wire 4.6.5.
    Ok((source.address(&mut reader).map_err(length)?, destination.address(&mut reader).map_err(length)?))
}

fn emit_addresses(source: &AddAddr<'_>, destination: &AddAddr<'_>, writer: &mut Writer<'_>) -> Result<(), TooLong> {
    writer.octets(&source.header()?)?;
    writer.octets(&destination.header()?)?;
    source.emit(writer)?;
    destination.emit(writer)
}

/// Initiate.req. profibus-wire 4.6.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Initiate<'a> {
    /// Send_Timeout in units of 10 ms.
    pub send_timeout: u16,
    /// Capabilities of the master.
    pub capabilities: Capabilities,
    /// S_Addr: end point of the master.
    pub source: AddAddr<'a>,
    /// D_Addr: end point of the slave.
    pub destination: AddAddr<'a>,
}

impl<'a> Initiate<'a> {
    /// Parses the octets after the function number. The three reserved octets are ignored.
    pub(super) fn parse(mut reader: Reader<'a>) -> Result<Self, PduError> {
        let length = |TooShort| PduError::Length(Function::Initiate);
        reader.take(3).map_err(length)?;
        let send_timeout = reader.word().map_err(length)?;
        let capabilities = Capabilities::parse(&mut reader).map_err(length)?;
        let (source, destination) = parse_addresses(Function::Initiate, reader)?;
        Ok(Self { send_timeout, capabilities, source, destination })
    }

    pub(super) fn emit(&self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[0; 3])?;
        writer.word(self.send_timeout)?;
        self.capabilities.emit(writer)?;
        emit_addresses(&self.source, &self.destination, writer)
    }
}

/// The positive Initiate.res. profibus-wire 4.6.4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InitiateRes<'a> {
    /// Max_Len_Data_Unit: the most octets of a record in one PDU of this connection, at most 240.
    pub max_len_data_unit: u8,
    /// Capabilities of the slave.
    pub capabilities: Capabilities,
    /// S_Addr: end point of the slave, the destination of the request.
    pub source: AddAddr<'a>,
    /// D_Addr: end point of the master.
    pub destination: AddAddr<'a>,
}

impl<'a> InitiateRes<'a> {
    /// Parses the octets after the function number.
    pub(super) fn parse(mut reader: Reader<'a>) -> Result<Self, PduError> {
        let length = |TooShort| PduError::Length(Function::Initiate);
        let max_len_data_unit = reader.octet().map_err(length)?;
        let capabilities = Capabilities::parse(&mut reader).map_err(length)?;
        let (source, destination) = parse_addresses(Function::Initiate, reader)?;
        Ok(Self { max_len_data_unit, capabilities, source, destination })
    }

    pub(super) fn emit(&self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octet(self.max_len_data_unit)?;
        self.capabilities.emit(writer)?;
        emit_addresses(&self.source, &self.destination, writer)
    }
}

/// The answer of the resource manager with the access point of the connection. profibus-wire 4.6.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResourceManager {
    /// The service access point of the connection, 0 to 48.
    pub server_sap: u8,
    /// The minimum Send_Timeout of the slave, in units of 10 ms.
    pub min_send_timeout: u16,
}

impl ResourceManager {
    /// Parses the octets after the function number.
    pub(super) fn parse(mut reader: Reader<'_>) -> Result<Self, FieldError> {
        let answer = Self { server_sap: reader.octet()?, min_send_timeout: reader.word()? };
        match answer.server_sap {
            _ if !reader.is_empty() => Err(FieldError::Surplus),
            0..=48 => Ok(answer),
            found => Err(FieldError::AccessPoint(found)),
        }
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octet(self.server_sap)?;
        writer.word(self.min_send_timeout)
    }
}
