//! Slaves with a fault that only random damage shows.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave(
        "noise.silence",
        "acknowledges long telegrams with a fault",
        Reacts(|| Box::new(|line, octets| if damaged::is_long(octets) { sc() } else { line.send(octets) })),
    ),
    slave(
        "noise.state",
        "leaves data exchange with a long damaged telegram",
        Reacts(|| {
            Box::new(|line, octets| {
                if damaged::is_long(octets) {
                    leave(line);
                }
                line.send(octets)
            })
        }),
    ),
];
