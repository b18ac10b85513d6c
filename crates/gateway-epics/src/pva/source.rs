//! The values behind the names: fields of records, and the table of all gauges.

use crate::database::{Target, World};
use crate::pva::normative::{self, Shape};
use crate::pva::wire::Writer;

/// What a channel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A field of a record, and its type.
    Record(Target, Shape),
    /// The table of all gauges.
    Table,
}

impl Source {
    /// The value with this name.
    #[must_use]
    pub fn named(name: &str, world: &World) -> Option<Self> {
        if name == world.database.table {
            return Some(Self::Table);
        }
        let target = world.database.find(name)?;
        Some(Self::Record(target, Shape::of(&world.read(target)?.sample.data)))
    }

    /// Its type.
    #[must_use]
    pub const fn shape(self) -> Shape {
        match self {
            Self::Record(_, shape) => shape,
            Self::Table => Shape::Table,
        }
    }

    /// How often it has changed.
    #[must_use]
    pub fn version(self, world: &World) -> u64 {
        match self {
            Self::Record(target, _) => world.version(target),
            Self::Table => normative::table_version(world),
        }
    }

    /// Writes the value with the set of its fields; `false` if it cannot be read.
    pub fn put(self, world: &World, is_whole: bool, out: &mut Writer) -> bool {
        let shape = self.shape();
        match (is_whole, shape.changing_fields()) {
            (true, _) => out.bits(&[0]),
            (false, fields) => out.bits(&fields),
        }
        match self {
            Self::Table => normative::put_table(out, world, is_whole),
            Self::Record(target, _) => {
                let Some(answer) = world.read(target).filter(|answer| Shape::of(&answer.sample.data) == shape) else {
                    return false;
                };
                if is_whole { normative::put_whole(out, &answer) } else { normative::put_changing(out, &answer) }
            }
        }
        true
    }
}
