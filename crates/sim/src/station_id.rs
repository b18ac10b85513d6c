//! Names for the stations of a segment.

use std::fmt;
use std::marker::PhantomData;

/// Identifies a station of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StationId(pub(crate) usize);

impl fmt::Display for StationId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "station #{}", self.0)
    }
}

/// Identifies a station of a segment, with its type.
#[derive(Debug)]
pub struct StationHandle<S> {
    id: StationId,
    kind: PhantomData<fn() -> S>,
}

impl<S> StationHandle<S> {
    /// The handle of a station of type `S`.
    pub(crate) const fn new(id: StationId) -> Self {
        Self { id, kind: PhantomData }
    }

    /// The identification without the type.
    #[must_use]
    pub const fn id(self) -> StationId {
        self.id
    }
}

impl<S> Clone for StationHandle<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for StationHandle<S> {}
