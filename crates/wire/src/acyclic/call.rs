//! Call on index 255, which selects further records, and the record I&M0. profibus-wire 5.

use crate::octets::{Reader, TooLong, TooShort, Writer};

/// The index of Call, which is not a record of its own.
pub const CALL_INDEX: u8 = 255;

/// FI_Index of I&M0: manufacturer, order number, serial number, releases.
pub const IM0: u16 = 0xFDE8;

/// Length of an I&M record in octets.
pub const IM_RECORD_LENGTH: usize = 64;

/// Extended_Function_Num of Call.
const CALL: u8 = 0x08;

/// The data of Write.req to index 255 and of Read.res from it.
///
/// ```
/// use profivac_wire::acyclic::Call;
/// use profivac_wire::acyclic::call::IM0;
///
/// let call = Call::parse(&[8, 0, 0xFD, 0xE8])?;
/// assert!(call.is_call() && call.fi_index == IM0 && call.record.is_empty());
///
/// let mut out = [0; 4];
/// assert_eq!(Call::new(IM0, &[]).emit(&mut out)?, 4);
/// assert_eq!(out, [8, 0, 0xFD, 0xE8]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Call<'a> {
    /// Extended_Function_Num, 8 for Call.
    pub function: u8,
    /// FI_Index: number of the record.
    pub fi_index: u16,
    /// The record; empty in a request that only selects it.
    pub record: &'a [u8],
}

impl<'a> Call<'a> {
    /// A Call of the record `fi_index`.
    #[must_use]
    pub const fn new(fi_index: u16, record: &'a [u8]) -> Self {
        Self { function: CALL, fi_index, record }
    }

    /// Whether the function is Call, the only one defined.
    #[must_use]
    pub const fn is_call(&self) -> bool {
        self.function == CALL
    }

    /// Parses the data of Write.req or Read.res. The reserved octet is ignored.
    ///
    /// # Errors
    /// [`TooShort`] if the four octets of the header are incomplete.
    pub fn parse(data: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(data);
        let [function, _reserved] = [reader.octet()?, reader.octet()?];
        Ok(Self { function, fi_index: reader.word()?, record: reader.rest() })
    }

    /// Writes the data to the front of `out` and returns their length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octets(&[self.function, 0])?;
        writer.word(self.fi_index)?;
        writer.octets(self.record)?;
        Ok(writer.written())
    }
}

const ORDER_ID: usize = 20;
const SERIAL_NUMBER: usize = 16;

/// The record I&M0: identification and maintenance. profibus-wire 5.3.
///
/// ```
/// use profivac_wire::acyclic::Im0;
/// use profivac_wire::acyclic::call::IM_RECORD_LENGTH;
///
/// let mut record = [b' '; IM_RECORD_LENGTH];
/// record[12..18].copy_from_slice(b"DEMO-1");
/// let im0 = Im0::parse(&record)?;
/// assert_eq!(im0.order_id, b"DEMO-1");
///
/// let mut out = [0; IM_RECORD_LENGTH];
/// assert_eq!(im0.emit(&mut out)?, IM_RECORD_LENGTH);
/// assert_eq!(out, record);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Im0<'a> {
    /// MANUFACTURER_SPECIFIC: defined by the manufacturer.
    pub header: [u8; 10],
    /// MANUFACTURER_ID, assigned by PI.
    pub manufacturer_id: u16,
    /// ORDER_ID without the trailing blanks (field of 20 octets).
    pub order_id: &'a [u8],
    /// SERIAL_NUMBER without the trailing blanks (field of 16 octets).
    pub serial_number: &'a [u8],
    /// HARDWARE_REVISION
    pub hardware_revision: u16,
    /// SOFTWARE_REVISION: a letter (`V` for released) and three numbers.
    pub software_revision: [u8; 4],
    /// REV_COUNTER: number of parameter changes, 0 if the device does not count them.
    pub rev_counter: u16,
    /// PROFILE_ID
    pub profile_id: u16,
    /// PROFILE_SPECIFIC_TYPE
    pub profile_specific_type: u16,
    /// IM_VERSION: 1.1 is `[1, 1]`.
    pub im_version: [u8; 2],
    /// IM_SUPPORTED: bit n is set if the device has I&Mn.
    pub im_supported: u16,
}

impl<'a> Im0<'a> {
    /// Parses the record. Octets after the first 64 are ignored.
    ///
    /// # Errors
    /// [`TooShort`] if there are fewer than 64 octets.
    pub fn parse(record: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(record);
        Ok(Self {
            header: array(&mut reader)?,
            manufacturer_id: reader.word()?,
            order_id: unpadded(reader.take(ORDER_ID)?),
            serial_number: unpadded(reader.take(SERIAL_NUMBER)?),
            hardware_revision: reader.word()?,
            software_revision: array(&mut reader)?,
            rev_counter: reader.word()?,
            profile_id: reader.word()?,
            profile_specific_type: reader.word()?,
            im_version: array(&mut reader)?,
            im_supported: reader.word()?,
        })
    }

    /// Writes the record to the front of `out` and returns its length, which is 64.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small or a string longer than its field.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octets(&self.header)?;
        writer.word(self.manufacturer_id)?;
        padded::<ORDER_ID>(self.order_id, &mut writer)?;
        padded::<SERIAL_NUMBER>(self.serial_number, &mut writer)?;
        writer.word(self.hardware_revision)?;
        writer.octets(&self.software_revision)?;
        writer.word(self.rev_counter)?;
        writer.word(self.profile_id)?;
        writer.word(self.profile_specific_type)?;
        writer.octets(&self.im_version)?;
        writer.word(self.im_supported)?;
        Ok(writer.written())
    }
}

fn array<const N: usize>(reader: &mut Reader<'_>) -> Result<[u8; N], TooShort> {
    reader.take(N)?.try_into().map_err(|_| TooShort)
}

/// A visible string without its trailing blanks.
fn unpadded(field: &[u8]) -> &[u8] {
    let end = field.iter().rposition(|octet| *octet != b' ').map_or(0, |last| last.wrapping_add(1));
    field.get(..end).unwrap_or_default()
}

fn padded<const N: usize>(text: &[u8], writer: &mut Writer<'_>) -> Result<(), TooLong> {
    let mut field = [b' '; N];
    field.get_mut(..text.len()).ok_or(TooLong)?.copy_from_slice(text);
    writer.octets(&field)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acyclic::{Response, Transfer};
    use crate::testing::{du, hex};

    /// profibus-wire 5.4: Read.res of I&M0, with the FI_Index of profibus-wire 5.2 and the fields of profibus-wire 5.3.
    const TEXT: &str = "68 4D 4D 68 82 88 08 32 30 5E 00 FF 44 08 00 FD E8 20 20 20 20 20 20 20 20 20 20 01 23 44 45 4D 4F 2D \
        31 20 20 20 20 20 20 20 20 20 20 20 20 20 20 30 30 30 30 34 32 20 20 20 20 20 20 20 20 20 20 00 01 56 01 02 03 \
        00 00 00 00 00 00 01 01 00 00 6E 16";

    const EXAMPLE: Im0<'_> = Im0 {
        header: [b' '; 10],
        manufacturer_id: 0x0123,
        order_id: b"DEMO-1",
        serial_number: b"000042",
        hardware_revision: 1,
        software_revision: [b'V', 1, 2, 3],
        rev_counter: 0,
        profile_id: 0,
        profile_specific_type: 0,
        im_version: [1, 1],
        im_supported: 0,
    };

    fn data(pdu: &[u8]) -> &[u8] {
        let Ok(Response::Read(Transfer { slot: 0, index: CALL_INDEX, data })) = Response::parse(pdu) else {
            panic!("a Read.res of slot 0 index 255")
        };
        data
    }

    #[test]
    fn parses() {
        let pdu = du(TEXT);
        let call = Call::parse(data(&pdu)).unwrap();
        assert_eq!((call.is_call(), call.fi_index), (true, IM0));
        assert_eq!(Im0::parse(call.record), Ok(EXAMPLE));
    }

    #[test]
    fn emits() {
        let mut record = [0; IM_RECORD_LENGTH];
        assert_eq!(EXAMPLE.emit(&mut record), Ok(IM_RECORD_LENGTH));
        let mut out = [0; 68];
        assert_eq!(Call::new(IM0, &record).emit(&mut out), Ok(68));
        assert_eq!(out[..], *data(&du(TEXT)));
        assert_eq!(EXAMPLE.emit(&mut record[..63]), Err(TooLong));
        assert_eq!(Call::new(IM0, &record).emit(&mut out[..67]), Err(TooLong));
        assert_eq!(Im0 { order_id: &[b'x'; 21], ..EXAMPLE }.emit(&mut record), Err(TooLong));
    }

    #[test]
    fn too_short() {
        let pdu = du(TEXT);
        for length in 0..4 {
            assert_eq!(Call::parse(&data(&pdu)[..length]), Err(TooShort));
        }
        for length in 0..IM_RECORD_LENGTH {
            assert_eq!(Im0::parse(&data(&pdu)[4..4 + length]), Err(TooShort));
        }
    }

    #[test]
    fn every_bit_is_unchanged_after_parse_and_emit() {
        let pdu = du(TEXT);
        for bit in 0..IM_RECORD_LENGTH * 8 {
            let mut record = data(&pdu)[4..].to_vec();
            record[bit / 8] ^= 1 << (bit % 8);
            let mut out = [0; IM_RECORD_LENGTH];
            assert_eq!(Im0::parse(&record).unwrap().emit(&mut out), Ok(IM_RECORD_LENGTH));
            assert_eq!(out[..], record);
        }
        let other = hex("09 00 FD E9");
        assert_eq!(Call::parse(&other), Ok(Call { function: 9, fi_index: 0xFDE9, record: &[] }));
    }
}
