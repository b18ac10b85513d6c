//! The only place where positions in octets are counted.
//!
//! [`Reader`] takes octets from the front of a data unit, [`Writer`] puts them into a buffer. Both answer with an error
//! instead of running over the end, so nobody else has to look at lengths.

use core::fmt;

/// The octets ended before the field did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooShort;

impl fmt::Display for TooShort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the data unit ends too early")
    }
}

impl core::error::Error for TooShort {}

/// The buffer ended before the field did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong;

impl fmt::Display for TooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the buffer is too small")
    }
}

impl core::error::Error for TooLong {}

/// Takes fields from the front of some octets. Words are big endian, as everywhere on the wire.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    octets: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Reads from the first of `octets` on.
    #[must_use]
    pub const fn new(octets: &'a [u8]) -> Self {
        Self { octets }
    }

    /// The next octet.
    ///
    /// # Errors
    /// [`TooShort`] when none is left.
    pub const fn octet(&mut self) -> Result<u8, TooShort> {
        let [first, rest @ ..] = self.octets else { return Err(TooShort) };
        self.octets = rest;
        Ok(*first)
    }

    /// The next two octets as an unsigned word.
    ///
    /// # Errors
    /// [`TooShort`] when fewer are left.
    pub const fn word(&mut self) -> Result<u16, TooShort> {
        let [high, low, rest @ ..] = self.octets else { return Err(TooShort) };
        self.octets = rest;
        Ok(u16::from_be_bytes([*high, *low]))
    }

    /// The next `count` octets.
    ///
    /// # Errors
    /// [`TooShort`] when fewer are left.
    pub const fn take(&mut self, count: usize) -> Result<&'a [u8], TooShort> {
        let Some((taken, rest)) = self.octets.split_at_checked(count) else { return Err(TooShort) };
        self.octets = rest;
        Ok(taken)
    }

    /// All octets that are left.
    pub const fn rest(&mut self) -> &'a [u8] {
        let rest = self.octets;
        self.octets = &[];
        rest
    }

    /// Whether every octet was taken.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.octets.is_empty()
    }
}

/// Puts fields into a buffer, one after the other.
#[derive(Debug)]
pub struct Writer<'a> {
    free: &'a mut [u8],
    written: usize,
}

impl<'a> Writer<'a> {
    /// Writes from the first octet of `buffer` on.
    #[must_use]
    pub const fn new(buffer: &'a mut [u8]) -> Self {
        Self { free: buffer, written: 0 }
    }

    /// Appends one octet.
    ///
    /// # Errors
    /// [`Full`] when the buffer has no room; nothing is written then.
    pub fn octet(&mut self, octet: u8) -> Result<(), TooLong> {
        self.octets(&[octet])
    }

    /// Appends a word, high octet first.
    ///
    /// # Errors
    /// [`Full`] when the buffer has no room; nothing is written then.
    pub fn word(&mut self, word: u16) -> Result<(), TooLong> {
        self.octets(&word.to_be_bytes())
    }

    /// Appends `octets`.
    ///
    /// # Errors
    /// [`Full`] when the buffer has no room; nothing is written then.
    #[inline]
    pub fn octets(&mut self, octets: &[u8]) -> Result<(), TooLong> {
        let free = core::mem::take(&mut self.free);
        let Some((place, rest)) = free.split_at_mut_checked(octets.len()) else {
            // `free` is gone, so every further write fails as well: a half written unit never looks complete.
            return Err(TooLong);
        };
        place.copy_from_slice(octets);
        self.free = rest;
        self.written = self.written.wrapping_add(octets.len());
        Ok(())
    }

    /// How many octets were written.
    #[must_use]
    pub const fn written(&self) -> usize {
        self.written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_gives_fields_in_order_and_then_refuses() {
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
    fn a_writer_refuses_what_does_not_fit_and_everything_after_it() {
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
