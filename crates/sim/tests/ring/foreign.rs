//! profirust 0.6.0, an independent master, in a ring with masters of this project, on a virtual port with a virtual clock.
//!
//! profirust counts microseconds, so the rate is 500 kbit/s: 2 us per bit, without rounding. It is polled every few bit times.
//! The referee ignores its violations and checks the masters of this project.

use super::line::{Asker, Bounds, HSA, Master, slave_of};
use crate::common::{CFG, IDENT, Plain};
use profirust::dp::{DpMaster, Peripheral, PeripheralEvent, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use profirust::{Baudrate, time};
use profivac_dp::link::active::{Active, BusParameters, RingState};
use profivac_dp::link::{Baud, BitTime, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_sim::{Fault, Segment, StationHandle};
use profivac_wire::{MAX_TELEGRAM, Telegram};

const BAUD: Baud = Baud::B500000;
const BIT_US: u64 = 2;
/// The interval of polling, in bit times.
const TICK_TBIT: u64 = 4;
/// The slave that profirust exchanges data with.
const SLAVE: u8 = 60;
/// The address of profirust.
const ADDRESS: u8 = 5;

/// The port between profirust and the line.
#[derive(Default)]
struct Port {
    heard: Vec<u8>,
    /// The characters of an incomplete telegram.
    partial: usize,
    sending: bool,
    given: Option<Vec<u8>>,
}

impl ProfibusPhy for Port {
    fn poll_transmission(&mut self, _now: time::Instant) -> bool {
        self.sending
    }

    fn transmit_data<F: FnOnce(&mut [u8]) -> (usize, R), R>(&mut self, _now: time::Instant, fill: F) -> R {
        let mut buffer = [0; MAX_TELEGRAM + 1];
        let (length, result) = fill(&mut buffer);
        if length > 0 {
            self.given = Some(buffer[..length].to_vec());
            self.sending = true;
        }
        result
    }

    fn receive_data<F: FnOnce(&[u8]) -> (usize, R), R>(&mut self, _now: time::Instant, take: F) -> R {
        let (taken, result) = take(&self.heard);
        self.heard.drain(..taken);
        result
    }

    fn poll_pending_received_bytes(&mut self, _now: time::Instant) -> usize {
        self.heard.len() + self.partial
    }
}

/// profirust as a station of a line.
struct Foreign {
    station: FdlActiveStation,
    master: DpMaster<'static>,
    port: Port,
    sent: Vec<u8>,
    next: BitTime,
    exchanges: u32,
}

impl Foreign {
    fn new(now: BitTime) -> Self {
        let options = PeripheralOptions {
            ident_number: IDENT,
            user_parameters: Some(&[]),
            config: Some(&CFG),
            max_tsdr: 100,
            ..PeripheralOptions::default()
        };
        let mut master = DpMaster::new(Vec::new());
        master.add(Peripheral::new(SLAVE, options, vec![0; 2], vec![0; 2]));
        let mut parameters = ParametersBuilder::new(ADDRESS, Baudrate::B500000);
        // The HSA of profirust is the address after the last one.
        parameters.slot_bits(200).highest_station_address(HSA + 1).gap_wait_rotations(1);
        let mut station = FdlActiveStation::new(parameters.build_verified(&master));
        station.set_online();
        master.enter_operate();
        Self { station, master, port: Port::default(), sent: Vec::new(), next: now, exchanges: 0 }
    }
}

impl Station for Foreign {
    fn telegram(&mut self, _end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let mut octets = [0; MAX_TELEGRAM];
        let length = telegram.emit(&mut octets).unwrap();
        self.port.heard.extend_from_slice(&octets[..length]);
        self.port.partial = 0;
        None
    }

    fn activity(&mut self, _end: BitTime) {
        self.port.partial += 1;
    }

    fn sent(&mut self, _end: BitTime) {
        self.port.sending = false;
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.next = now + TICK_TBIT;
        let time = time::Instant::from_micros(i64::try_from(now.0 * BIT_US).unwrap());
        self.station.poll(time, &mut self.port, &mut self.master);
        if let Some((_, PeripheralEvent::DataExchanged)) = self.master.take_last_events().peripheral {
            self.exchanges += 1;
        }
        self.sent = self.port.given.take()?;
        Some(Transmit { not_before: now, octets: &self.sent })
    }

    fn wake_at(&self) -> Option<BitTime> {
        Some(self.next)
    }
}

fn ours(address: u8, now: BitTime) -> Master {
    let segment = BusParameters { hsa: HSA, gap_factor: 1, rotation_tbit: 5000, ..BusParameters::new(address, BAUD) };
    Active::new(segment.check().unwrap(), Asker::new(slave_of(address)), now)
}

/// Masters of this project at these addresses and profirust, all switched on at once, and their slaves.
fn line(addresses: &[u8]) -> (Segment, Vec<StationHandle<Master>>, StationHandle<Foreign>) {
    let mut segment = Segment::new(BAUD);
    segment.attach(Slave::<_>::new(Plain::new(), SLAVE, BAUD));
    let mut masters = Vec::new();
    for address in addresses {
        segment.attach(Slave::<_>::new(Plain::new(), slave_of(*address), BAUD));
        masters.push(segment.attach(ours(*address, BitTime(0))));
    }
    let foreign = segment.attach(Foreign::new(BitTime(0)));
    segment.exempt(foreign.id());
    (segment, masters, foreign)
}

#[test]
fn profirust_and_our_masters_form_one_ring_and_exchange_data_with_their_slaves() {
    for addresses in [&[2][..], &[9], &[2, 9], &[3, 4], &[6, 12]] {
        let (mut segment, masters, foreign) = line(addresses);
        let mut all = addresses.to_vec();
        all.push(ADDRESS);
        segment
            .run_for(Bounds::of(&all).begin(all.len()))
            .unwrap_or_else(|violation| panic!("{addresses:?}: {violation}"));
        let answered =
            |segment: &Segment| masters.iter().map(|master| segment.station(*master).user.answered).collect::<Vec<_>>();
        let (before, theirs) = (answered(&segment), exchanges(&segment, foreign));
        segment.expect_ring(&all, segment.now());
        segment.run_for(500_000).unwrap_or_else(|violation| panic!("{addresses:?}: {violation}"));
        let foreign = segment.station(foreign);
        assert!(
            foreign.station.is_in_ring() && foreign.master.iter().all(|(_, gauge)| gauge.is_running()),
            "{addresses:?}"
        );
        assert!(foreign.exchanges > theirs + 100, "{addresses:?}: {} exchanges", foreign.exchanges - theirs);
        for ((master, before), after) in masters.iter().zip(before).zip(answered(&segment)) {
            assert!(after > before + 100, "{addresses:?}: {} answers", after - before);
            assert_eq!(segment.station(*master).ring_state(), RingState::InRing);
            assert_eq!(segment.station(*master).user.failed, 0);
        }
    }
}

fn exchanges(segment: &Segment, foreign: StationHandle<Foreign>) -> u32 {
    segment.station(foreign).exchanges
}

/// A complete ring of our masters at 2 and 9 and profirust.
fn ring_of_three() -> (Segment, Vec<StationHandle<Master>>, StationHandle<Foreign>) {
    let (mut segment, masters, foreign) = line(&[2, 9]);
    segment.run_for(Bounds::of(&[2, ADDRESS, 9]).begin(3)).unwrap();
    (segment, masters, foreign)
}

#[test]
fn our_masters_continue_when_profirust_loses_power_and_admit_it_again() {
    for after in (0..3_000).step_by(61) {
        let (mut segment, masters, foreign) = ring_of_three();
        segment.run_for(after).unwrap();
        segment.inject(Fault::Power(foreign.id(), false));
        segment.run_for(Bounds::of(&[2, 9]).token_lost(1)).unwrap();
        segment.expect_ring(&[2, 9], segment.now());
        segment.run_for(30_000).unwrap_or_else(|violation| panic!("{after}: {violation}"));
        segment.expect_ring(&[], segment.now());
        *segment.station_mut(foreign) = Foreign::new(segment.now());
        segment.inject(Fault::Power(foreign.id(), true));
        segment.run_for(Bounds::of(&[2, ADDRESS, 9]).join()).unwrap_or_else(|violation| panic!("{after}: {violation}"));
        segment.expect_ring(&[2, ADDRESS, 9], segment.now());
        segment.run_for(30_000).unwrap_or_else(|violation| panic!("{after}: {violation}"));
        assert!(masters.iter().all(|master| segment.station(*master).masters().eq([2, ADDRESS, 9])), "{after}");
    }
}

#[test]
fn profirust_admits_our_master_again() {
    for after in (0..3_000).step_by(61) {
        let (mut segment, masters, foreign) = ring_of_three();
        segment.run_for(after).unwrap();
        segment.inject(Fault::Power(masters[1].id(), false));
        segment.run_for(40_000).unwrap_or_else(|violation| panic!("{after}: {violation}"));
        *segment.station_mut(masters[1]) = ours(9, segment.now());
        segment.inject(Fault::Power(masters[1].id(), true));
        let before = exchanges(&segment, foreign);
        segment.run_for(Bounds::of(&[2, ADDRESS, 9]).join()).unwrap_or_else(|violation| panic!("{after}: {violation}"));
        segment.expect_ring(&[2, ADDRESS, 9], segment.now());
        segment.run_for(30_000).unwrap_or_else(|violation| panic!("{after}: {violation}"));
        assert_eq!(segment.station(masters[1]).ring_state(), RingState::InRing, "{after}");
        assert!(exchanges(&segment, foreign) > before + 20, "{after}");
    }
}
