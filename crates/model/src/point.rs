//! The kinds of points of a slave.

use crate::words;

words! {
    /// What the values of a point of a slave are.
    pub enum PointKind {
        /// A quantity, which has a mean.
        Number = "number",
        /// A code or a bit: its values have no mean.
        Code = "code",
    }
}
