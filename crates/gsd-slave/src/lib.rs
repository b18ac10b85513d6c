#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs, clippy::indexing_slicing, clippy::arithmetic_side_effects)]

mod catalog;
mod found;
mod layout;
mod selection;
mod slave;
mod words;

pub use catalog::{Catalog, CatalogError, ChoiceError, Entry, FolderFiles, MAX_OCTETS, Unread, has_gsd_ending};
pub use found::{FoundError, FoundModules, FoundSlot};
pub use layout::{Area, Direction, Layout, ModuleData, PlacedModule};
pub use selection::{Change, ModuleChoice, Modules, Selection, SelectionError, Value};
pub use slave::{GsdSlave, SlaveError};
pub use words::listed;
