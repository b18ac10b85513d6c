//! Access to a record: Read, Write, Data_Transport, and Alarm_Ack, which has their shape. profibus-wire 4.1.1.

use crate::octets::{Reader, TooLong, TooShort, Writer};

/// The longest record one PDU carries.
pub const MAX_RECORD_LENGTH: usize = 240;

/// Four octets without data: Read.req and Write.res.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Slot_Number, 0 to 254.
    pub slot: u8,
    /// Index, 0 to 254, or 255 for Call.
    pub index: u8,
    /// How many octets are wanted, or were written: 1 to 240.
    pub length: u8,
}

impl Access {
    /// Reads what follows the function number.
    ///
    /// # Errors
    /// [`TooShort`] when the PDU has not exactly its four octets, or a length it cannot have.
    pub(super) fn parse(mut reader: Reader<'_>) -> Result<Self, TooShort> {
        let access = Self { slot: reader.octet()?, index: reader.octet()?, length: reader.octet()? };
        let possible = (1..=MAX_RECORD_LENGTH).contains(&usize::from(access.length));
        if possible && reader.is_empty() { Ok(access) } else { Err(TooShort) }
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.slot, self.index, self.length])
    }
}

/// Four octets and data: Write.req, Read.res, Data_Transport both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer<'a> {
    /// Slot_Number, 0 to 254.
    pub slot: u8,
    /// Index, 0 to 254, or 255 for Call.
    pub index: u8,
    /// The record, at most 240 octets. Only a response may have none.
    pub data: &'a [u8],
}

impl<'a> Transfer<'a> {
    /// Reads what follows the function number. A request carries at least one octet (`least`), a response may carry none.
    ///
    /// # Errors
    /// [`TooShort`] when the length octet is not the number of octets that follow, or one the PDU cannot have.
    pub(super) fn parse(mut reader: Reader<'a>, least: usize) -> Result<Self, TooShort> {
        let (slot, index, length) = (reader.octet()?, reader.octet()?, usize::from(reader.octet()?));
        let data = reader.rest();
        let possible = (least..=MAX_RECORD_LENGTH).contains(&length);
        if possible && data.len() == length { Ok(Self { slot, index, data }) } else { Err(TooShort) }
    }

    pub(super) fn emit(&self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        let length = u8::try_from(self.data.len()).ok().filter(|length| usize::from(*length) <= MAX_RECORD_LENGTH);
        writer.octets(&[self.slot, self.index, length.ok_or(TooLong)?])?;
        writer.octets(self.data)
    }
}

/// Alarm_Ack, request and response alike: which alarm was processed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlarmAck {
    /// The slot that raised the alarm.
    pub slot: u8,
    /// Alarm_Type.
    pub alarm_type: u8,
    /// The specifier as it came: Seq_Nr in bits 7 to 3, Add_Ack in bit 2.
    pub specifier: u8,
}

impl AlarmAck {
    pub(super) fn parse(mut reader: Reader<'_>) -> Result<Self, TooShort> {
        let ack = Self { slot: reader.octet()?, alarm_type: reader.octet()?, specifier: reader.octet()? };
        if reader.is_empty() { Ok(ack) } else { Err(TooShort) }
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.slot, self.alarm_type, self.specifier])
    }
}
