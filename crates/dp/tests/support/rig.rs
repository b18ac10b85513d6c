//! A test rig for a master: the test answers for all other stations.

use super::{bus, hex, is_housekeeping, text};
use profivac_dp::link::active::{Active, FdlUser};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters, services};

/// A telegram of the master, and when it began.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    pub start: BitTime,
    pub octets: Vec<u8>,
}

impl Sent {
    pub fn text(&self) -> String {
        text(&self.octets)
    }

    pub fn is_token(&self) -> bool {
        self.octets[0] == 0xDC
    }
}

/// The most telegrams of the master in a test; more mean that the expected telegram is never sent.
const TELEGRAMS: u32 = 2_000_000;

/// The most polls in a row without a telegram. Each time the master has another deadline.
const SILENT_POLLS: u32 = 100;

#[derive(Clone)]
pub struct MasterRig<R> {
    pub station: Active<R>,
    receiver: Receiver,
    /// The end of the last telegram of any station.
    pub now: BitTime,
    sent: u32,
}

impl MasterRig<Master<1, 8>> {
    /// A master that has just exchanged 01 02 with slave 8 and sends nothing more by itself; the next FCB is 0.
    pub fn exchanging() -> Self {
        let settings = Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) };
        let mut rig = Self::new(Master::on(bus().check().unwrap(), settings, BitTime(0)));
        let slave = SlaveParameters { user_prm: &[0x80, 0, 0], ..SlaveParameters::new(8, 0x1234, &[0x11, 0x21]) };
        rig.station.user.add(&slave).unwrap();
        rig.station.user.set_mode(Mode::Operate);
        let ready = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";
        rig.next_request();
        for answer in ["10 02 08 00 0A 16", "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", "E5", "E5", ready] {
            rig.receive(answer);
            rig.next_request();
        }
        assert_eq!(rig.next_request().text(), "68 05 05 68 08 02 7D 00 00 87 16");
        rig.station.user.set_mode(Mode::Stop);
        let inputs = "68 05 05 68 02 08 08 01 02 15 16";
        rig.receive(inputs);
        if rig.finish_stop(inputs) {
            // The next FCB is 0.
            rig.station.user.submit_request(&services::rd_inp(8)).unwrap();
            rig.next_request();
            rig.receive("E5");
            rig.station.user.take_confirmation();
        }
        rig
    }
}

impl<R: FdlUser> MasterRig<R> {
    pub fn new(station: Active<R>) -> Self {
        Self { station, receiver: Receiver::new(BitTime(0)), now: BitTime(0), sent: 0 }
    }

    /// The next telegram of the master. No other station sends until it has left.
    pub fn next_telegram(&mut self) -> Sent {
        self.sent += 1;
        assert!(self.sent < TELEGRAMS, "the master has sent {TELEGRAMS} telegrams, and none of them ended the test");
        for _ in 0..SILENT_POLLS {
            let due = self.station.wake_at().expect("a master always has something to wait for");
            self.now = self.now.max(due);
            if let Some(transmit) = self.station.poll(self.now) {
                let sent = Sent { start: transmit.not_before.max(self.now), octets: transmit.octets.to_vec() };
                self.now = sent.start + sent.octets.len() as u64 * CHARACTER_TBIT;
                self.station.sent(self.now);
                return sent;
            }
        }
        panic!("at {} the master was polled {SILENT_POLLS} times and sent nothing", self.now);
    }

    /// The next request of the master.
    pub fn next_request(&mut self) -> Sent {
        loop {
            let sent = self.next_telegram();
            if !is_housekeeping(&sent.octets) {
                return sent;
            }
        }
    }

    /// The next request, if there is one in `tbit` bit times.
    pub fn next_request_within(&mut self, tbit: u64) -> Option<Sent> {
        let limit = self.now + tbit;
        while self.now < limit {
            let sent = self.next_telegram();
            if !is_housekeeping(&sent.octets) {
                return Some(sent);
            }
        }
        None
    }

    /// The requests that a stopping master still sends, each exchange answered by `inputs`. Returns whether their number was
    /// odd.
    pub fn finish_stop(&mut self, inputs: &str) -> bool {
        let mut exchanged = false;
        while let Some(sent) = self.next_request_within(10_000) {
            if sent.octets[4] != 0xFF {
                exchanged = !exchanged;
                self.receive(inputs);
            }
        }
        exchanged
    }

    /// After `gap` bit times of idle line the master receives the octets in `telegram`.
    pub fn receive_after(&mut self, gap: u64, telegram: &str) {
        self.receive_octets(gap, &hex(telegram));
    }

    /// An answer at the earliest time allowed.
    pub fn receive(&mut self, telegram: &str) {
        self.receive_after(11, telegram);
    }

    pub fn receive_octets(&mut self, gap: u64, octets: &[u8]) {
        self.now = self.now + gap;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            // The character counts if it ends in the last bit time of a wait.
            if self.station.wake_at().is_some_and(|due| due < self.now) {
                let sent = self.station.poll(self.now).map(|transmit| text(transmit.octets));
                assert_eq!(sent, None, "the master sends before it has received this");
            }
            match self.receiver.octet(self.now, *octet) {
                Received::Telegram(telegram) => assert_eq!(self.station.telegram(self.now, &telegram), None),
                Received::Nothing | Received::Damaged(_) => self.station.activity(self.now),
            }
        }
    }

    /// Runs a dialogue: an `M` line is the next request of the master, an `S` line the next telegram that it receives. The text
    /// after `|` is a comment.
    pub fn dialogue(&mut self, script: &str) {
        for line in script.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let telegram = line[1..].split('|').next().unwrap().trim();
            match &line[..1] {
                "M" => assert_eq!(self.next_request().text(), telegram, "instead of: {line}"),
                "S" => self.receive(telegram),
                _ => panic!("neither master nor slave: {line}"),
            }
        }
    }
}
