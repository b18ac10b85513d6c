//! Whole numbers of users. A number that does not fit is wrong usage, as every other value that the package refuses.

use crate::failure::Failure;
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use std::fmt::Display;

/// A whole number that fits into `T`.
#[derive(Clone, Copy)]
pub struct Whole<T>(pub T);

/// A type of whole numbers with its ends.
pub trait Ends: Sized {
    /// The lowest and the highest number.
    const ENDS: (Self, Self);
}

impl Ends for u8 {
    const ENDS: (Self, Self) = (Self::MIN, Self::MAX);
}

impl Ends for u32 {
    const ENDS: (Self, Self) = (Self::MIN, Self::MAX);
}

impl Ends for u64 {
    const ENDS: (Self, Self) = (Self::MIN, Self::MAX);
}

impl<'py, T> FromPyObject<'_, 'py> for Whole<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr> + Ends + Display,
{
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<T>() {
            Ok(number) => Ok(Self(number)),
            Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
                let (low, high) = T::ENDS;
                let found = object.str()?;
                Err(Failure::usage(format!("expected a whole number from {low} to {high}, got {found}")).into())
            }
            Err(error) => Err(error),
        }
    }
}
