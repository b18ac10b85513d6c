//! Diagnosis in the words of the file.

use std::collections::BTreeMap;
use std::fmt;

/// Texts for diagnosis.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnosis {
    /// Unit_Diag_Bit, Unit_Diag_!Bit and Unit_Diag_Area.
    pub unit: UnitDiag,
    /// X_Unit_Diag_Bit and X_Unit_Diag_Area by UnitDiagType, the first octet of the block.
    pub types: BTreeMap<u8, UnitDiag>,
    /// Channel_Diag: texts by error type, with their help.
    pub channels: BTreeMap<u8, Words>,
}

/// A text, and what to do about it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Words {
    /// The text.
    pub text: String,
    /// The help, if the file has one.
    pub help: Option<String>,
}

/// Texts for a device-related block.
///
/// Bit 0 is the lowest bit of the octet behind the header, profibus-wire 2.3.2; in a DP-V1 block bits 0 to 23 are type, slot and
/// specifier.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnitDiag {
    /// Texts of bits that are set, by number.
    pub bits: BTreeMap<u16, Words>,
    /// Texts of bits that are not set, by number.
    pub inverted: BTreeMap<u16, Words>,
    /// Numbers in several bits.
    pub areas: Vec<DiagArea>,
}

/// A number in several bits and its texts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DiagArea {
    /// The lowest bit.
    pub first: u16,
    /// The highest bit.
    pub last: u16,
    /// Texts by value.
    pub values: BTreeMap<u64, Words>,
}

/// A statement of a diagnosis in the words of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The first and the last bit behind the header.
    pub bits: (u16, u16),
    /// The value of an area, none for a single bit.
    pub value: Option<u64>,
    /// The text; none if the file has none for this value.
    pub text: Option<String>,
    /// The help of the file.
    pub help: Option<String>,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, last) = self.bits;
        match (&self.text, self.value) {
            (Some(text), _) => f.write_str(text)?,
            (None, Some(value)) => {
                write!(f, "bits {first} to {last} have the value {value}, which has no text in the file")?
            }
            (None, None) => write!(f, "bit {first}")?,
        }
        self.help.as_ref().map_or(Ok(()), |help| write!(f, " ({help})"))
    }
}

impl Diagnosis {
    /// The texts of a device-related block, with its header octet. Empty for another block or one that is cut.
    ///
    /// Texts of UnitDiagType count if the first octet behind the header is such a type, the others if not.
    #[must_use]
    pub fn device_block(&self, block: &[u8]) -> Vec<Finding> {
        let Some((header, octets)) = block.split_first() else { return Vec::new() };
        let length = usize::from(*header).checked_sub(1).filter(|_| header & 0xC0 == 0);
        let Some(octets) = length.and_then(|length| octets.get(..length)) else { return Vec::new() };
        let typed = octets.first().and_then(|kind| self.types.get(kind));
        typed.unwrap_or(&self.unit).findings(octets)
    }

    /// The file's text for an error type of a channel-related block, 0 to 31.
    #[must_use]
    pub fn channel(&self, error: u8) -> Option<&Words> {
        self.channels.get(&error)
    }

    /// The file's text for a channel-related block of three octets.
    #[must_use]
    pub fn channel_block(&self, block: &[u8; 3]) -> Option<&Words> {
        let [header, _, kind] = block;
        self.channel(kind & 0x1F).filter(|_| header & 0xC0 == 0x80)
    }

    /// Whether there is no text at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty() && self.types.is_empty() && self.unit == UnitDiag::default()
    }
}

impl UnitDiag {
    fn findings(&self, octets: &[u8]) -> Vec<Finding> {
        let single = |texts: &BTreeMap<u16, Words>, set: bool| -> Vec<Finding> {
            let matching = texts.iter().filter(|(number, _)| bit(octets, **number) == Some(set));
            matching.map(|(number, words)| Finding::new((*number, *number), None, Some(words))).collect()
        };
        let mut findings = single(&self.bits, true);
        findings.extend(single(&self.inverted, false));
        findings.extend(self.areas.iter().filter_map(|area| area.finding(octets)));
        findings.sort_by_key(|finding| finding.bits);
        findings
    }
}

impl DiagArea {
    /// The value in the octets, none if they are too few or the area has more than 64 bits.
    #[must_use]
    pub fn value(&self, octets: &[u8]) -> Option<u64> {
        if self.last.saturating_sub(self.first) > 63 {
            return None;
        }
        let mut bits = (self.first..=self.last).rev().map(|number| bit(octets, number));
        bits.try_fold(0_u64, |value, bit| Some((value << 1) | u64::from(bit?)))
    }

    /// A value of 0 without a text says nothing.
    fn finding(&self, octets: &[u8]) -> Option<Finding> {
        let value = self.value(octets)?;
        let words = self.values.get(&value);
        (words.is_some() || value != 0).then(|| Finding::new((self.first, self.last), Some(value), words))
    }
}

impl Finding {
    fn new(bits: (u16, u16), value: Option<u64>, words: Option<&Words>) -> Self {
        Self {
            bits,
            value,
            text: words.map(|words| words.text.clone()),
            help: words.and_then(|words| words.help.clone()),
        }
    }
}

fn bit(octets: &[u8], number: u16) -> Option<bool> {
    octets.get(usize::from(number / 8)).map(|octet| octet >> (number % 8) & 1 == 1)
}
