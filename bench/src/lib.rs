//! What `cargo bench` counts: one function per operation, which does it so many times.
//!
//! Everything that must be ready beforehand is made before the loop, so that the difference between two runs of different
//! length is the operation alone. [`ROWS`] is the table of `docs/benchmarks.md`.

mod acyclic;
pub mod cycle;
mod desk;
mod master;
mod receiver;
mod sensor;
mod slave;
mod telegram;

/// Does an operation so many times.
pub type Operation = fn(u32);

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// What is done, and per what the instructions are counted.
    pub what: &'static str,
    /// Our way.
    pub ours: Operation,
    /// What of it belongs to something else and is taken off.
    pub minus: Option<Operation>,
    /// The same by profirust 0.6.0.
    pub peer: Option<Operation>,
    /// How many of the units named in `what` one operation has.
    pub units: u32,
    /// The instructions per unit we want to stay within, where we want something.
    pub target: Option<u32>,
}

/// The whole table.
pub const ROWS: &[Row] = &[
    Row {
        what: "decode an SD2 of 41 octets from a buffer",
        ours: telegram::decode,
        minus: None,
        peer: Some(telegram::decode_peer),
        units: 1,
        target: Some(150),
    },
    Row {
        what: "encode an SD2 of 41 octets into a buffer",
        ours: telegram::encode,
        minus: None,
        peer: Some(telegram::encode_peer),
        units: 1,
        target: Some(150),
    },
    Row {
        what: "receive one octet of an SD2 of 41 that come in one piece, decoding included",
        ours: receiver::receive_piece,
        minus: None,
        peer: None,
        units: 41,
        target: Some(12),
    },
    Row {
        what: "the same, in pieces of eight",
        ours: receiver::receive_pieces,
        minus: None,
        peer: None,
        units: 41,
        target: Some(12),
    },
    Row {
        what: "the same, one by one",
        ours: receiver::receive_each,
        minus: None,
        peer: None,
        units: 41,
        target: Some(12),
    },
    Row {
        what: "slave, one Data_Exchange of 5 octets out and 2 in, the request in one piece",
        ours: slave::in_one_piece,
        minus: None,
        peer: None,
        units: 1,
        target: Some(800),
    },
    Row {
        what: "the same, octet by octet",
        ours: slave::octet_by_octet,
        minus: None,
        peer: None,
        units: 1,
        target: Some(800),
    },
    Row {
        what: "of that, from the last octet of the request to the answer",
        ours: slave::octet_by_octet,
        minus: Some(slave::all_but_last),
        peer: None,
        units: 1,
        target: Some(250),
    },
    Row {
        what: "BCG450, one Data_Exchange with parameter channel and float (C6 87 8E ...)",
        ours: slave::bcg450_exchange,
        minus: None,
        peer: None,
        units: 1,
        target: Some(1500),
    },
    Row {
        what: "BCG450, one MS1 read of four octets, request and poll",
        ours: slave::ms1_read,
        minus: None,
        peer: None,
        units: 1,
        target: Some(2000),
    },
    Row {
        what: "BCG450, one read through the parameter channel, instruction and AK 0",
        ours: slave::parameter_channel_read,
        minus: None,
        peer: None,
        units: 1,
        target: Some(2 * 1500),
    },
    Row {
        what: "master, one Data_Exchange of 2 octets each way among 124 slaves",
        ours: master::exchange::<124>,
        minus: None,
        peer: Some(master::exchange_peer::<124>),
        units: 1,
        target: Some(1000),
    },
    Row {
        what: "the same among 32",
        ours: master::exchange::<32>,
        minus: None,
        peer: Some(master::exchange_peer::<32>),
        units: 1,
        target: None,
    },
    Row {
        what: "the same among 8",
        ours: master::exchange::<8>,
        minus: None,
        peer: Some(master::exchange_peer::<8>),
        units: 1,
        target: None,
    },
    Row {
        what: "the same with one slave, a token for each",
        ours: master::exchange::<1>,
        minus: None,
        peer: Some(master::exchange_peer::<1>),
        units: 1,
        target: None,
    },
    // free choice of the target: what a slave may take for its side.
    Row {
        what: "master, one MS2 read of four octets, request and poll",
        ours: acyclic::read,
        minus: None,
        peer: None,
        units: 1,
        target: Some(2 * 1000),
    },
    Row {
        what: "one reading of a real sensor, the mean of four principles",
        ours: sensor::four_sensors,
        minus: None,
        peer: None,
        units: 4,
        target: Some(1000),
    },
];
