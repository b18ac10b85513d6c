//! The macros for the tables of blocks.
//!
//! `block!` makes an enum of the parameters of one block, their [`Row`](super::Row)s, and a module with a typed parameter for each;
//! `blocks!` lists the locations of the blocks of a device, and makes an enum of all its parameters. Behaviour is an
//! exhaustive `match` on the latter.

/// The store column of a block table.
#[doc(hidden)]
#[macro_export]
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

/// The block type of a heading, which not every block has.
#[doc(hidden)]
#[macro_export]
macro_rules! block_type {
    () => {
        None
    };
    ($number:literal) => {
        Some($number)
    };
}

/// The Rust type of a row: that of its code table, or that of its data type.
#[doc(hidden)]
#[macro_export]
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

/// The code table of a row, which not every row has.
#[doc(hidden)]
#[macro_export]
macro_rules! row_codes {
    () => {
        $crate::model::Codes::Plain
    };
    ($table:ident) => {
        <super::$table as $crate::model::CodeTable>::CODES
    };
}

/// A block table. The columns: ID, identifier, name as printed, data type, access, store class, section of the
/// manual, and the code table if the parameter has one. The module has a typed parameter for each row.
#[macro_export]
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
                name: $crate::model::text($title),
                block_type: $crate::model::block_macros::block_type!($($block_type)?),
                rows: &[$($module::$parameter::DEFINITION,)+],
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

                impl $parameter {
                    pub(super) const DEFINITION: $crate::model::Row = $crate::model::Row::new(
                        $index,
                        $crate::model::value::data_type!($data_type $(($length))?),
                        $crate::model::access::access!($($access)*),
                        $crate::model::block_macros::storage!($storage),
                        $crate::model::role::role!($parameter),
                        $crate::model::RowTexts {
                            name: $name,
                            access: stringify!($($access)*),
                            section: $section,
                            codes: $crate::model::block_macros::row_codes!($($codes)?),
                        },
                    );
                }

                impl $crate::model::TypedParameter for $parameter {
                    type Value = $crate::model::block_macros::value_type!($data_type; $($codes)?);

                    const BLOCK: &'static $crate::model::Block = &super::$block::BLOCK;
                    const ROW: &'static $crate::model::Row = &Self::DEFINITION;
                }
            )+
        }

        // Without a use the compiler would not evaluate the associated constant.
        const _: () = assert!($block::BLOCK.is_ordered(), "the indices of a block rise");
    };
}

/// The blocks of a device: the variant for the parameters of a block, then its locations; none where only another
/// variant of the device has the block.
#[macro_export]
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

#[doc(hidden)]
pub use {block, block_type, blocks, row_codes, storage, value_type};
