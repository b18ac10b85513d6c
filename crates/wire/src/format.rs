//! `defmt::Format` for the types of bit fields, which no derive covers: the bits in hexadecimal digits.

use crate::diag::StationStatus;
use crate::global::ControlCommand;
use crate::prm::{Dpv1Status1, Dpv1Status2, Dpv1Status3, PrmStatus};
use defmt::{Format, Formatter};

macro_rules! bits {
    ($($name:ident),*) => {$(
        impl Format for $name {
            fn format(&self, f: Formatter<'_>) {
                defmt::write!(f, "{=u32:#x}", u32::from(self.bits()));
            }
        }
    )*};
}

bits!(StationStatus, ControlCommand, PrmStatus, Dpv1Status1, Dpv1Status2, Dpv1Status3);
