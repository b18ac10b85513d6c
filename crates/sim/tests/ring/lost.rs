//! Lost tokens: power failures of masters at every bit time, damaged tokens.

use super::line::{BAUD, Bounds, Line, parameters};
use crate::common::{CFG, IDENT, Plain};
use profivac_dp::link::BitTime;
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::{Slave, SlaveState};
use profivac_sim::{Fault, Noise, Segment, TelegramFault};

type Class1 = Master<2, 8>;

const ADDRESSES: [u8; 3] = [2, 5, 9];

/// Longer than one rotation without and one with polls of the GAP.
const SWEEP_TBIT: u64 = 2_500;

/// At each bit time of a rotation the holder of the token loses power, or each master in turn where none holds it: the others
/// form a ring again in time.
#[test]
fn the_others_form_a_ring_again_after_a_power_failure_at_every_bit_time() {
    let mut holders = [0; 3];
    for after in 0..SWEEP_TBIT {
        let mut line = Line::just_complete(&ADDRESSES);
        line.segment.run_for(after).unwrap();
        let victim = line.holder().unwrap_or(ADDRESSES[(after % 3) as usize]);
        holders[ADDRESSES.iter().position(|address| *address == victim).unwrap()] += 1;
        let rest: Vec<u8> = ADDRESSES.into_iter().filter(|address| *address != victim).collect();
        line.switch_off(victim);
        line.becomes_complete(&rest, Bounds::of(&rest).token_lost(1))
            .unwrap_or_else(|violation| panic!("{after}: {violation}"));
    }
    assert!(holders.iter().all(|times| *times > SWEEP_TBIT / 6), "{holders:?}");
}

#[test]
fn one_master_is_a_ring_after_the_others_lost_power_at_every_third_bit_time() {
    for after in (0..SWEEP_TBIT).step_by(3) {
        for survivor in ADDRESSES {
            let mut line = Line::just_complete(&ADDRESSES);
            line.segment.run_for(after).unwrap();
            for victim in ADDRESSES.into_iter().filter(|address| *address != survivor) {
                line.switch_off(victim);
            }
            let bound = Bounds::of(&[survivor]).token_lost(2);
            line.becomes_complete(&[survivor], bound)
                .unwrap_or_else(|violation| panic!("{after}, {survivor}: {violation}"));
        }
    }
}

#[test]
fn the_ring_is_complete_again_after_power_returns_at_once_or_later() {
    for after in (0..SWEEP_TBIT).step_by(41) {
        for (victim, off) in [(2, 50), (5, 700), (9, 5_000)] {
            let mut line = Line::just_complete(&ADDRESSES);
            line.segment.run_for(after).unwrap();
            line.switch_off(victim);
            line.segment.run_for(off).unwrap();
            line.switch_on(victim);
            let bounds = Bounds::of(&ADDRESSES);
            let bound = bounds.token_lost(1) + bounds.join();
            line.becomes_complete(&ADDRESSES, bound)
                .unwrap_or_else(|violation| panic!("{after}, {victim}: {violation}"));
        }
    }
}

/// Five masters, two of which lose power at the same time, at times of a rotation without a common divisor.
#[test]
fn three_of_five_form_a_ring_again_after_two_lost_power_at_once() {
    const ALL: [u8; 5] = [1, 4, 7, 10, 13];
    for after in (0..5_000).step_by(17) {
        for victims in [[1, 4], [4, 10], [13, 1]] {
            let mut line = Line::just_complete(&ALL);
            line.segment.run_for(after).unwrap();
            victims.into_iter().for_each(|victim| line.switch_off(victim));
            let rest: Vec<u8> = ALL.into_iter().filter(|address| !victims.contains(address)).collect();
            let bound = Bounds::of(&rest).token_lost(2);
            line.becomes_complete(&rest, bound).unwrap_or_else(|violation| panic!("{after}, {victims:?}: {violation}"));
        }
    }
}

/// Two class 1 masters with slaves whose watchdogs have 50 ms, 75 000 bit times. One master loses power; its slaves leave
/// data exchange, those of the other master do not.
#[test]
fn the_slaves_of_others_stay_in_data_exchange() {
    for after in (0..2_000).step_by(97) {
        let mut segment = Segment::new(BAUD);
        let class1 = |address: u8, slaves: [u8; 2]| {
            let mut master = Class1::on(parameters(address).check().unwrap(), Settings::new(BAUD), BitTime(0));
            for slave in slaves {
                let watchdog = Some([5, 1]);
                master.user.add(&SlaveParameters { watchdog, ..SlaveParameters::new(slave, IDENT, &CFG) }).unwrap();
            }
            master.user.set_mode(Mode::Operate);
            master
        };
        let masters = [(2, [30, 31]), (5, [32, 33])].map(|(address, slaves)| segment.attach(class1(address, slaves)));
        let slaves = [30, 31, 32, 33].map(|address| segment.attach(Slave::new(Plain::new(), address, BAUD)));
        let states =
            |segment: &Segment| slaves.map(|slave| matches!(segment.station(slave).state(), SlaveState::DataExch(..)));
        segment.run_for(Bounds::of(&[2, 5]).begin(2) + 100_000 + after).unwrap();
        assert_eq!(states(&segment), [true; 4]);
        segment.inject(Fault::Power(masters[0].id(), false));
        for _ in 0..200 {
            segment.run_for(1_000).unwrap();
            assert_eq!(states(&segment)[2..], [true; 2], "{after}");
        }
        assert_eq!(states(&segment)[..2], [false; 2], "{after}");
        assert_eq!([32, 33].map(|slave| segment.station(masters[1]).user.counters(slave).unwrap().lost), [0; 2]);
    }
}

/// Any two bits of one token inverted: the result may be another token, see `tests/detection-token.txt`.
#[test]
fn a_damaged_token_is_repeated_or_the_ring_recovers() {
    for first in 0..33 {
        for second in first..33 {
            let mut line = Line::just_complete(&ADDRESSES);
            // Master 5 sends its token next; it already has it from 2.
            while line.holder() != Some(5) {
                line.segment.run_for(1).unwrap();
            }
            // The request to the slave is undamaged, or the token if there is no request.
            while line.segment.trace().entries.back().is_none_or(|entry| entry.octets.len() != 11) {
                line.segment.run_for(1).unwrap();
            }
            let flips = if first == second { vec![first] } else { vec![first, second] };
            line.segment.inject(Fault::Telegram(line.handle(5).id(), TelegramFault::Flip(flips.clone())));
            let bounds = Bounds::of(&ADDRESSES);
            let bound = bounds.token_lost(1) + bounds.join();
            line.becomes_complete(&ADDRESSES, bound).unwrap_or_else(|violation| panic!("{flips:?}: {violation}"));
        }
    }
}

#[test]
fn the_ring_is_complete_again_after_noise() {
    for seed in 0..40 {
        let mut line = Line::just_complete(&ADDRESSES);
        let rate = [1e-4, 1e-3, 5e-3, 2e-2][seed as usize % 4];
        line.segment.inject(Fault::Noise(Some(Noise::new(seed, rate))));
        line.without_token_rules(200_000);
        line.segment.inject(Fault::Noise(None));
        line.without_token_rules(Bounds::of(&ADDRESSES).begin(3));
        line.stays_complete(&ADDRESSES).unwrap_or_else(|violation| panic!("{seed}: {violation}"));
    }
}

/// Noise at one master: it may leave the ring, and the others continue.
#[test]
fn noise_at_one_master_does_not_stop_the_others() {
    for (seed, deaf) in (0..12).zip(ADDRESSES.into_iter().cycle()) {
        let mut line = Line::just_complete(&ADDRESSES);
        line.segment.inject(Fault::NoiseAt(line.handle(deaf).id(), Some(Noise::new(seed, 3e-3))));
        let before = line.answers(&ADDRESSES);
        line.without_token_rules(300_000);
        let after = line.answers(&ADDRESSES);
        for (index, address) in ADDRESSES.into_iter().enumerate().filter(|(_, address)| *address != deaf) {
            assert!(after[index] > before[index] + 50, "{address} beside {deaf}: {}", after[index] - before[index]);
        }
        line.segment.inject(Fault::NoiseAt(line.handle(deaf).id(), None));
        line.without_token_rules(Bounds::of(&ADDRESSES).begin(3));
        line.stays_complete(&ADDRESSES).unwrap_or_else(|violation| panic!("{seed}: {violation}"));
    }
}

#[test]
fn the_lowest_address_claims_a_lost_token_first() {
    let mut line = Line::new(&[9, 5, 2]);
    // T_TO of 2 is 10 x 300; two tokens to itself inform all stations.
    line.segment.run_until(BitTime(3_200)).unwrap();
    let octets: Vec<_> =
        line.segment.trace().entries.iter().map(|entry| (entry.start.0, entry.octets.to_vec())).collect();
    assert_eq!(octets[..2], [(3000, vec![0xDC, 2, 2]), (3070, vec![0xDC, 2, 2])]);
}
