//! The timers of an MS2 connection, exact to a bit time. profibus-wire 4.9.

use crate::rig;

use profivac_dp::link::{BitTime, CHARACTER_TBIT, Station, T_SYN_TBIT};
use rig::{Answer, Gauge, INITIATE, MASTER, RS, Rig, hex, low};

/// T of the rig's connections: 1 s at 1.5 Mbit/s.
const T: u64 = 1_500_000;

const SAP: u8 = 48;
const TIMEOUT: &str = "58 00 13";
const OPENED: &str = "57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00";

/// A connection on SAP 48 and the moment its timer was started last, which is the end of a request.
struct Timed {
    rig: Rig,
    since: BitTime,
}

impl Timed {
    fn new(send_timeout: &str) -> Self {
        let mut rig = Rig::new(Gauge::default());
        let initiate = INITIATE.replace("00 64 01", &format!("{send_timeout} 01"));
        assert_eq!(rig.ms2(1, 49, &initiate), low("56 30 00 64"));
        Self { rig, since: BitTime(0) }.noted()
    }

    /// The last request started the timer.
    fn noted(mut self) -> Self {
        self.since = self.rig.request_end;
        self
    }

    fn sends(mut self, pdu: &str, expected: Answer) -> Self {
        assert_eq!(self.rig.ms2(1, SAP, pdu), expected);
        self.noted()
    }

    /// A poll that ends `tbit` bit times after the start of the timer.
    fn polls_after(mut self, tbit: u64, expected: Answer) -> Self {
        let poll = T_SYN_TBIT + 11 * CHARACTER_TBIT;
        let (begins, ends) = (self.rig.now, self.since + tbit);
        assert!(begins + poll <= ends, "time only goes forward");
        self.rig.pass(ends - (begins + poll));
        assert_eq!(self.rig.ms2(1, SAP, ""), expected);
        self
    }
}

#[test]
fn a_response_not_fetched_for_t_becomes_an_abort() {
    let opened = low(OPENED);
    Timed::new("00 64").polls_after(T - 1, opened.clone());
    Timed::new("00 64").polls_after(T, low(TIMEOUT));
    let record = low("5E 00 10 04 DE AD BE EF");
    let asked = || Timed::new("00 64").sends("", opened.clone()).sends("5E 00 10 04", Answer::Ack);
    asked().polls_after(T - 1, record);
    asked().polls_after(T, low(TIMEOUT)).polls_after(T + 400, RS);
}

#[test]
fn an_abort_not_fetched_for_t_closes_the_connection() {
    Timed::new("00 64").polls_after(2 * T - 1, low(TIMEOUT));
    Timed::new("00 64").polls_after(2 * T, RS);
}

#[test]
fn an_open_connection_waits_2_t_for_a_request_and_polls_do_not_count() {
    let opened = || Timed::new("00 64").sends("", low(OPENED));
    opened().polls_after(2 * T - 1, Answer::Ack);
    opened().polls_after(T, Answer::Ack).polls_after(2 * T - 1, Answer::Ack).polls_after(2 * T + 400, low(TIMEOUT));
    opened().polls_after(2 * T, low(TIMEOUT)).polls_after(2 * T + 400, RS);
    opened().polls_after(3 * T - 1, low(TIMEOUT));
    opened().polls_after(3 * T, RS);
}

#[test]
fn every_request_restarts_the_2_t_of_the_connection() {
    let opened = low(OPENED);
    let idle = Timed::new("00 64").sends("", opened).polls_after(2 * T - 1000, Answer::Ack).sends("48", Answer::Ack);
    idle.polls_after(T - 1, low("48")).noted().polls_after(2 * T - 1, Answer::Ack);
}

#[test]
fn the_greater_send_timeout_is_used() {
    let opened = low(OPENED);
    Timed::new("00 01").polls_after(T - 1, opened.clone());
    Timed::new("00 01").polls_after(T, low(TIMEOUT));
    Timed::new("00 C8").polls_after(2 * T - 1, opened);
    Timed::new("00 C8").polls_after(2 * T, low(TIMEOUT));
}

/// A caller may poll the slave late: timers that expired meanwhile take effect at their own time.
#[test]
fn missed_deadlines_count_from_their_own_time() {
    let mut timed = Timed::new("00 64");
    timed.rig.now = timed.since + 2 * T;
    assert_eq!(timed.rig.ms2(1, SAP, ""), RS);
}

#[test]
fn the_slave_asks_to_be_woken_at_the_earliest_deadline() {
    let mut rig = Rig::new(Gauge::default());
    assert_eq!(rig.slave.wake_at(), None);
    assert_eq!(rig.ms2(1, 49, INITIATE), low("56 30 00 64"));
    assert_eq!(rig.slave.wake_at(), Some(rig.request_end + T));
    let first = rig.request_end;
    assert_eq!(rig.ms2(3, 49, INITIATE), low("56 2F 00 64"));
    assert_eq!(rig.slave.wake_at(), Some(first + T));
    rig.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00 80 00 00"));
    assert_eq!(rig.slave.wake_at(), Some(rig.request_end + 15_000), "the watchdog");
    rig.slave.power_up(8);
    assert_eq!(rig.slave.wake_at(), None);
}
