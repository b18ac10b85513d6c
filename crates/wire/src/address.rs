//! Set_Slave_Add (SAP 55): assigns a new address to a slave. profibus-wire 2.11.

use crate::octets::{Reader, TooLong, TooShort, Writer};

/// The data unit of Set_Slave_Add.
///
/// ```
/// use profivac_wire::address::SetSlaveAdd;
///
/// let request = SetSlaveAdd::parse(&[8, 0x12, 0x34, 0])?;
/// assert_eq!((request.address, request.ident), (8, 0x1234));
///
/// let mut out = [0; 4];
/// assert_eq!(request.emit(&mut out)?, 4);
/// assert_eq!(out, [8, 0x12, 0x34, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetSlaveAdd<'a> {
    /// New_Slave_Add.
    pub address: u8,
    /// Ident_Number; a slave accepts only its own.
    pub ident: u16,
    /// No_Add_Chg as received: 0 permits further changes of the address, any other value locks it.
    pub no_add_chg: u8,
    /// Rem_Slave_Data, device specific.
    pub rem_slave_data: &'a [u8],
}

impl<'a> SetSlaveAdd<'a> {
    /// Reads the data unit of a request.
    ///
    /// # Errors
    /// [`TooShort`] if the four fixed octets are incomplete.
    pub fn parse(du: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(du);
        Ok(Self {
            address: reader.octet()?,
            ident: reader.word()?,
            no_add_chg: reader.octet()?,
            rem_slave_data: reader.rest(),
        })
    }

    /// Writes the data unit to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octet(self.address)?;
        writer.word(self.ident)?;
        writer.octet(self.no_add_chg)?;
        writer.octets(self.rem_slave_data)?;
        Ok(writer.written())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hex;

    /// profibus-wire 2.11: address 8, changeable again; with two octets of device data.
    const TEXT: &str = "08 12 34 00 AB CD";
    const EXAMPLE: SetSlaveAdd<'_> =
        SetSlaveAdd { address: 8, ident: 0x1234, no_add_chg: 0, rem_slave_data: &[0xAB, 0xCD] };

    #[test]
    fn parses() {
        assert_eq!(SetSlaveAdd::parse(&hex(TEXT)), Ok(EXAMPLE));
    }

    #[test]
    fn emits() {
        let mut out = [0; 6];
        assert_eq!(EXAMPLE.emit(&mut out), Ok(6));
        assert_eq!(out[..], hex(TEXT));
        assert_eq!(EXAMPLE.emit(&mut [0; 5]), Err(TooLong));
    }

    #[test]
    fn too_short() {
        for length in 0..4 {
            assert_eq!(SetSlaveAdd::parse(&hex(TEXT)[..length]), Err(TooShort));
        }
    }

    #[test]
    fn every_bit_is_unchanged_after_parse_and_emit() {
        for bit in 0..48 {
            let mut octets = hex(TEXT);
            octets[bit / 8] ^= 1 << (bit % 8);
            let mut out = [0; 6];
            assert_eq!(SetSlaveAdd::parse(&octets).unwrap().emit(&mut out), Ok(6));
            assert_eq!(out[..], octets);
        }
    }
}
