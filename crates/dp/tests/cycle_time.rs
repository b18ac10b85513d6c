//! The overhead of a cycle over its minimum. profibus-wire 8.1 and 8.2.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use support::line::Line;
use support::plain::Plain;

const BAUD: Baud = Baud::B1500000;
const SLAVES: u64 = 32;

/// The average cycle of 32 slaves with `cfg` at 1.5 Mbit/s (T_SL 300, T_ID1 37), GAP and Global_Control included.
fn cycle_tbit(cfg: &[u8]) -> f64 {
    // G = 10 and HSA = 126 by default; Global_Control every 50th cycle.
    let mut master =
        Master::<32, 32>::on(BusParameters::new(2, BAUD).check().unwrap(), Settings::new(BAUD), BitTime(0));
    master.user.set_mode(Mode::Operate);
    for address in (3..).take(32) {
        master.user.add(&SlaveParameters::new(address, 0x1234, cfg)).unwrap();
    }
    let mut line = Line::new(master);
    (3..).take(32).for_each(|address| line.attach(Plain::new(0x1234, cfg), address));
    line.run_until(2_000_000, |line| line.master.user.exchanging() == 32);
    let (begin, cycles) = (line.now, line.master.user.cycles());
    // The master polls the GAP in every tenth token visit, each address once.
    line.run_until(60_000_000, |line| line.master.user.cycles() == cycles + 1_250);
    (line.now - begin) as f64 / 1_250.0
}

#[test]
fn a_cycle_of_thirty_two_slaves_is_at_most_one_percent_longer_than_the_minimum() {
    for (cfg, octets) in [(&[0x11, 0x21][..], 4), (&[0x17, 0x27], 16)] {
        // T_MC = 198 + 11 (O + I) + T_SDR + T_ID1; one token and T_ID1 after it.
        let least = SLAVES * (198 + 11 * octets + 11 + 37) + 33 + 37;
        let over = cycle_tbit(cfg) / least as f64 - 1.0;
        println!("{:.2} % over {least} bit times", over * 100.0);
        assert!((0.0..0.01).contains(&over));
    }
}
