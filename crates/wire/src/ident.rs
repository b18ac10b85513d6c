//! Identification of a station on layer 2 (Ident, FC = 4E). profibus-wire 1.11.

use crate::octets::{Reader, TooLong, TooShort, Writer};

/// The answer to Ident: four visible strings, in the order of profibus-wire 10, point 1.
///
/// ```
/// use profivac_wire::ident::Ident;
///
/// let ident = Ident::parse(b"\x02\x01\x01\x01ABC12")?;
/// assert_eq!((ident.vendor, ident.software), (&b"AB"[..], &b"2"[..]));
///
/// let mut out = [0; 9];
/// assert_eq!(ident.emit(&mut out)?, 9);
/// assert_eq!(&out, b"\x02\x01\x01\x01ABC12");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ident<'a> {
    /// Manufacturer.
    pub vendor: &'a [u8],
    /// Protocol controller.
    pub controller: &'a [u8],
    /// Hardware release.
    pub hardware: &'a [u8],
    /// Software release.
    pub software: &'a [u8],
}

impl<'a> Ident<'a> {
    /// Reads the data unit of an answer. Octets after the strings are ignored.
    ///
    /// # Errors
    /// [`TooShort`] if the lengths or the strings are incomplete.
    pub fn parse(du: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(du);
        let lengths = [reader.octet()?, reader.octet()?, reader.octet()?, reader.octet()?];
        let [vendor, controller, hardware, software] = lengths.map(|length| reader.take(usize::from(length)));
        Ok(Self { vendor: vendor?, controller: controller?, hardware: hardware?, software: software? })
    }

    /// Writes the data unit to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small or a string has more than 255 octets.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let strings = [self.vendor, self.controller, self.hardware, self.software];
        let mut writer = Writer::new(out);
        for string in strings {
            writer.octet(u8::try_from(string.len()).map_err(|_| TooLong)?)?;
        }
        for string in strings {
            writer.octets(string)?;
        }
        Ok(writer.written())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hex;

    const TEXT: &str = "02 03 01 00 41 42 43 44 45 46";
    const EXAMPLE: Ident<'_> = Ident { vendor: b"AB", controller: b"CDE", hardware: b"F", software: b"" };

    #[test]
    fn parses() {
        assert_eq!(Ident::parse(&hex(TEXT)), Ok(EXAMPLE));
    }

    #[test]
    fn emits() {
        let mut out = [0; 10];
        assert_eq!(EXAMPLE.emit(&mut out), Ok(10));
        assert_eq!(out[..], hex(TEXT));
        assert_eq!(EXAMPLE.emit(&mut out[..9]), Err(TooLong));
        assert_eq!(Ident { vendor: &[b'x'; 256], ..EXAMPLE }.emit(&mut [0; 300]), Err(TooLong));
    }

    #[test]
    fn too_short() {
        for length in 0..10 {
            assert_eq!(Ident::parse(&hex(TEXT)[..length]), Err(TooShort));
        }
    }

    #[test]
    fn every_altered_octet_is_an_error_or_is_emitted_again() {
        for (position, change) in (0..10).flat_map(|position| (1..=255).map(move |change| (position, change))) {
            let mut altered = hex(TEXT);
            altered[position] ^= change;
            if let Ok(ident) = Ident::parse(&altered) {
                let mut out = [0; 10];
                let length = ident.emit(&mut out).unwrap();
                assert_eq!(out[..length], altered[..length]);
                assert_ne!(ident, EXAMPLE);
            }
        }
    }
}
