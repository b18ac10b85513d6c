//! A master alone with a test that answers for everybody else.

use super::{bus, hex, is_housekeeping, text};
use profivac_dp::link::active::{Active, FdlUser};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters, services};

/// What the master sent, and when it began.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    pub start: BitTime,
    pub octets: Vec<u8>,
}

impl Said {
    pub fn text(&self) -> String {
        text(&self.octets)
    }

    pub fn is_token(&self) -> bool {
        self.octets[0] == 0xDC
    }
}

/// No test takes so many telegrams of the master: it goes on for ever about nothing, and what is waited for never comes.
const TELEGRAMS: u32 = 2_000_000;

/// So often a master may be polled without a word. Each time it has something else to wait for.
const SILENT_POLLS: u32 = 100;

#[derive(Clone)]
pub struct Desk<R> {
    pub station: Active<R>,
    receiver: Receiver,
    /// When the last telegram ended, whoever sent it.
    pub now: BitTime,
    said: u32,
}

impl Desk<Master<1, 8>> {
    /// A master that has just exchanged 01 02 with slave 8 and sends nothing more by itself: FCB = 0 comes next.
    pub fn exchanging() -> Self {
        let settings = Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) };
        let mut desk = Self::new(Master::on(bus(), settings, BitTime(0)));
        let slave = SlaveParameters { user_prm: &[0x80, 0, 0], ..SlaveParameters::new(8, 0x1234, &[0x11, 0x21]) };
        desk.station.user.add(&slave).unwrap();
        desk.station.user.set_mode(Mode::Operate);
        let ready = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";
        desk.asks();
        for answer in ["10 02 08 00 0A 16", "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", "E5", "E5", ready] {
            desk.hears(answer);
            desk.asks();
        }
        assert_eq!(desk.asks().text(), "68 05 05 68 08 02 7D 00 00 87 16");
        desk.station.user.set_mode(Mode::Stop);
        let inputs = "68 05 05 68 02 08 08 01 02 15 16";
        desk.hears(inputs);
        if desk.takes_leave(inputs) {
            // FCB = 0 comes next.
            desk.station.user.submit_request(&services::rd_inp(8)).unwrap();
            desk.asks();
            desk.hears("E5");
            desk.station.user.take_confirmation();
        }
        desk
    }
}

impl<R: FdlUser> Desk<R> {
    pub fn new(station: Active<R>) -> Self {
        Self { station, receiver: Receiver::new(BitTime(0)), now: BitTime(0), said: 0 }
    }

    /// The next telegram of the master. Nobody else speaks until it has left.
    pub fn says(&mut self) -> Said {
        self.said += 1;
        assert!(self.said < TELEGRAMS, "the master has sent {TELEGRAMS} telegrams, and none of them ended the test");
        for _ in 0..SILENT_POLLS {
            let due = self.station.wake_at().expect("a master always has something to wait for");
            self.now = self.now.max(due);
            if let Some(transmit) = self.station.poll(self.now) {
                let said = Said { start: transmit.not_before.max(self.now), octets: transmit.octets.to_vec() };
                self.now = said.start + said.octets.len() as u64 * CHARACTER_TBIT;
                self.station.sent(self.now);
                return said;
            }
        }
        panic!("at {} the master was polled {SILENT_POLLS} times and said nothing", self.now);
    }

    /// The next telegram of the master that is a message to somebody.
    pub fn asks(&mut self) -> Said {
        loop {
            let said = self.says();
            if !is_housekeeping(&said.octets) {
                return said;
            }
        }
    }

    /// The next message to somebody, if there is one in so many bit times.
    pub fn asks_within(&mut self, tbit: u64) -> Option<Said> {
        let limit = self.now + tbit;
        while self.now < limit {
            let said = self.says();
            if !is_housekeeping(&said.octets) {
                return Some(said);
            }
        }
        None
    }

    /// Whatever the master still has to say by itself, each exchange answered by `inputs`. Whether there was one.
    pub fn takes_leave(&mut self, inputs: &str) -> bool {
        let mut exchanged = false;
        while let Some(said) = self.asks_within(10_000) {
            if said.octets[4] != 0xFF {
                exchanged = !exchanged;
                self.hears(inputs);
            }
        }
        exchanged
    }

    /// After `gap` bit times of idle line the master hears the octets in `telegram`.
    pub fn hears_after(&mut self, gap: u64, telegram: &str) {
        self.hears_octets(gap, &hex(telegram));
    }

    /// An answer that comes as early as it may.
    pub fn hears(&mut self, telegram: &str) {
        self.hears_after(11, telegram);
    }

    pub fn hears_octets(&mut self, gap: u64, octets: &[u8]) {
        self.now = self.now + gap;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            // The character counts if it ends in the last bit time of a wait.
            if self.station.wake_at().is_some_and(|due| due < self.now) {
                let said = self.station.poll(self.now).map(|transmit| text(transmit.octets));
                assert_eq!(said, None, "the master speaks before this is heard");
            }
            match self.receiver.octet(self.now, *octet) {
                Received::Telegram(telegram) => assert_eq!(self.station.telegram(self.now, &telegram), None),
                Received::Nothing | Received::Damaged(_) => self.station.activity(self.now),
            }
        }
    }

    /// Plays a dialogue: `M` lines are the next message of the master, `S` lines what it hears then.
    /// Everything after `|` is a remark.
    pub fn dialogue(&mut self, script: &str) {
        for line in script.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let telegram = line[1..].split('|').next().unwrap().trim();
            match &line[..1] {
                "M" => assert_eq!(self.asks().text(), telegram, "instead of: {line}"),
                "S" => self.hears(telegram),
                _ => panic!("neither master nor slave: {line}"),
            }
        }
    }
}
