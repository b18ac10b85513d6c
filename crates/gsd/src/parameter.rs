//! User parameters: their types, values and texts.

use std::collections::BTreeMap;
use std::fmt;

/// The longest user parameters, profibus-wire 2.4.
pub(crate) const MAX_USER_PRM: usize = 237;

/// The type of a parameter and its place in its octets. Numbers are in network order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataType {
    /// One bit, 0 to 7.
    Bit(u8),
    /// Bits from the first to the last, 0 to 7.
    BitArea(u8, u8),
    /// One octet without sign.
    Unsigned8,
    /// Two octets without sign.
    Unsigned16,
    /// Four octets without sign.
    Unsigned32,
    /// One octet with sign.
    Signed8,
    /// Two octets with sign.
    Signed16,
    /// Four octets with sign.
    Signed32,
}

impl DataType {
    /// Number of octets: 1, 2 or 4.
    #[must_use]
    pub fn octets(self) -> usize {
        match self {
            DataType::Bit(_) | DataType::BitArea(..) | DataType::Unsigned8 | DataType::Signed8 => 1,
            DataType::Unsigned16 | DataType::Signed16 => 2,
            DataType::Unsigned32 | DataType::Signed32 => 4,
        }
    }

    /// Number of bits.
    #[must_use]
    pub fn bits(self) -> u32 {
        match self {
            DataType::Bit(_) => 1,
            DataType::BitArea(first, last) => u32::from(last.saturating_sub(first)).saturating_add(1).min(8),
            DataType::Unsigned8 | DataType::Signed8 => 8,
            DataType::Unsigned16 | DataType::Signed16 => 16,
            DataType::Unsigned32 | DataType::Signed32 => 32,
        }
    }

    fn is_signed(self) -> bool {
        matches!(self, DataType::Signed8 | DataType::Signed16 | DataType::Signed32)
    }

    /// The lowest bit of the type in its octets, 0 to 7.
    #[must_use]
    pub fn first_bit(self) -> u8 {
        match self {
            DataType::Bit(bit) | DataType::BitArea(bit, _) => bit.min(7),
            _ => 0,
        }
    }

    fn shift(self) -> u32 {
        self.first_bit().into()
    }

    fn mask(self) -> u64 {
        (1_u64 << self.bits().min(63)).saturating_sub(1)
    }

    /// The values that the type can hold, both included.
    #[must_use]
    pub fn limits(self) -> (i64, i64) {
        let span = i64::try_from(self.mask()).unwrap_or(i64::MAX);
        if !self.is_signed() {
            return (0, span);
        }
        let half = span / 2;
        (half.saturating_neg().saturating_sub(1), half)
    }

    /// Puts a value into octets. Other bits stay; octets beyond the end are left out.
    pub fn put(self, value: i64, octets: &mut [u8]) {
        let low = value.to_be_bytes();
        let bits = (u64::from_be_bytes(low) & self.mask()) << self.shift();
        let mask = self.mask() << self.shift();
        let first = 8_usize.saturating_sub(self.octets());
        let new = bits.to_be_bytes().into_iter().zip(mask.to_be_bytes()).skip(first);
        for (octet, (bits, mask)) in octets.iter_mut().zip(new) {
            *octet = (*octet & !mask) | (bits & mask);
        }
    }

    /// The value in the octets, none if they are too few.
    #[must_use]
    pub fn get(self, octets: &[u8]) -> Option<i64> {
        let octets = octets.get(..self.octets())?;
        let word = octets.iter().fold(0_u64, |word, octet| (word << 8) | u64::from(*octet));
        let value = i64::try_from((word >> self.shift()) & self.mask()).ok()?;
        let (_, highest) = self.limits();
        let span = i64::try_from(self.mask()).ok()?;
        Some(if value > highest { value.saturating_sub(span).saturating_sub(1) } else { value })
    }
}

impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DataType::Bit(bit) => write!(f, "Bit({bit})"),
            DataType::BitArea(first, last) => write!(f, "BitArea({first}-{last})"),
            DataType::Unsigned8 => f.write_str("Unsigned8"),
            DataType::Unsigned16 => f.write_str("Unsigned16"),
            DataType::Unsigned32 => f.write_str("Unsigned32"),
            DataType::Signed8 => f.write_str("Signed8"),
            DataType::Signed16 => f.write_str("Signed16"),
            DataType::Signed32 => f.write_str("Signed32"),
        }
    }
}

/// Values from the first to the second, both included.
pub type Interval = (i64, i64);

/// A parameter that a user can change, the keyword ExtUserPrmData.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The number by which areas refer to it.
    pub number: u32,
    /// Its name in the file, without blanks at its ends.
    pub name: String,
    /// Type and bits.
    pub kind: DataType,
    /// The value unless a user changes it.
    pub default: i64,
    /// The allowed values; every value of the type if empty.
    pub allowed: Vec<Interval>,
    /// The number of its texts.
    pub texts: Option<u32>,
    /// Whether a user may change it.
    pub changeable: bool,
    /// Whether a tool shows it.
    pub visible: bool,
    /// The line of the definition, from 1; 0 if it comes from no file.
    pub line: usize,
}

impl Parameter {
    /// Whether its value in a module is the number of the slot: tools replace the name `[SlotNumber]`, GSD_Revision 5.
    #[must_use]
    pub fn is_slot_number(&self) -> bool {
        self.name.trim().eq_ignore_ascii_case("[SlotNumber]")
    }

    /// Whether the parameter may have this value.
    #[must_use]
    pub fn allows(&self, value: i64) -> bool {
        let within = |(low, high): &Interval| (*low..=*high).contains(&value);
        within(&self.kind.limits()) && (self.allowed.is_empty() || self.allowed.iter().any(within))
    }
}

/// Texts for values, the keyword PrmText.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrmText {
    /// The number by which parameters refer to it.
    pub number: u32,
    /// The texts by value.
    pub texts: BTreeMap<i64, String>,
    /// The line of the definition, from 1; 0 if it comes from no file.
    pub line: usize,
}

/// Octets of user parameters: constants, and places of parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrmArea {
    /// The length that the file gives.
    pub length: Option<u16>,
    /// In the order of the file: where two overlap, the later one counts.
    pub items: Vec<PrmItem>,
}

/// A part of an area of user parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrmItem {
    /// The first octet, from 0.
    pub offset: u8,
    /// What stands there.
    pub content: PrmContent,
    /// The line, from 1; 0 if it comes from no file.
    pub line: usize,
}

/// Constant octets, or the number of a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum PrmContent {
    /// Ext_User_Prm_Data_Const.
    Const(Vec<u8>),
    /// Ext_User_Prm_Data_Ref.
    Ref(u32),
}

/// What an area defines, without the lines of the file: see [`PrmArea::definition`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PrmDefinition<'a>(Option<u16>, Vec<(u8, &'a PrmContent)>);

impl PrmArea {
    /// What the area defines: equal for areas that differ only in the lines of the file.
    #[must_use]
    pub fn definition(&self) -> PrmDefinition<'_> {
        PrmDefinition(self.length, self.items.iter().map(|item| (item.offset, &item.content)).collect())
    }

    /// The octets, with the value of each item that refers to a parameter.
    ///
    /// Where definitions overlap, the later one counts. The length of the file counts; without one the area ends with its last
    /// definition.
    pub(crate) fn octets(
        &self,
        parameters: &BTreeMap<u32, Parameter>,
        value: impl Fn(usize, &Parameter) -> i64,
    ) -> Vec<u8> {
        let mut octets = Vec::new();
        for (index, item) in self.items.iter().enumerate() {
            let offset = usize::from(item.offset);
            match &item.content {
                PrmContent::Const(constant) => {
                    let place = room(&mut octets, offset, constant.len());
                    place.iter_mut().zip(constant).for_each(|(octet, constant)| *octet = *constant);
                }
                PrmContent::Ref(number) => {
                    let Some(parameter) = parameters.get(number) else { continue };
                    let place = room(&mut octets, offset, parameter.kind.octets());
                    parameter.kind.put(value(index, parameter), place);
                }
            }
        }
        if let Some(length) = self.length {
            octets.resize(usize::from(length).min(MAX_USER_PRM), 0);
        }
        octets
    }
}

fn room(octets: &mut Vec<u8>, offset: usize, length: usize) -> &mut [u8] {
    let end = offset.saturating_add(length);
    if octets.len() < end {
        octets.resize(end, 0);
    }
    octets.get_mut(offset..end).unwrap_or_default()
}
