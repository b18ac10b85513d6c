//! Any octets at any time, from a master or from lines, neither panic nor make the slave send more than a telegram.

use super::rig::slave;
use fastrand::Rng;
use profivac_dp::link::{BitTime, Station};
use profivac_virtual::gsd_slave::{GsdStation, Order};
use profivac_wire::{DataTelegram, Telegram};
use std::collections::BTreeSet;

/// Each with its Set_Prm and its Chk_Cfg, and with the longest diagnosis behind the six fixed octets: Max_Diag_Data_Len.
const SPECS: [(&str, &[u8], &[u8], usize); 3] = [
    ("valves.gsd@9:modules=3+7", &[0x88, 9, 9, 11, 0xF0, 1, 0, 0x80, 0, 0, 0, 0, 100], &[0x20, 0x11], 32 - 6),
    ("encoder.gsd@9:modules=2", &[0x80, 0, 0, 11, 0xF0, 2, 0, 0, 10, 0], &[0xF1], 16 - 6),
    ("pressure.gsd@9", &[0x80, 0, 0, 11, 0xF0, 3, 0, 0, 0, 0], &[0x42, 0x84, 8, 5, 0x42, 0x84, 8, 5], 20 - 6),
];

/// Brings the slave to data exchange, if it is free. The requests restart the frame count.
fn start(slave: &mut GsdStation, set_prm: &[u8], chk_cfg: &[u8], now: BitTime) {
    for (dsap, du) in [(61, set_prm), (62, chk_cfg)] {
        let (da, sa) = (slave.station_address(), 2);
        slave.telegram(now, &Telegram::Data(DataTelegram { da, sa, dsap: Some(dsap), ssap: Some(62), fc: 0x6D, du }));
    }
}

/// Octets that are often near those that the slave expects.
fn du(random: &mut Rng, sap: Option<u8>) -> Vec<u8> {
    let mut du: Vec<u8> = match (sap, random.u8(0..4)) {
        (Some(61), 0..=2) => {
            let user = (0..random.usize(0..12)).map(|_| random.u8(..)).collect::<Vec<_>>();
            [
                &[
                    random.choice([0x80, 0x88, 0xB8]).unwrap_or(0x80),
                    random.u8(0..3),
                    1,
                    random.u8(..),
                    0xF0,
                    random.u8(1..4),
                    0,
                ][..],
                &user,
            ]
            .concat()
        }
        (Some(62), 0..=2) => [&[0x20, 0x11, 0xC0, 0, 1, 0x20][..], &[0xF1], &[0x42, 0x84, 8, 5, 0x42, 0x84, 8, 5]]
            [random.usize(0..3)]
        .to_vec(),
        (Some(48..=51), 0..=2) => {
            vec![random.u8(0x50..0x60), random.u8(0..3), random.u8(..), random.u8(..), 8, 0, 0xFD, 0xE8]
        }
        (None, 0..=2) => vec![random.u8(..); random.usize(0..6)],
        _ => (0..random.usize(0..=244)).map(|_| random.u8(..)).collect(),
    };
    if random.u8(0..8) == 0 {
        du.truncate(random.usize(0..=du.len()));
    }
    du
}

fn request(slave: &mut GsdStation, random: &mut Rng, now: BitTime) -> BitTime {
    let saps = [
        None,
        Some(48),
        Some(49),
        Some(50),
        Some(51),
        Some(55),
        Some(56),
        Some(57),
        Some(58),
        Some(59),
        Some(60),
        Some(61),
        Some(62),
        Some(random.u8(0..64)),
    ];
    let dsap = saps[random.usize(..saps.len())];
    let du = du(random, dsap);
    let (any_sap, any_fc) = (random.u8(0..64), random.u8(..));
    let ssap = dsap.and_then(|_| random.choice([50, 51, 62, any_sap]));
    let fc = random.choice([0x5D, 0x7D, 0x6D, 0x46, 0x49, 0x4D, any_fc]).unwrap_or(0x5D);
    let da = random.choice([slave.station_address(), slave.station_address(), 127]).unwrap_or(9);
    let telegram = Telegram::Data(DataTelegram { da, sa: random.u8(1..4), dsap, ssap, fc, du: &du });
    let answer = slave.telegram(now, &telegram).map(|answer| (answer.not_before, answer.octets.to_vec()));
    if let Some((not_before, octets)) = answer {
        assert!(octets.len() <= 255 && Telegram::parse(&octets).is_ok(), "{octets:02X?}");
        slave.sent(not_before);
    }
    slave.poll(now);
    now + u64::from(random.u32(0..20_000))
}

const WORDS: [&str; 34] = [
    "input",
    "diagnosis",
    "channel-error",
    "record",
    "on",
    "off",
    "bit",
    "area",
    "at",
    "none",
    "0",
    "1",
    "2",
    "3",
    "4",
    "9",
    "63",
    "254",
    "255",
    "495",
    "24-24",
    "0-63",
    "32-39",
    "0-495",
    "1F",
    "FF",
    "16#1F",
    "float:1e39",
    "u32:4294967295",
    "i8:-129",
    "Short",
    "circuit",
    "-1",
    "ä",
];

const SMALL: [&str; 6] = ["0", "1", "2", "3", "4", "9"];

/// Lines that may be orders: `#` is a small number, `*` any word.
const LINES: [&str; 9] = [
    "input # *",
    "input # bit # on",
    "diagnosis bit # on",
    "diagnosis area * #",
    "channel-error # # # on",
    "channel-error # # # on",
    "channel-error # * * off",
    "record # # * *",
    "* * * *",
];

/// Few lines end every diagnosis: more would keep it short.
fn line(slave: &mut GsdStation, random: &mut Rng) {
    let line = if random.u8(0..40) == 0 { "diagnosis none" } else { LINES[random.usize(..LINES.len())] };
    let word = |word| match word {
        "#" => SMALL[random.usize(..SMALL.len())],
        "*" => WORDS[random.usize(..WORDS.len())],
        word => word,
    };
    let words: Vec<&str> = line.split(' ').map(word).collect();
    if let Some(Ok(order)) = Order::parse(words[0], &words[1..]) {
        let _ = slave.execute(&order);
    }
}

#[test]
fn random_requests_and_lines_neither_panic_nor_break_the_limits_of_the_file() {
    let (mut exchanged, mut full) = (0, BTreeSet::new());
    for seed in 0..60 {
        let mut random = Rng::with_seed(seed);
        let (spec, set_prm, chk_cfg, most) = SPECS[random.usize(..SPECS.len())];
        let mut slave = slave(spec);
        let mut now = BitTime(0);
        for _ in 0..600 {
            match random.u8(0..8) {
                0 => line(&mut slave, &mut random),
                1 if random.u8(0..30) == 0 => slave.set_power(random.bool()),
                1 if random.u8(0..4) == 0 => start(&mut slave, set_prm, chk_cfg, now),
                1 => drop(slave.take_refusal()),
                _ => now = request(&mut slave, &mut random, now),
            }
            exchanged += u32::from(slave.is_exchanging());
            let state = slave.state();
            let octets = state.diagnosis.split_whitespace().count();
            assert!(octets <= most, "{spec}: {}", state.diagnosis);
            // No block has one octet or two.
            if octets + 3 > most {
                full.insert(spec);
            }
            assert!(state.records.iter().all(|record| record.octets.split_whitespace().count() <= 240));
        }
    }
    assert_eq!(full.len(), SPECS.len(), "no diagnosis of the others is as long as the file allows: {full:?}");
    assert!(
        exchanged > 1000,
        "the slaves exchanged data {exchanged} times: the requests are too random to test anything"
    );
}
