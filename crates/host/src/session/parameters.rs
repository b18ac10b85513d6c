//! The bus parameters of a master on a port of an operating system.

use crate::clock::{duration_of, tbit_of};
use crate::port::Delivery;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use std::time::Duration;

/// G. Each request to an absent address costs a slot time, which is long on such a port; a longer pause would delay the
/// entry of another master into the ring: [`entry_time`]. chosen.
const GAP_FACTOR: u8 = 2;

/// The longest slot time of PROFIBUS, in bit times. profibus-wire 1.12.
pub const MAX_SLOT_TBIT: u32 = 16_383;

/// The bus parameters of a master on a port of an operating system: the slot time is longer by what the port delays.
#[must_use]
pub fn bus_parameters(address: u8, baud: Baud, delivery: Delivery) -> BusParameters {
    let bus = BusParameters::new(address, baud);
    let delay_tbit = u32::try_from(tbit_of(baud, delivery.slot_delay(baud))).unwrap_or(u32::MAX);
    BusParameters { slot_tbit: bus.slot_tbit.saturating_add(delay_tbit), gap_factor: GAP_FACTOR, ..bus }
}

/// How long a ring of such masters may take to admit another one. Many seconds on a slow line: see
/// [`BusParameters::entry_tbit`].
#[must_use]
pub fn entry_time(bus: &BusParameters, baud: Baud) -> Duration {
    duration_of(baud, bus.entry_tbit())
}
