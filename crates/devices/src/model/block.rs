//! Blocks and their rows: the table in the source is the table in the manual, column by column.
//!
//! `block!` makes an enum of the parameters of one block, their [`Row`]s, and a module with a typed parameter for each;
//! `blocks!` lists the locations of the blocks of a device, and makes an enum of all its parameters. Behaviour is an
//! exhaustive `match` on the latter.

use super::access::Access;
use super::codes::Codes;
use super::value::DataType;
use core::fmt;

/// What a device stores of a value.
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

/// A parameter in a table of the manual.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// The index in its slot.
    pub index: u8,
    /// The name as printed.
    pub name: &'static str,
    /// The data type.
    pub data_type: DataType,
    /// The access rights.
    pub access: Access,
    /// The access rights as printed.
    pub access_text: &'static str,
    /// The store class.
    pub storage: Storage,
    /// The section of the manual.
    pub section: &'static str,
    /// The meaning of its numbers.
    pub codes: Codes,
}

impl Row {
    /// Whether the device stores a value of a master: the store class allows it, and a master can change it.
    #[must_use]
    pub const fn is_stored(&self) -> bool {
        matches!(self.storage, Storage::Nonvolatile | Storage::OnRequest)
            && self.access.intersects(Access::WRITE.union(Access::USER_PRM))
    }

    /// Whether a client can treat both rows alike: index, name, data type and codes are the same.
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
    pub fn row(&self, index: u8) -> Option<&'static Row> {
        self.rows.iter().find(|row| row.index == index)
    }

    /// The row with this index, for the macros of the tables, which know that there is one.
    #[expect(clippy::panic, reason = "evaluated at compile time only: a table that lacks the row does not compile")]
    pub(crate) const fn row_at(&self, index: u8) -> &'static Row {
        let mut rows = self.rows;
        while let [first, rest @ ..] = rows {
            if first.index == index {
                return first;
            }
            rows = rest;
        }
        panic!("the block has no row with this index")
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

/// The block type of a heading, which not every block has.
macro_rules! block_type {
    () => {
        None
    };
    ($number:literal) => {
        Some($number)
    };
}

/// The Rust type of a row: that of its code table, or that of its data type.
macro_rules! value_type {
    ($data_type:ident; $table:ident) => {
        <super::$table as $crate::model::CodeTable>::Value
    };
    (BOOLEAN;) => {
        bool
    };
    (INT8;) => {
        i8
    };
    (UINT8;) => {
        u8
    };
    (INT16;) => {
        i16
    };
    (UINT16;) => {
        u16
    };
    (INT32;) => {
        i32
    };
    (UINT32;) => {
        u32
    };
    (FLOAT;) => {
        f32
    };
    (BY_TYPE;) => {
        $crate::model::Pascal
    };
    // Texts, strings, arrays and records.
    ($octets:ident;) => {
        $crate::model::Octets
    };
}

/// A block table. The columns: ID, identifier, name as printed, data type, access, store class, section of the
/// manual, and the code table if the parameter has one. The module has a typed parameter for each row.
macro_rules! block {
    (
        $(#[$doc:meta])*
        pub $block:ident in $module:ident = $title:literal $(, type $block_type:literal)?;
        $($index:literal $parameter:ident $name:literal $data_type:ident $(($length:literal))?
            [$($access:tt)*] $storage:tt $section:literal $($codes:ident)?;)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $block {
            $(#[doc = concat!("ID ", stringify!($index), ", ", $name)] $parameter = $index,)+
        }

        impl $block {
            /// The table.
            pub const BLOCK: $crate::model::Block = $crate::model::Block {
                name: $title,
                block_type: $crate::model::block::block_type!($($block_type)?),
                rows: &[$($crate::model::Row {
                    index: $index,
                    name: $name,
                    data_type: $crate::model::value::data_type!($data_type $(($length))?),
                    access: $crate::model::access::access!($($access)*),
                    access_text: stringify!($($access)*),
                    storage: $crate::model::block::storage!($storage),
                    section: $section,
                    codes: $crate::model::codes::row_codes!($($codes)?),
                },)+],
            };

            /// The parameter with this index.
            #[must_use]
            pub const fn from_index(index: u8) -> Option<Self> {
                match index {
                    $($index => Some(Self::$parameter),)+
                    _ => None,
                }
            }
        }

        #[doc = concat!("The typed parameters of [`", stringify!($block), "`].")]
        pub mod $module {
            $(
                #[doc = concat!("ID ", stringify!($index), ", ", $name)]
                #[derive(Clone, Copy, Debug, PartialEq, Eq)]
                pub struct $parameter;

                impl $crate::model::TypedParameter for $parameter {
                    type Value = $crate::model::block::value_type!($data_type; $($codes)?);

                    const BLOCK: &'static $crate::model::Block = &super::$block::BLOCK;
                    const ROW: &'static $crate::model::Row = super::$block::BLOCK.row_at($index);
                }
            )+
        }

        // Without a use the compiler would not evaluate the associated constant.
        const _: () = assert!($block::BLOCK.is_ordered(), "the indices of a block rise");
    };
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
    pub(crate) const fn slot(slot: u8, name: &'static str) -> Self {
        Self { slot, instance: 0, name }
    }

    /// The location of an instance of a slot.
    pub(crate) const fn instance(slot: u8, instance: u8, name: &'static str) -> Self {
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

/// The blocks of a device: the variant for the parameters of a block, then its locations; none where only another
/// variant of the device has the block.
macro_rules! blocks {
    (
        $(#[$doc:meta])*
        pub $parameters:ident;
        $($variant:ident($block:ident) [$($location:ident),*];)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $parameters {
            $(#[doc = concat!("Of the block [`", stringify!($block), "`].")] $variant($block),)+
        }

        impl $crate::model::ParameterSet for $parameters {
            const BLOCKS: &'static [$crate::model::PlacedBlock] = &[$($crate::model::PlacedBlock {
                block: &$block::BLOCK,
                locations: &[$($location),*],
            },)+];

            fn of(position: usize, index: u8) -> Option<Self> {
                const OF: &[fn(u8) -> Option<$parameters>] =
                    &[$(|index| $block::from_index(index).map($parameters::$variant),)+];
                OF.get(position)?(index)
            }
        }
    };
}

pub(crate) use {block, block_type, blocks, storage, value_type};
