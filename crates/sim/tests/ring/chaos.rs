//! Everything that can happen to a ring, one thing after the other, by seed. When it is over the ring is whole again in time.

use crate::line::{Bounds, Line};
use profivac_sim::stations::Tester;
use profivac_sim::{Fault, Noise, Random, StationHandle, TelegramFault};

const ADDRESSES: [u8; 5] = [1, 4, 7, 10, 13];

/// One thing happens. `left` has a bit for each master that was told to leave, and does so when it can.
fn happen(line: &mut Line, ghost: StationHandle<Tester>, left: &mut u16, random: &mut Random) {
    let address = ADDRESSES[random.below(5) as usize];
    let master = line.handle(address);
    match random.below(10) {
        0 => line.switch_off(address),
        1 | 2 => line.switch_on(address),
        3 => line.bus.inject(Fault::Noise(Some(Noise::new(random.below(1000), 1e-3)))),
        4 => line.bus.inject(Fault::Noise(None)),
        5 => line.bus.inject(Fault::Cut(Some(1 + random.below(5)))),
        6 => line.bus.inject(Fault::Cut(None)),
        7 => {
            let da = ADDRESSES[random.below(5) as usize];
            let now = line.bus.now();
            line.bus.station_mut(ghost).send(now + random.below(500), &[0xDC, da, address]);
        }
        8 => {
            line.bus.station_mut(master).leave();
            *left |= 1 << address;
        }
        _ => line.bus.inject(Fault::Telegram(master.id(), TelegramFault::Lose(random.below(3) as usize))),
    }
}

#[test]
fn after_anything_that_happened_the_ring_is_whole_again() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let mut line = Line::along(&[(1, 0), (4, 1), (7, 2), (10, 3), (13, 4)]);
        let ghost = line.bus.attach(Tester::new());
        line.bus.exempt(ghost.id());
        let mut left = 0;
        for _ in 0..60 {
            happen(&mut line, ghost, &mut left, &mut random);
            line.in_confusion(1 + random.below(8_000));
        }
        line.bus.inject(Fault::Noise(None));
        line.bus.inject(Fault::Cut(None));
        for address in ADDRESSES {
            if left >> address & 1 == 1 || random.below(2) == 0 {
                line.switch_on(address);
            }
            line.bus.inject(Fault::Power(line.handle(address).id(), true));
        }
        line.in_confusion(Bounds::of(&ADDRESSES).begin(5));
        line.stays_whole(&ADDRESSES).unwrap_or_else(|foul| panic!("{seed}: {foul}"));
    }
}
