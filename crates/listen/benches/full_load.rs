//! The share of one core that a line with full load at 12 Mbit/s needs: octets to pieces, pieces to the state of the line. Run with
//! `cargo bench -p profivac-listen --bench full_load`. With an argument, a number of seconds of bus time, it listens that long.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a benchmark")]

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_explain::divider::Divider;
use profivac_explain::frame::{Chunk, TimeSource};
use profivac_listen::Observer;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::time::Instant;

const BAUD: Baud = Baud::B12000000;

fn emit(telegram: &Telegram<'_>) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let length = telegram.emit(&mut octets).unwrap_or_default();
    octets.truncate(length);
    octets
}

/// One cycle of a master with 124 slaves that exchange two octets in each direction, and its token.
fn cycle(fcb: bool) -> Vec<Vec<u8>> {
    let data = |da, sa, fc, du: &[u8]| emit(&Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc, du }));
    let mut all = Vec::new();
    for slave in 1..125 {
        all.push(data(slave, 0, if fcb { 0x7D } else { 0x5D }, &[1, 2]));
        all.push(data(0, slave, 0x08, &[3, slave]));
    }
    all.push(emit(&Telegram::Token { da: 0, sa: 0 }));
    all
}

fn main() {
    let seconds = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(10.0);
    for (name, octets_at_once) in [("telegram by telegram", None), ("in pieces of 512 octets", Some(512))] {
        let times = if octets_at_once.is_some() { TimeSource::Platform } else { TimeSource::Exact };
        let (mut divider, mut observer) = (Divider::new(BAUD, times), Observer::new(BAUD, times));
        let cycles = [cycle(false), cycle(true)];
        let (mut now, mut pieces, mut waiting) = (BitTime(0), Vec::new(), Vec::new());
        let end = BitTime((f64::from(BAUD.bits_per_second()) * seconds) as u64);
        let began = Instant::now();
        let mut number = 0;
        while now < end {
            for (index, octets) in cycles[number % 2].iter().enumerate() {
                let start = now;
                // Behind a request the shortest T_SDR, behind an answer T_ID1: no line has more telegrams.
                now = now + octets.len() as u64 * CHARACTER_TBIT + if index % 2 == 0 { 11 } else { 37 };
                match octets_at_once {
                    None => {
                        let chunk = Chunk { start: Some(start), octets: octets.clone(), ..Chunk::default() };
                        divider.push(&chunk, &mut pieces);
                    }
                    Some(length) => {
                        waiting.extend_from_slice(octets);
                        if waiting.len() >= length {
                            let chunk =
                                Chunk { start: Some(now), octets: std::mem::take(&mut waiting), ..Chunk::default() };
                            divider.push(&chunk, &mut pieces);
                        }
                    }
                }
                pieces.drain(..).for_each(|piece| observer.piece(&piece));
            }
            number += 1;
        }
        let took = began.elapsed().as_secs_f64();
        let telegrams = observer.totals().telegrams;
        println!(
            "{name}: {seconds} s of bus time, {telegrams} telegrams in {took:.3} s: {:.1} % of a core, {:.0} ns each",
            took / seconds * 100.0,
            took * 1e9 / telegrams as f64
        );
    }
}
