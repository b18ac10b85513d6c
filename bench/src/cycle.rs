//! How long a cycle takes, in bit times, over the least it can take. profibus-wire 8.1 and 8.2.
//!
//! 1.5 Mbit/s, T_SL 300, G = 10, two octets each way, T_SDR 11; Global_Control every 50th cycle, and T_ID1 = 37 bit times
//! after a token to oneself. The minimum is one message per slave, one token and T_ID1; GAP and Global_Control come on top.
//! profirust 0.6.0 has the same bus parameters; it sends Global_Control every 50 T_SL and waits as it does. It is polled in
//! every bit time, as an ideal driver could.

use crate::master::{Ours, Theirs};
use profivac_dp::link::BitTime;

/// The numbers of slaves in the rows of the table.
pub const SLAVES: [u8; 4] = [1, 8, 32, 124];

/// The measured time: every address of the GAP and part of the pause after it.
const CYCLES: u32 = 1_250;

/// The least a cycle can take: messages of 198 + 11 (2 + 2) + T_SDR + T_ID1, the token and T_ID1.
#[must_use]
pub const fn least_tbit(slaves: u8) -> u64 {
    slaves as u64 * (198 + 11 * 4 + 11 + 37) + 33 + 37
}

/// The average cycle of our master.
#[must_use]
pub fn ours_tbit(slaves: u8) -> f64 {
    let mut master = Ours::exchanging(slaves);
    average(slaves, || {
        master.step();
        master.clock()
    })
}

/// The average cycle of profirust.
#[must_use]
pub fn theirs_tbit(slaves: u8) -> f64 {
    let mut master = Theirs::exchanging(slaves);
    average(slaves, || {
        master.step(1);
        master.clock()
    })
}

/// Lets a master work, from the end of one exchange to the end of another.
fn average(slaves: u8, mut step: impl FnMut() -> (u32, BitTime)) -> f64 {
    let (mut exchanges, mut begin) = step();
    // A few cycles until it is in step.
    let first = exchanges + 50 * u32::from(slaves);
    while exchanges < first {
        (exchanges, begin) = step();
    }
    let last = exchanges + CYCLES * u32::from(slaves);
    let mut end = begin;
    while exchanges < last {
        (exchanges, end) = step();
    }
    (end - begin) as f64 / f64::from(CYCLES)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// During a scan of the GAP, with one address in each cycle: 66 bit times and at most T_SL. Then G x T_TR without.
    /// Every 50th cycle Global_Control: 143 bit times and T_ID2. Nothing else is allowed to cost anything.
    #[test]
    fn a_cycle_takes_the_minimum_plus_gap_and_global_control() {
        for slaves in SLAVES {
            let over = ours_tbit(slaves) - least_tbit(slaves) as f64;
            let asked = 126.0;
            let pause = 10.0 * 300_000.0 / least_tbit(slaves) as f64;
            // The measured cycles may begin and end with the GAP: one more of its scans than on average.
            let rounds = (f64::from(CYCLES) / (asked + pause)).ceil() + 1.0;
            let most =
                f64::from(66 + 300) * (rounds * asked / f64::from(CYCLES)).min(1.0) + f64::from(143 + 150) / 50.0;
            assert!((0.0..=most + 1.0).contains(&over), "{over} bit times more than the least with {slaves} slaves");
        }
    }
}
