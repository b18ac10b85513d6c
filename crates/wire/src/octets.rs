//! Bounds-checked reading and writing of fields.
//!
//! [`Reader`] takes fields from the front of a data unit and [`Writer`] appends fields to a buffer. Both return an error at
//! the end, so no other module of this crate counts positions.

use core::fmt;

/// The octets end before the field does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooShort;

impl fmt::Display for TooShort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the data unit ends too early")
    }
}

impl core::error::Error for TooShort {}

/// The encoded octets do not fit into the buffer, or a value does not fit into its field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooLong;

impl fmt::Display for TooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the buffer is too small")
    }
}

impl core::error::Error for TooLong {}

/// Takes fields from the front of a slice. Words are big endian, as in all PROFIBUS formats.
///
/// ```
/// use profivac_wire::Reader;
///
/// let mut reader = Reader::new(&[0x08, 0x12, 0x34, 1, 2, 0xFF]);
/// assert_eq!(reader.octet()?, 8);
/// assert_eq!(reader.word()?, 0x1234);
/// assert_eq!(reader.take(2)?, [1, 2]);
/// assert_eq!(reader.rest(), [0xFF]);
/// assert!(reader.is_empty());
/// # Ok::<(), profivac_wire::TooShort>(())
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reader<'a> {
    octets: &'a [u8],
}

impl<'a> Reader<'a> {
    /// A reader at the first of `octets`.
    #[must_use]
    pub const fn new(octets: &'a [u8]) -> Self {
        Self { octets }
    }

    /// The next octet.
    ///
    /// # Errors
    /// [`TooShort`] if none is left.
    pub const fn octet(&mut self) -> Result<u8, TooShort> {
        let [first, rest @ ..] = self.octets else { return Err(TooShort) };
        self.octets = rest;
        Ok(*first)
    }

    /// The next two octets as an unsigned word.
    ///
    /// # Errors
    /// [`TooShort`] if fewer are left.
    pub const fn word(&mut self) -> Result<u16, TooShort> {
        let [high, low, rest @ ..] = self.octets else { return Err(TooShort) };
        self.octets = rest;
        Ok(u16::from_be_bytes([*high, *low]))
    }

    /// The next `count` octets.
    ///
    /// # Errors
    /// [`TooShort`] if fewer are left.
    pub const fn take(&mut self, count: usize) -> Result<&'a [u8], TooShort> {
        let Some((taken, rest)) = self.octets.split_at_checked(count) else { return Err(TooShort) };
        self.octets = rest;
        Ok(taken)
    }

    /// All remaining octets.
    pub const fn rest(&mut self) -> &'a [u8] {
        let rest = self.octets;
        self.octets = &[];
        rest
    }

    /// Whether no octet is left.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.octets.is_empty()
    }
}

/// Appends fields to a buffer.
///
/// ```
/// use profivac_wire::{TooLong, Writer};
///
/// let mut out = [0; 5];
/// let mut writer = Writer::new(&mut out);
/// writer.octet(8)?;
/// writer.word(0x1234)?;
/// writer.octets(&[1, 2])?;
/// assert_eq!(writer.octet(0), Err(TooLong));
/// assert_eq!(writer.written(), 5);
/// # Ok::<(), TooLong>(())
/// ```
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Writer<'a> {
    free: &'a mut [u8],
    written: usize,
}

impl<'a> Writer<'a> {
    /// A writer at the first octet of `buffer`.
    #[must_use]
    pub const fn new(buffer: &'a mut [u8]) -> Self {
        Self { free: buffer, written: 0 }
    }

    /// Appends one octet.
    ///
    /// # Errors
    /// [`TooLong`] if the buffer has no room; nothing is written, and all later writes fail.
    pub fn octet(&mut self, octet: u8) -> Result<(), TooLong> {
        self.octets(&[octet])
    }

    /// Appends a word, high octet first.
    ///
    /// # Errors
    /// [`TooLong`] if the buffer has no room; nothing is written, and all later writes fail.
    pub fn word(&mut self, word: u16) -> Result<(), TooLong> {
        self.octets(&word.to_be_bytes())
    }

    /// Appends `octets`.
    ///
    /// # Errors
    /// [`TooLong`] if the buffer has no room; nothing is written, and all later writes fail.
    #[inline]
    pub fn octets(&mut self, octets: &[u8]) -> Result<(), TooLong> {
        let free = core::mem::take(&mut self.free);
        let Some((target, rest)) = free.split_at_mut_checked(octets.len()) else {
            // The rest of the buffer is given up, so later writes fail too: an incomplete unit never looks complete.
            return Err(TooLong);
        };
        target.copy_from_slice(octets);
        self.free = rest;
        self.written = self.written.wrapping_add(octets.len());
        Ok(())
    }

    /// The number of octets written.
    #[must_use]
    pub const fn written(&self) -> usize {
        self.written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_returns_fields_in_order_and_an_error_at_the_end() {
        let mut reader = Reader::new(&[1, 2, 3, 4, 5]);
        assert_eq!(reader.octet(), Ok(1));
        assert_eq!(reader.word(), Ok(0x0203));
        assert_eq!(reader.take(3), Err(TooShort));
        assert_eq!(reader.take(1), Ok(&[4][..]));
        assert_eq!(reader.rest(), &[5]);
        assert!(reader.is_empty());
        assert_eq!(reader.octet(), Err(TooShort));
        assert_eq!(reader.word(), Err(TooShort));
    }

    #[test]
    fn a_writer_fails_at_the_first_field_that_does_not_fit_and_ever_after() {
        let mut buffer = [0; 4];
        let mut writer = Writer::new(&mut buffer);
        assert_eq!(writer.octet(1), Ok(()));
        assert_eq!(writer.word(0x0203), Ok(()));
        assert_eq!(writer.word(0x0405), Err(TooLong));
        assert_eq!(writer.octet(6), Err(TooLong));
        assert_eq!(writer.written(), 3);
        assert_eq!(buffer, [1, 2, 3, 0]);
    }
}
