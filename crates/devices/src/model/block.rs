//! Blocks and their rows: the table in the source is the table in the manual, column by column.
//!
//! `block!` and `blocks!` in `block_macros` make them.

use super::access::Access;
use super::codes::Codes;
use super::role::Role;
use super::value::DataType;
use core::fmt;

/// The store class: whether a device stores a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// `N`: stored.
    Nonvolatile,
    /// `V`: lost with the power.
    Volatile,
    /// `R`: stored when the master asks for it, otherwise lost with the power.
    OnRequest,
    /// `D`: depends on other values, never stored.
    Dynamic,
    /// `-`: the manual says nothing; the value is not stored.
    Unstated,
}

impl fmt::Display for Storage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Nonvolatile => "N",
            Self::Volatile => "V",
            Self::OnRequest => "R",
            Self::Dynamic => "D",
            Self::Unstated => "-",
        })
    }
}

/// A parameter in a table of the manual. The feature `texts` has what a client needs and a device does not.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// The index in its slot.
    pub index: u8,
    /// The name as printed.
    #[cfg(feature = "texts")]
    pub name: &'static str,
    /// The data type.
    pub data_type: DataType,
    /// The access rights.
    pub access: Access,
    /// The access rights as printed.
    #[cfg(feature = "texts")]
    pub access_text: &'static str,
    /// The store class.
    pub storage: Storage,
    /// The section of the manual.
    #[cfg(feature = "texts")]
    pub section: &'static str,
    /// The meaning of its numbers.
    #[cfg(feature = "texts")]
    pub codes: Codes,
    /// The part it plays for a client, if a client looks for it.
    pub role: Option<Role>,
}

/// A text of a table for clients; empty without the feature `texts`, so that a program does not have it.
#[must_use]
pub const fn text(text: &'static str) -> &'static str {
    if cfg!(feature = "texts") { text } else { "" }
}

/// What a row says to a client.
#[derive(Debug)]
pub struct RowTexts {
    /// The name as printed.
    pub name: &'static str,
    /// The access rights as printed.
    pub access: &'static str,
    /// The section of the manual.
    pub section: &'static str,
    /// The meaning of its numbers.
    pub codes: Codes,
}

impl Row {
    /// A row. Without the feature `texts` it does not keep the texts, so that a program does not have them.
    #[must_use]
    pub const fn new(
        index: u8,
        data_type: DataType,
        access: Access,
        storage: Storage,
        role: Option<Role>,
        texts: RowTexts,
    ) -> Self {
        #[cfg(not(feature = "texts"))]
        let _ = &texts;
        Self {
            index,
            #[cfg(feature = "texts")]
            name: texts.name,
            data_type,
            access,
            #[cfg(feature = "texts")]
            access_text: texts.access,
            storage,
            #[cfg(feature = "texts")]
            section: texts.section,
            #[cfg(feature = "texts")]
            codes: texts.codes,
            role,
        }
    }

    /// Whether the device stores a value of a master: the store class allows it, and a master can change it.
    #[must_use]
    pub const fn is_stored(&self) -> bool {
        matches!(self.storage, Storage::Nonvolatile | Storage::OnRequest)
            && self.access.intersects(Access::WRITE.union(Access::USER_PRM))
    }

    /// Whether a client can treat both rows alike: index, name, data type and codes are the same.
    #[cfg(feature = "texts")]
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        (self.index, self.name, self.data_type) == (other.index, other.name, other.data_type)
            && self.codes == other.codes
    }
}

/// One block of a manual.
#[derive(Debug, PartialEq)]
pub struct Block {
    /// The heading of the table.
    pub name: &'static str,
    /// The number of Appendix B, where the block has one.
    pub block_type: Option<u16>,
    /// The rows, in the order of their indices.
    pub rows: &'static [Row],
}

impl Block {
    /// The row with this index.
    #[must_use]
    pub const fn row(&self, index: u8) -> Option<&'static Row> {
        let mut rows = self.rows;
        // The indices rise.
        while let [first, rest @ ..] = rows {
            if first.index >= index {
                return if first.index == index { Some(first) } else { None };
            }
            rows = rest;
        }
        None
    }

    /// The octets of Block Type: the number as a word, then two zeros. errata-bpg-bcg-tpg 31.
    #[must_use]
    pub const fn type_octets(&self) -> [u8; 4] {
        let [high, low] = match self.block_type {
            Some(number) => number.to_be_bytes(),
            None => [0; 2],
        };
        [high, low, 0, 0]
    }

    /// Whether the indices rise, so that none is in the table twice. Evaluated at compile time.
    #[must_use]
    pub const fn is_ordered(&self) -> bool {
        let mut rows = self.rows;
        while let [first, rest @ ..] = rows {
            if let [second, ..] = rest
                && second.index <= first.index
            {
                return false;
            }
            rows = rest;
        }
        true
    }
}

/// The location of a block: slot, and instance where several instances share the slot and a selector chooses one.
#[derive(Debug, PartialEq, Eq)]
pub struct Location {
    /// The slot.
    pub slot: u8,
    /// The instance, 0 where the slot has only one.
    pub instance: u8,
    /// The manual's word for the measuring part or the channel.
    pub name: &'static str,
}

impl Location {
    /// The location of a block in a slot of its own.
    #[must_use]
    pub const fn slot(slot: u8, name: &'static str) -> Self {
        Self { slot, instance: 0, name }
    }

    /// The location of an instance of a slot.
    #[must_use]
    pub const fn instance(slot: u8, instance: u8, name: &'static str) -> Self {
        Self { slot, instance, name }
    }

    /// Whether both have the same slot and instance.
    #[must_use]
    pub const fn is_at(&self, other: &Self) -> bool {
        self.slot == other.slot && self.instance == other.instance
    }
}

/// A block with all its locations in a device.
#[derive(Debug, PartialEq)]
pub struct PlacedBlock {
    /// The block.
    pub block: &'static Block,
    /// Its slots and instances.
    pub locations: &'static [Location],
}

/// All parameters of a device, made by `blocks!`.
pub trait ParameterSet: Copy + 'static {
    /// The blocks and their locations.
    const BLOCKS: &'static [PlacedBlock];

    /// The parameter with this index in the block at this position of [`BLOCKS`](Self::BLOCKS). A device that comes in
    /// several variants has a list for each, with blocks for the same parameters at the same positions.
    fn of(position: usize, index: u8) -> Option<Self>;
}
