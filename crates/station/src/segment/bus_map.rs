//! The stations on the bus, as the master sees them.

use crate::config;
use crate::view::{BusStation, BusStationState, SegmentState};
use profivac_dp::link::Baud;
use profivac_dp::link::active::RingState;
use profivac_host::session::BusSession;

/// The state of a bus as its master sees it.
pub struct BusState {
    /// The state of the segment.
    pub state: SegmentState,
    /// The reason why it does not run.
    pub problem: Option<String>,
    /// The duration of a cycle in milliseconds.
    pub cycle_ms: Option<f64>,
    /// Damaged telegrams since the port was opened.
    pub damaged_telegrams: u32,
    /// Stations that are not in the station's file.
    pub others: Vec<BusStation>,
}

impl BusState {
    /// The state of a segment without a port.
    pub const WAITING: Self =
        Self { state: SegmentState::Waiting, problem: None, cycle_ms: None, damaged_telegrams: 0, others: Vec::new() };

    /// Asks the master.
    pub fn of(session: &mut BusSession, config: &config::Segment) -> Self {
        let ring = session.ring_state();
        let (state, problem) = match ring {
            RingState::InRing => (SegmentState::Running, None),
            RingState::AddressTaken => (SegmentState::Listening, Some(format!("the master of this station {ring}"))),
            RingState::Offline | RingState::Listening | RingState::Ready => (SegmentState::Listening, None),
        };
        let cycle_ms = milliseconds(session.master().cycle_tbit(), config.baud);
        let masters: Vec<_> = session.masters().filter(|address| *address != config.master).collect();
        let masters = masters.into_iter().map(other_master);
        let others = masters.chain(session.known_slaves().into_iter().map(unconfigured)).collect();
        Self { state, problem, cycle_ms, damaged_telegrams: session.damaged_telegrams(), others }
    }
}

/// The station's own master.
pub fn own_master(address: u8) -> BusStation {
    station(address, BusStationState::OwnMaster, "the master of this station")
}

fn other_master(address: u8) -> BusStation {
    station(address, BusStationState::OtherMaster, "another master in the ring")
}

fn unconfigured(address: u8) -> BusStation {
    station(address, BusStationState::Unconfigured, "a slave that is not in the station's file")
}

fn station(address: u8, state: BusStationState, description: &str) -> BusStation {
    BusStation { address, state, name: None, device: None, ident: None, description: description.to_owned() }
}

/// A time on the bus in milliseconds; `None` for no time.
pub fn milliseconds(tbit: u64, baud: Baud) -> Option<f64> {
    (tbit > 0).then(|| tbit as f64 * 1e3 / f64::from(baud.bits_per_second()))
}
