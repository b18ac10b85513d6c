//! The operations that `cargo bench` counts: one function each, which repeats the operation.
//!
//! Each function prepares everything before its loop, so that the difference between two runs of different length is the
//! operation alone. [`ROWS`] is the table of `docs/benchmarks.md`.

mod acyclic;
pub mod cycle;
mod master;
mod receiver;
mod rig;
mod sensor;
mod slave;
mod telegram;

/// Repeats an operation this number of times.
pub type Operation = fn(u32);

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The name in `bench/baseline.toml`.
    pub key: &'static str,
    /// The operation, and the unit per which the instructions are counted.
    pub what: &'static str,
    /// The operation of this project.
    pub ours: Operation,
    /// The part that is subtracted because it belongs to another operation.
    pub minus: Option<Operation>,
    /// The same by profirust 0.6.0.
    pub peer: Option<Operation>,
    /// The number of units in one operation.
    pub units: u32,
    /// The target for the instructions per unit, if there is one.
    pub target: Option<u32>,
}

/// The whole table.
pub const ROWS: &[Row] = &[
    Row {
        key: "decode-sd2",
        what: "decode an SD2 of 41 octets from a buffer",
        ours: telegram::decode,
        minus: None,
        peer: Some(telegram::decode_peer),
        units: 1,
        target: Some(150),
    },
    Row {
        key: "encode-sd2",
        what: "encode an SD2 of 41 octets into a buffer",
        ours: telegram::encode,
        minus: None,
        peer: Some(telegram::encode_peer),
        units: 1,
        target: Some(150),
    },
    Row {
        key: "receive-octet-in-one-piece",
        what: "receive one octet of an SD2 of 41 that come in one piece, decoding included",
        ours: receiver::receive_piece,
        minus: None,
        peer: None,
        units: 41,
        target: Some(12),
    },
    Row {
        key: "receive-octet-in-pieces-of-8",
        what: "the same, in pieces of eight",
        ours: receiver::receive_pieces,
        minus: None,
        peer: None,
        units: 41,
        target: Some(12),
    },
    Row {
        key: "receive-octet-one-by-one",
        what: "the same, one by one",
        ours: receiver::receive_each,
        minus: None,
        peer: None,
        units: 41,
        target: Some(16),
    },
    Row {
        key: "slave-exchange-in-one-piece",
        what: "slave, one Data_Exchange of 5 octets out and 2 in, the request in one piece",
        ours: slave::in_one_piece,
        minus: None,
        peer: None,
        units: 1,
        target: Some(800),
    },
    Row {
        key: "slave-exchange-octet-by-octet",
        what: "the same, octet by octet",
        ours: slave::octet_by_octet,
        minus: None,
        peer: None,
        units: 1,
        target: Some(800),
    },
    Row {
        key: "slave-last-octet-to-answer",
        what: "of that, from the last octet of the request to the answer",
        ours: slave::octet_by_octet,
        minus: Some(slave::all_but_last),
        peer: None,
        units: 1,
        target: Some(250),
    },
    Row {
        key: "slave-last-octet-to-answer-unprepared",
        what: "the same, if the answer is not prepared",
        ours: slave::unprepared,
        minus: Some(slave::unprepared_all_but_last),
        peer: None,
        units: 1,
        target: None,
    },
    Row {
        key: "bcg450-exchange",
        what: "BCG450, one Data_Exchange with parameter channel and float (C6 87 8E ...)",
        ours: slave::bcg450_exchange,
        minus: None,
        peer: None,
        units: 1,
        target: Some(1500),
    },
    Row {
        key: "bcg450-ms1-read",
        what: "BCG450, one MS1 read of four octets, request and poll",
        ours: slave::ms1_read,
        minus: None,
        peer: None,
        units: 1,
        target: Some(1400),
    },
    Row {
        key: "bcg450-pkw-read",
        what: "BCG450, one read through the parameter channel, instruction and AK 0",
        ours: slave::parameter_channel_read,
        minus: None,
        peer: None,
        units: 1,
        target: Some(2400),
    },
    Row {
        key: "master-exchange-124",
        what: "master, one Data_Exchange of 2 octets each way among 124 slaves",
        ours: master::exchange::<124>,
        minus: None,
        peer: Some(master::exchange_peer::<124>),
        units: 1,
        target: Some(900),
    },
    Row {
        key: "master-exchange-32",
        what: "the same among 32",
        ours: master::exchange::<32>,
        minus: None,
        peer: Some(master::exchange_peer::<32>),
        units: 1,
        target: None,
    },
    Row {
        key: "master-exchange-8",
        what: "the same among 8",
        ours: master::exchange::<8>,
        minus: None,
        peer: Some(master::exchange_peer::<8>),
        units: 1,
        target: None,
    },
    Row {
        key: "master-exchange-1",
        what: "the same with one slave, a token for each",
        ours: master::exchange::<1>,
        minus: None,
        peer: Some(master::exchange_peer::<1>),
        units: 1,
        target: None,
    },
    // chosen: the same as for the slave's side.
    Row {
        key: "master-ms2-read",
        what: "master, one MS2 read of four octets, request and poll",
        ours: acyclic::read,
        minus: None,
        peer: None,
        units: 1,
        target: Some(1500),
    },
    Row {
        key: "sensor-reading",
        what: "one reading of a real sensor, the mean of four principles",
        ours: sensor::four_sensors,
        minus: None,
        peer: None,
        units: 4,
        target: Some(1000),
    },
];

#[cfg(test)]
mod tests {
    use super::ROWS;
    use std::collections::BTreeSet;

    #[test]
    fn every_row_has_its_own_key() {
        let keys: BTreeSet<_> = ROWS.iter().map(|row| row.key).collect();
        assert_eq!(keys.len(), ROWS.len());
    }
}
