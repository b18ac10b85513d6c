//! Blocks and their rows: the table in the source is the table in the manual, column by column.
//!
//! `block!` makes an enum of the parameters of one block, and their [`Row`]s; `blocks!` says in which slots a device has
//! them, and makes an enum of all its parameters. Behaviour is an exhaustive `match` on the latter.

use super::{Access, Codes, DataType};
use core::fmt;

/// What happens to a value when power goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// `N`: kept.
    Nonvolatile,
    /// `V`: lost.
    Volatile,
    /// `R`: lost, unless the master has asked to store it.
    OnRequest,
    /// `D`: follows from others, never stored.
    Dynamic,
    /// `-`: the manual says nothing; nothing is kept.
    Unstated,
}

/// The store column of a block table.
macro_rules! storage {
    (N) => {
        $crate::model::Storage::Nonvolatile
    };
    (V) => {
        $crate::model::Storage::Volatile
    };
    (R) => {
        $crate::model::Storage::OnRequest
    };
    (D) => {
        $crate::model::Storage::Dynamic
    };
    (-) => {
        $crate::model::Storage::Unstated
    };
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

/// One parameter as the manual tabulates it.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// The index in its slot.
    pub index: u8,
    /// The name as printed.
    pub name: &'static str,
    /// The data type.
    pub data_type: DataType,
    /// Who may read and write it.
    pub access: Access,
    /// The access as it stands in the table.
    pub access_text: &'static str,
    /// What happens when power goes.
    pub storage: Storage,
    /// The section of the manual.
    pub section: &'static str,
    /// What its numbers mean.
    pub codes: Codes,
}

impl Row {
    /// Whether a master's value can outlive the power: it has a place in the memory, and a master can change it.
    #[must_use]
    pub const fn is_stored(&self) -> bool {
        matches!(self.storage, Storage::Nonvolatile | Storage::OnRequest)
            && self.access.intersects(Access::WRITE.union(Access::USER_PRM))
    }
}

/// One block of a manual.
#[derive(Debug, PartialEq)]
pub struct Block {
    /// The heading of the table.
    pub name: &'static str,
    /// The number of Appendix B, where the block has one.
    pub block_type: Option<u16>,
    /// The rows, by rising ID.
    pub rows: &'static [Row],
}

impl Block {
    /// The row with this ID.
    #[must_use]
    pub fn row(&self, id: u8) -> Option<&'static Row> {
        self.rows.iter().find(|row| row.index == id)
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

    /// Whether the IDs rise, so that none is there twice. Asked at compile time.
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

/// The block type of a heading, which not every block has.
macro_rules! block_type {
    () => {
        None
    };
    ($number:literal) => {
        Some($number)
    };
}

/// A block table. The columns: ID, identifier, name as printed, data type, access, store class, section of the
/// manual, and the table of its codes if it has one.
macro_rules! block {
    (
        $(#[$doc:meta])*
        pub $block:ident = $title:literal $(, type $block_type:literal)?;
        $($id:literal $parameter:ident $name:literal $data_type:ident $(($length:literal))?
            [$($access:tt)*] $storage:tt $section:literal $($codes:ident)?;)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $block {
            $(#[doc = concat!("ID ", stringify!($id), ", ", $name)] $parameter = $id,)+
        }

        impl $block {
            /// The rows.
            pub const BLOCK: $crate::model::Block = $crate::model::Block {
                name: $title,
                block_type: $crate::model::block::block_type!($($block_type)?),
                rows: &[$($crate::model::Row {
                    index: $id,
                    name: $name,
                    data_type: $crate::model::value::data_type!($data_type $(($length))?),
                    access: $crate::model::access::access!($($access)*),
                    access_text: stringify!($($access)*),
                    storage: $crate::model::block::storage!($storage),
                    section: $section,
                    codes: $crate::model::codes::codes!($($codes)?),
                },)+],
            };

            /// The parameter with this ID.
            #[must_use]
            pub const fn of(id: u8) -> Option<Self> {
                match id {
                    $($id => Some(Self::$parameter),)+
                    _ => None,
                }
            }
        }

        // An associated constant that nobody uses would never be looked at.
        const _: () = assert!($block::BLOCK.is_ordered(), "the IDs of a block rise");
    };
}

/// Where a block stands: slot, and instance where several share the slot and a selector chooses one.
#[derive(Debug, PartialEq, Eq)]
pub struct Location {
    /// The slot.
    pub slot: u8,
    /// The instance, 0 where the slot has only one.
    pub instance: u8,
    /// What people call it: the manual's word for the measuring part or the channel.
    pub name: &'static str,
}

/// A block, and everywhere a device has it.
#[derive(Debug, PartialEq)]
pub struct PlacedBlock {
    /// The block.
    pub block: &'static Block,
    /// Its slots and instances.
    pub locations: &'static [Location],
}

/// All parameters of a device, made by `blocks!`.
pub trait ParameterSet: Copy + 'static {
    /// The blocks and where they are.
    const PLACES: &'static [PlacedBlock];

    /// The parameter with this ID in the block at this position of [`PLACES`](Self::PLACES). A device that comes in several
    /// kinds has a list of places for each, with blocks for the same parameters at the same positions.
    fn of(place: usize, id: u8) -> Option<Self>;
}

/// The blocks of a device: the variant for the parameters of a block, then its addresses as `slot "name"` or
/// `slot:instance "name"`; none where only another kind of the device has the block.
macro_rules! blocks {
    (
        $(#[$doc:meta])*
        pub $parameters:ident;
        $($variant:ident($block:ident) [$($slot:literal $(: $instance:literal)? $name:literal),*];)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $parameters {
            $(#[doc = concat!("Of the block [`", stringify!($block), "`].")] $variant($block),)+
        }

        impl $crate::model::ParameterSet for $parameters {
            const PLACES: &'static [$crate::model::PlacedBlock] = &[$($crate::model::PlacedBlock {
                block: &$block::BLOCK,
                locations: &[$($crate::model::Location {
                    slot: $slot,
                    instance: 0 $(+ $instance)?,
                    name: $name,
                },)*],
            },)+];

            fn of(place: usize, id: u8) -> Option<Self> {
                const OF: &[fn(u8) -> Option<$parameters>] = &[$(|id| $block::of(id).map($parameters::$variant),)+];
                OF.get(place)?(id)
            }
        }
    };
}

pub(crate) use {block, block_type, blocks, storage};
