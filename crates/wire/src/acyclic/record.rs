//! Access to records: Read, Write, Data_Transport, and Alarm_Ack. profibus-wire 4.1.1.

use super::function::FieldError;
use crate::octets::{Reader, TooLong, Writer};

/// Length of the longest record in one PDU.
pub const MAX_RECORD_LENGTH: usize = 240;

/// A PDU of four octets without data: Read.req and Write.res.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Access {
    /// Slot_Number, 0 to 254.
    pub slot: u8,
    /// Index, 0 to 254, or 255 for Call.
    pub index: u8,
    /// Number of octets to read, or written: 1 to 240.
    pub length: u8,
}

impl Access {
    /// Parses the octets after the function number.
    ///
    /// # Errors
    /// [`FieldError`] if there are not exactly three octets, or the length is not 1 to 240.
    pub(super) fn parse(mut reader: Reader<'_>) -> Result<Self, FieldError> {
        let access = Self { slot: reader.octet()?, index: reader.octet()?, length: reader.octet()? };
        match usize::from(access.length) {
            _ if !reader.is_empty() => Err(FieldError::Surplus),
            1..=MAX_RECORD_LENGTH => Ok(access),
            _ => Err(FieldError::Length),
        }
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.slot, self.index, self.length])
    }
}

/// A PDU of four octets and data: Write.req, Read.res, Data_Transport in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transfer<'a> {
    /// Slot_Number, 0 to 254.
    pub slot: u8,
    /// Index, 0 to 254, or 255 for Call.
    pub index: u8,
    /// The record, at most 240 octets. Only a response may be empty.
    pub data: &'a [u8],
}

impl<'a> Transfer<'a> {
    /// Parses the octets after the function number. `least` is the minimum length of the data: 1 in a request, 0 in a response.
    ///
    /// # Errors
    /// [`FieldError`] if the length octet differs from the number of octets that follow, or is not `least` to 240.
    pub(super) fn parse(mut reader: Reader<'a>, least: usize) -> Result<Self, FieldError> {
        let (slot, index, length) = (reader.octet()?, reader.octet()?, usize::from(reader.octet()?));
        let data = reader.rest();
        let possible = (least..=MAX_RECORD_LENGTH).contains(&length);
        if possible && data.len() == length { Ok(Self { slot, index, data }) } else { Err(FieldError::Length) }
    }

    pub(super) fn emit(&self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        let length = u8::try_from(self.data.len()).ok().filter(|length| usize::from(*length) <= MAX_RECORD_LENGTH);
        writer.octets(&[self.slot, self.index, length.ok_or(TooLong)?])?;
        writer.octets(self.data)
    }
}

/// Alarm_Ack, the same in request and response: the acknowledged alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AlarmAck {
    /// The slot that raised the alarm.
    pub slot: u8,
    /// Alarm_Type.
    pub alarm_type: u8,
    /// The specifier as received: Seq_Nr in bits 7 to 3, Add_Ack in bit 2.
    pub specifier: u8,
}

impl AlarmAck {
    pub(super) fn parse(mut reader: Reader<'_>) -> Result<Self, FieldError> {
        let ack = Self { slot: reader.octet()?, alarm_type: reader.octet()?, specifier: reader.octet()? };
        if reader.is_empty() { Ok(ack) } else { Err(FieldError::Surplus) }
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.slot, self.alarm_type, self.specifier])
    }
}
