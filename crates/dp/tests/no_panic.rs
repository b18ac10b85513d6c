//! A master survives any octets on the line and works afterwards.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters, services};
use profivac_dp::slave::Slave;
use profivac_wire::Telegram;
use profivac_wire::global::ControlCommand;
use support::plain::Plain;
use support::{Random, bus};

const IDENT: u16 = 0x1234;
const CFG: [u8; 2] = [0x11, 0x21];

type Any = Active<Master<4, 8, 4>>;

fn station() -> Any {
    let mut station = Master::on(
        BusParameters { gap_factor: 3, ..bus() }.check().unwrap(),
        Settings::new(Baud::B1500000),
        BitTime(0),
    );
    for address in [3, 8, 9] {
        station.user.add(&SlaveParameters::new(address, IDENT, &CFG)).expect("room for it");
    }
    station.user.set_mode(Mode::Operate);
    station
}

/// A user sends requests while the line carries random octets.
fn meddle(station: &mut Any, random: &mut Random) {
    let address = random.next() as u8;
    match random.below(40) {
        0 => station.user.set_mode(Mode::Clear),
        1..4 => station.user.set_mode(Mode::Operate),
        4 => station.user.set_mode(Mode::Stop),
        5 => station.user.release(address & 15),
        6..9 => station.user.restart(address & 15),
        9 => drop(station.user.submit_request(&services::slave_diag(address))),
        10 => drop(station.user.submit_request(&services::set_slave_add(address, &[address; 9]))),
        11..14 => drop(station.user.take_confirmation()),
        14 => drop(station.user.next_event()),
        15 => station.listen(BitTime(random.next() % 1_000_000)),
        16 => {
            let _ = station.user.control(ControlCommand::from_bits_retain(address), address);
        }
        17 => station.user.set_cleared_groups(address),
        18 => {
            let _ = station.user.set_group(address & 15, address);
        }
        19 => {
            let _ = station.user.reparameterise(&SlaveParameters::new(address & 15, IDENT, &CFG));
        }
        20 if address & 15 != 8 => {
            let _ = station.user.remove(address & 15);
        }
        21 => {
            let _ = station.user.add(&SlaveParameters::new(address & 15, IDENT, &CFG));
        }
        _ => {}
    }
}

/// After the random octets the line is silent, then a slave answers. The slave must enter data exchange.
fn works_afterwards(mut station: Any, mut now: BitTime) {
    let mut slave = Slave::new(Plain::new(IDENT, &CFG), 8, Baud::B1500000);
    let mut slave_receiver = Receiver::new(now);
    let mut receiver = Receiver::new(now);
    station.user.set_mode(Mode::Operate);
    station.user.restart(8);
    for _ in 0..20_000 {
        if station.user.inputs(8).is_some() {
            return;
        }
        // A telegram in progress has ended.
        station.sent(now);
        now = now.max(station.wake_at().unwrap_or(now));
        let Some(octets) = station.poll(now).map(|transmit| transmit.octets.to_vec()) else { continue };
        now = now + 50;
        let mut answer = None;
        for octet in octets {
            now = now + CHARACTER_TBIT;
            if let Received::Telegram(telegram) = slave_receiver.octet(now, octet) {
                answer = slave.telegram(now, &telegram).map(|answer| answer.octets.to_vec());
            }
        }
        station.sent(now);
        for octet in answer.into_iter().flatten() {
            now = now + CHARACTER_TBIT;
            receive(&mut station, &mut receiver, now, octet);
        }
    }
    panic!("slave 8 is in {:?}, {:?}", station.user.state(8), station.user.exchange_error(8));
}

fn receive(station: &mut Any, receiver: &mut Receiver, now: BitTime, octet: u8) {
    match receiver.octet(now, octet) {
        Received::Telegram(telegram) => drop(station.telegram(now, &telegram)),
        Received::Nothing | Received::Damaged(_) => station.activity(now),
    }
}

#[test]
fn random_octets_at_random_times_leave_the_station_working() {
    let mut random = Random::new(0x000C_7E75);
    for _ in 0..20 {
        let mut station = station();
        let mut receiver = Receiver::new(BitTime(0));
        let mut now = BitTime(0);
        for _ in 0..100_000 {
            // Mostly without gaps, and mostly octets that occur in telegrams.
            now = now + [11, 11, 11, 12, 45, 300, 5000][random.below(7)];
            let octet = match random.below(4) {
                0 => random.next() as u8,
                1 => [0x10, 0x68, 0xDC, 0xE5, 0x16][random.below(5)],
                2 => [2, 8, 5, 0x88, 0x82][random.below(5)],
                _ => [0x08, 0x0A, 0x3C, 0x3E, 0x6D][random.below(5)],
            };
            receive(&mut station, &mut receiver, now, octet);
            if random.below(3) == 0 && station.poll(now).is_some() && random.below(4) > 0 {
                now = now + 100;
                station.sent(now);
            }
            meddle(&mut station, &mut random);
        }
        works_afterwards(station, now);
    }
}

#[test]
fn every_kind_of_wrong_answer_leaves_the_station_working() {
    let mut random = Random::new(0x000A_57E4);
    for _ in 0..20 {
        let mut station = station();
        let mut slaves = [3, 8, 9].map(|address| Slave::new(Plain::new(IDENT, &CFG), address, Baud::B1500000));
        let mut receiver = Receiver::new(BitTime(0));
        let mut now = BitTime(0);
        let mut octets_heard = 0;
        while octets_heard < 100_000 {
            now = now.max(station.wake_at().unwrap_or(now));
            let request = station.poll(now).map(|transmit| transmit.octets.to_vec()).unwrap_or_default();
            now = now + 11 * request.len() as u64;
            station.sent(now);
            let mut answer = Vec::new();
            if let Ok(telegram) = Telegram::parse(&request) {
                for slave in &mut slaves {
                    answer.extend(
                        slave.telegram(now, &telegram).map(|answer| answer.octets.to_vec()).unwrap_or_default(),
                    );
                }
            }
            spoil(&mut answer, &mut random);
            octets_heard += answer.len() + 1;
            now = now + [11, 11, 11, 200, 301, 400][random.below(6)];
            for octet in answer {
                now = now + CHARACTER_TBIT;
                receive(&mut station, &mut receiver, now, octet);
            }
            meddle(&mut station, &mut random);
            if random.below(50) == 0 {
                slaves[random.below(3)].power_up(8);
            }
        }
        works_afterwards(station, now);
    }
}

/// Alters an answer so that it usually remains a telegram with a right FCS.
fn spoil(answer: &mut Vec<u8>, random: &mut Random) {
    if answer.is_empty() || random.below(3) > 0 {
        return;
    }
    let index = random.below(answer.len());
    match random.below(8) {
        0 => answer.clear(),
        1 => answer.truncate(index),
        2 => answer[index] = random.next() as u8,
        3 => answer[index] ^= 1 << random.below(8),
        4 => answer.extend_from_within(..),
        5 => *answer = [&[0xE5][..], &[0xDC, 2, 5], &[0x10, 2, 8, 3, 13, 0x16]][random.below(3)].to_vec(),
        6 => answer.insert(index, random.next() as u8),
        _ => {
            // Another data unit, or another length.
            let du = vec![random.next() as u8; random.below(250)];
            if let Ok(Telegram::Data(mut data)) = Telegram::parse(&answer.clone()) {
                data.du = &du;
                let mut out = [0; 255];
                let length = Telegram::Data(data).emit(&mut out).unwrap_or(0);
                *answer = out[..length].to_vec();
            }
        }
    }
}
