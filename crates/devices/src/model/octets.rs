//! The octets of a parameter, without allocation.

use core::fmt;

/// The octets of the longest parameter: Device Configuration.
const MAX_OCTETS: usize = 50;

/// The octets of a parameter, up to 50.
#[derive(Clone, Copy)]
pub struct Octets {
    length: u8,
    octets: [u8; MAX_OCTETS],
}

impl Octets {
    /// No octets.
    pub const EMPTY: Self = Self { length: 0, octets: [0; MAX_OCTETS] };

    /// A copy of `octets`, cut to the capacity.
    ///
    /// Inlined, because most callers have an array: a copy of known length needs neither a loop nor a call.
    #[inline]
    #[must_use]
    pub fn new(octets: &[u8]) -> Self {
        Self::filled(octets, octets.len(), 0)
    }

    /// A copy of `octets`, exactly `length` long: cut, or padded with `fill` at the end.
    #[inline]
    #[must_use]
    pub fn filled(octets: &[u8], length: usize, fill: u8) -> Self {
        let length = length.min(MAX_OCTETS);
        let mut copy = [fill; MAX_OCTETS];
        let (octets, _) = octets.split_at(octets.len().min(length));
        if let Some(target) = copy.get_mut(..octets.len()) {
            target.copy_from_slice(octets);
        }
        Self { length: u8::try_from(length).unwrap_or_default(), octets: copy }
    }

    /// The octets.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.octets.get(..usize::from(self.length)).unwrap_or_default()
    }

    /// The text without the blanks and zeros at its end; `None` if it is not UTF-8.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        core::str::from_utf8(self.as_slice()).ok().map(|text| text.trim_end_matches(['\0', ' ']))
    }
}

impl core::ops::Deref for Octets {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.as_slice()
    }
}

impl PartialEq for Octets {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl Eq for Octets {}

impl fmt::Debug for Octets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X?}", self.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_ends_before_its_padding() {
        assert_eq!(Octets::new(b"CG \0 ").text(), Some("CG"));
        assert_eq!(Octets::new(&[0xFF]).text(), None);
    }
}
