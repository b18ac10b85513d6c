//! Random sequences of all faults of a ring, by seed. Afterwards the ring is complete again in time.

use super::line::{Bounds, Line};
use profivac_sim::stations::Tester;
use profivac_sim::{Fault, Noise, Random, StationHandle, TelegramFault};

const ADDRESSES: [u8; 5] = [1, 4, 7, 10, 13];

/// Applies one random fault. `left` has a bit for each master that was requested to leave the ring.
fn apply_random_fault(line: &mut Line, tester: StationHandle<Tester>, left: &mut u16, random: &mut Random) {
    let address = ADDRESSES[random.below(5) as usize];
    let master = line.handle(address);
    match random.below(10) {
        0 => line.switch_off(address),
        1 | 2 => line.switch_on(address),
        3 => line.segment.inject(Fault::Noise(Some(Noise::new(random.below(1000), 1e-3)))),
        4 => line.segment.inject(Fault::Noise(None)),
        5 => line.segment.inject(Fault::Cut(Some(1 + random.below(5)))),
        6 => line.segment.inject(Fault::Cut(None)),
        7 => {
            let da = ADDRESSES[random.below(5) as usize];
            let now = line.segment.now();
            line.segment.station_mut(tester).send(now + random.below(500), &[0xDC, da, address]);
        }
        8 => {
            line.segment.station_mut(master).leave();
            *left |= 1 << address;
        }
        _ => line.segment.inject(Fault::Telegram(master.id(), TelegramFault::Lose(random.below(3) as usize))),
    }
}

#[test]
fn the_ring_is_complete_again_after_random_faults() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let mut line = Line::along(&[(1, 0), (4, 1), (7, 2), (10, 3), (13, 4)]);
        let tester = line.segment.attach(Tester::new());
        line.segment.exempt(tester.id());
        let mut left = 0;
        for _ in 0..60 {
            apply_random_fault(&mut line, tester, &mut left, &mut random);
            line.without_token_rules(1 + random.below(8_000));
        }
        line.segment.inject(Fault::Noise(None));
        line.segment.inject(Fault::Cut(None));
        for address in ADDRESSES {
            if left >> address & 1 == 1 || random.below(2) == 0 {
                line.switch_on(address);
            }
            line.segment.inject(Fault::Power(line.handle(address).id(), true));
        }
        line.without_token_rules(Bounds::of(&ADDRESSES).begin(5));
        line.stays_complete(&ADDRESSES).unwrap_or_else(|violation| panic!("{seed}: {violation}"));
    }
}
