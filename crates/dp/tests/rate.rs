//! A slave that searches the baud rate of a bus. profibus-wire 3.6, 3.7 and 3.2, transition 15.

use crate::rig;

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Rate, RateControl, Received, Receiver, Station, T_SYN_TBIT};
use profivac_dp::slave::SlaveState;
use profivac_wire::{DataTelegram, Telegram};
use rig::{Gauge, MASTER, RS, Rig, SLAVE, emit, hex};

/// A port: it has the rate of the station, receives garbage at any other rate, and never sends while searching.
struct Port {
    rig: Rig,
    control: RateControl,
    receiver: Receiver,
    now: BitTime,
    /// The rate of the bus.
    bus: Baud,
}

impl Port {
    fn new(bus: Baud) -> Self {
        let now = BitTime(0);
        let rig = Rig::new(Gauge::default());
        Self { rig, control: RateControl::automatic(now), receiver: Receiver::new(now), now, bus }
    }

    /// At another rate characters break.
    fn receive(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.now = self.now + T_SYN_TBIT;
        let mut answer = None;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            if self.control.rate().baud() != self.bus {
                self.receiver.character_error(self.now);
                continue;
            }
            let Received::Telegram(telegram) = self.receiver.octet(self.now, *octet) else { continue };
            if self.control.telegram_received(self.now, &telegram, SLAVE) {
                self.rig.slave.rate_found(self.control.rate().baud());
            }
            answer = self.rig.slave.telegram(self.now, &telegram).map(|transmit| transmit.octets.to_vec());
        }
        assert!(answer.is_none() || matches!(self.control.rate(), Rate::Found(_)), "sent while searching");
        answer
    }

    /// Passes time without octets until the next deadline of the control.
    fn silence(&mut self) {
        let Some(wake) = self.control.wake_at() else { return };
        self.now = wake;
        assert_eq!(self.rig.slave.poll(wake), None);
        if self.control.elapse(wake, self.rig.slave.watchdog_is_running()) {
            self.now = BitTime(0);
            self.receiver = Receiver::new(self.now);
        }
    }
}

const STATUS_OF_9: &str = "10 09 02 49 54 16";
const STATUS_OF_8: &str = "10 08 02 49 53 16";

/// errata-bpg-bcg-tpg 9, errata-pxg55x-img400 56: there is no other way to set the rate.
#[test]
fn every_rate_is_found_by_listening_to_others() {
    for bus in Baud::ALL {
        let mut port = Port::new(bus);
        for _ in 0..Baud::ALL.len() {
            assert_eq!(port.receive(&hex(STATUS_OF_9)), None);
            if port.control.rate() == Rate::Found(bus) {
                break;
            }
            port.silence();
        }
        assert_eq!(port.control.rate(), Rate::Found(bus));
        assert_eq!(port.receive(&hex(STATUS_OF_8)), Some(hex("10 02 08 00 0A 16")), "{bus}");
    }
}

fn port_in_data_exchange(prm: &str) -> Port {
    let mut port = Port::new(Baud::B12000000);
    port.receive(&hex(STATUS_OF_9));
    for (sap, du, fc) in [(61, prm, 0x6D), (62, "11 21", 0x5D)] {
        let du = hex(du);
        let data = DataTelegram { da: SLAVE, sa: MASTER, dsap: Some(sap), ssap: Some(62), fc, du: &du };
        assert_eq!(port.receive(&emit(&Telegram::Data(data))), Some(vec![0xE5]));
    }
    assert!(matches!(port.rig.slave.state(), SlaveState::DataExch(..)));
    port
}

#[test]
fn a_slave_without_a_watchdog_keeps_exchanging_when_the_rate_is_found_again() {
    let mut port = port_in_data_exchange("80 01 01 00 12 34 00");
    port.silence();
    assert_eq!(port.control.rate(), Rate::Searching(Baud::B12000000));
    assert!(matches!(port.rig.slave.state(), SlaveState::DataExch(..)));
    port.receive(&hex(STATUS_OF_9));
    let answer = port.receive(&hex("68 05 05 68 08 02 7D AA 55 86 16"));
    assert_eq!(answer, Some(hex("68 05 05 68 02 08 08 01 02 15 16")));
}

#[test]
fn a_slave_with_a_watchdog_leaves_its_master_first() {
    let mut port = port_in_data_exchange("88 01 01 00 12 34 00");
    port.silence();
    assert!(matches!(port.rig.slave.state(), SlaveState::WaitPrm(_)));
    assert_eq!(port.control.rate(), Rate::Searching(Baud::B12000000));
}

#[test]
fn a_lost_rate_closes_connections_and_clears_the_frame_count() {
    let mut rig = Rig::new(Gauge::default());
    rig.connect(1);
    let request = hex("68 05 05 68 88 82 5D 3C 3E E1 16");
    let before = rig.raw(&request);
    rig.slave.rate_found(Baud::B19200);
    rig.device().event = true;
    assert_ne!(rig.raw(&request), before, "no repetition");
    assert_eq!(rig.ms2(1, 48, ""), RS);
    assert_eq!(rig.slave.wake_at(), None);
}

#[test]
fn times_follow_the_rate_that_was_found() {
    let mut rig = Rig::new(Gauge::default());
    rig.slave.rate_found(Baud::B19200);
    rig.ms0(MASTER, 61, &hex("88 0A 0A 00 12 34 00"));
    assert_eq!(rig.slave.wake_at(), Some(rig.request_end + 19_200));
    rig.slave.rate_found(Baud::B12000000);
    assert!(matches!(rig.slave.state(), SlaveState::WaitPrm(_)), "the watchdog's time was in other bits");
}

/// A value that fits a fast rate is longer than the whole slot time of a slow one.
#[test]
fn min_tsdr_fits_the_rate_that_was_found() {
    for (baud, min_tsdr) in [(Baud::B6000000, 200), (Baud::B1500000, 150), (Baud::B187500, 60), (Baud::B9600, 60)] {
        let mut rig = Rig::new(Gauge::default());
        rig.slave.rate_found(Baud::B12000000);
        rig.ms0(MASTER, 61, &hex("80 00 00 C8 12 34 00"));
        assert_eq!(rig.slave.min_tsdr_tbit(), 200);
        rig.slave.rate_found(baud);
        assert_eq!(rig.slave.min_tsdr_tbit(), min_tsdr, "{baud}");
    }
}
