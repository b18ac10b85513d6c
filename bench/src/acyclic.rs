//! A class 2 master that reads a record of four octets repeatedly. The answers of the slave are prepared, so that only the
//! master is counted: request, SC, poll and response, and the tokens between them.

use crate::rig::{BAUD, MASTER, telegram};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::ms2::Connect;
use profivac_dp::master::{Handle, Master, Ms2Parameters, Settings};
use profivac_wire::DataTelegram;
use std::hint::black_box;

const SLAVE: u8 = 8;

/// The answers of the slave: to Initiate, to the poll for its response, and to the poll for the record.
struct Answers {
    manager: Vec<u8>,
    opened: Vec<u8>,
    record: Vec<u8>,
    is_open: bool,
}

impl Answers {
    fn new() -> Self {
        let frame =
            |ssap, du| telegram(DataTelegram { da: MASTER, sa: SLAVE, dsap: Some(50), ssap: Some(ssap), fc: 0x08, du });
        Self {
            manager: frame(49, &[0x56, 48, 0, 100]),
            opened: frame(48, &[0x57, 240, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0]),
            record: frame(48, &[0x5E, 1, 16, 4, 1, 2, 3, 4]),
            is_open: false,
        }
    }

    fn to(&mut self, request: &[u8]) -> Option<&[u8]> {
        match request {
            [0x68, _, _, _, _, _, _, 49, ..] => Some(&self.manager),
            [0x68, 5, ..] if std::mem::replace(&mut self.is_open, true) => Some(&self.record),
            [0x68, 5, ..] => Some(&self.opened),
            [0x68, ..] => Some(&[0xE5]),
            _ => None,
        }
    }
}

struct Client {
    station: Active<Master<0, 0>>,
    receiver: Receiver,
    answers: Answers,
    now: BitTime,
}

impl Client {
    /// The next telegram of the master, and its answer if there is one.
    fn step(&mut self) {
        self.now = self.station.wake_at().unwrap_or(self.now).max(self.now);
        let Some(transmit) = self.station.poll(self.now) else { return };
        self.now = transmit.not_before.max(self.now) + CHARACTER_TBIT * transmit.octets.len() as u64;
        let answer = self.answers.to(transmit.octets);
        self.station.sent(self.now);
        let Some(answer) = answer else { return };
        let first = self.now + 11 + CHARACTER_TBIT;
        if let (_, Received::Telegram(telegram)) = self.receiver.octets(first, answer) {
            self.now = self.now + 11 + CHARACTER_TBIT * answer.len() as u64;
            black_box(self.station.telegram(self.now, &telegram));
        }
    }

    fn read(&mut self, connection: Handle<Connect>) {
        let read = loop {
            if let Ok(read) = self.station.user.ms2_read(connection, 1, 16, 4) {
                break read;
            }
            self.step();
        };
        loop {
            self.step();
            if let Some(Ok(record)) = self.station.user.outcome(read) {
                black_box(record);
                return;
            }
        }
    }
}

/// Runs `times` reads.
pub fn read(times: u32) {
    let bus = BusParameters { hsa: MASTER, ..BusParameters::new(MASTER, BAUD) };
    let bus = bus.check().unwrap_or_else(|rejected| unreachable!("{rejected}"));
    let station = Master::on(bus, Settings::new(BAUD), BitTime(0));
    let mut client = Client { station, receiver: Receiver::new(BitTime(0)), answers: Answers::new(), now: BitTime(0) };
    let parameters = Ms2Parameters { pace_tbit: 0, ..Ms2Parameters::new(BAUD) };
    let connection = client.station.user.ms2_open(SLAVE, &parameters);
    let connection = connection.unwrap_or_else(|refused| unreachable!("{refused}"));
    for _ in 0..times {
        client.read(connection);
    }
}
