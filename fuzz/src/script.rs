//! Octets of the fuzzer as a list of choices.

/// Reads the octets of the fuzzer one choice after the other.
#[derive(Clone, Copy, Debug)]
pub struct Script<'a>(&'a [u8]);

impl<'a> Script<'a> {
    /// All of `octets`.
    #[must_use]
    pub const fn new(octets: &'a [u8]) -> Self {
        Self(octets)
    }

    /// The next octet; `None` at the end.
    pub fn octet(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// The next octet; 0 at the end.
    pub fn choice(&mut self) -> u8 {
        self.octet().unwrap_or_default()
    }

    /// A number of two octets.
    pub fn number(&mut self) -> u16 {
        u16::from_be_bytes([self.choice(), self.choice()])
    }

    /// One of `items`, which are not empty.
    pub fn one_of<T: Copy>(&mut self, items: &[T]) -> T {
        items[usize::from(self.choice()) % items.len()]
    }

    /// Up to `count` octets.
    pub fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        taken
    }

    /// Octets behind their number, at most `most`.
    pub fn piece(&mut self, most: usize) -> &'a [u8] {
        let count = usize::from(self.choice()) % (most + 1);
        self.take(count)
    }

    /// The octets that are left.
    #[must_use]
    pub const fn rest(self) -> &'a [u8] {
        self.0
    }

    /// A time in bit times: mostly short, up to some seconds.
    pub fn pause_tbit(&mut self) -> u64 {
        let code = self.choice();
        // Six bits of a number, two of its scale.
        u64::from(code & 0x3F) * [1, 33, 4096, 1 << 20][usize::from(code >> 6)]
    }
}
