//! The receiver compared with the simplest implementation of the rules: octet by octet, in slices of any size, with damaged
//! octets, gaps and character errors. Results and times must be the same.

use crate::rig;

use fastrand::Rng;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_wire::{DataTelegram, MAX_DU, Telegram};
use rig::{Gauge, Rig, hex};

/// One of every form, and the longest: profibus-wire 1.6, 1.13, 1.15, 2.3 and 2.8.
fn telegrams() -> Vec<Vec<u8>> {
    let mut telegrams: Vec<Vec<u8>> = [
        "E5",
        "DC 02 02",
        "10 08 02 49 53 16",
        "68 05 05 68 88 82 6D 3C 3E F1 16",
        "68 05 05 68 08 02 7D AA 55 86 16",
        "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16",
        "A2 88 82 7D 3E 3E 44 86 05 05 05 08 E4 16",
    ]
    .map(hex)
    .to_vec();
    let longest = DataTelegram { da: 8, sa: 2, dsap: Some(56), ssap: Some(62), fc: 0x7D, du: &[0xE5; MAX_DU] };
    telegrams.push(rig::emit(&Telegram::Data(longest)));
    telegrams
}

/// A result, and the end of the character that completed it.
type Sent = (BitTime, String);

fn sent(end: BitTime, received: Received<'_>) -> Option<Sent> {
    match received {
        Received::Nothing => None,
        Received::Telegram(telegram) => Some((end, format!("{telegram:02X?}"))),
        Received::Damaged(defect) => Some((end, format!("{defect:?}"))),
    }
}

/// The rules of profibus-wire 1.7, each checked for every octet.
struct Rules {
    octets: Vec<u8>,
    hunting: bool,
    last: BitTime,
    damaged: u32,
}

impl Rules {
    /// T_SYN and the character after it.
    const GAP_TBIT: u64 = 33 + 11;

    fn new() -> Self {
        Self { octets: Vec::new(), hunting: true, last: BitTime(0), damaged: 0 }
    }

    fn lose(&mut self) {
        self.octets.clear();
        self.hunting = true;
        self.damaged += 1;
    }

    fn octet(&mut self, end: BitTime, octet: u8) -> Option<Sent> {
        let since_last = end - self.last;
        self.last = end;
        if !self.octets.is_empty() && since_last > Self::GAP_TBIT {
            self.lose();
        }
        if self.octets.is_empty() && self.hunting && since_last < Self::GAP_TBIT {
            return None;
        }
        self.hunting = false;
        self.octets.push(octet);
        if !is_decided(&self.octets) {
            return None;
        }
        match Telegram::parse(&self.octets) {
            Ok(telegram) => {
                let sent = sent(end, Received::Telegram(telegram));
                self.octets.clear();
                sent
            }
            Err(defect) => {
                self.lose();
                sent(end, Received::Damaged(defect))
            }
        }
    }

    fn character_error(&mut self, end: BitTime) {
        self.last = end;
        self.lose();
    }
}

/// Whether the octets are a complete telegram or can no longer become one.
fn is_decided(octets: &[u8]) -> bool {
    match *octets {
        [0xE5, ..] => true,
        [0xDC, ..] => octets.len() == 3,
        [0x10, ..] => octets.len() == 6,
        [0xA2, ..] => octets.len() == 14,
        [0x68] | [0x68, _] | [0x68, _, _] => false,
        [0x68, le @ 3..=249, ler, 0x68, ..] if le == ler => octets.len() == usize::from(le) + 6,
        _ => true,
    }
}

/// All octets of a piece at once, as often as there is something left.
fn together(receiver: &mut Receiver, mut end: BitTime, mut octets: &[u8]) -> Vec<Sent> {
    let mut all = Vec::new();
    while !octets.is_empty() {
        let (taken, received) = receiver.octets(end, octets);
        all.extend(sent(end + (taken as u64 - 1) * CHARACTER_TBIT, received));
        end = end + taken as u64 * CHARACTER_TBIT;
        octets = &octets[taken..];
    }
    all
}

/// The same line received in three ways.
struct Line {
    rules: Rules,
    each: Receiver,
    slices: Receiver,
    /// When the last character ended.
    now: BitTime,
}

impl Line {
    fn new() -> Self {
        let receiver = Receiver::new(BitTime(0));
        Self { rules: Rules::new(), each: receiver.clone(), slices: receiver, now: BitTime(0) }
    }

    /// Pieces without a gap between them. Returns the results of the rules.
    fn pieces(&mut self, pieces: &[&[u8]]) -> Vec<Sent> {
        let (mut rules, mut each, mut slices) = (Vec::new(), Vec::new(), Vec::new());
        for piece in pieces {
            slices.extend(together(&mut self.slices, self.now + CHARACTER_TBIT, piece));
            for octet in *piece {
                self.now = self.now + CHARACTER_TBIT;
                rules.extend(self.rules.octet(self.now, *octet));
                each.extend(sent(self.now, self.each.octet(self.now, *octet)));
            }
        }
        assert_eq!(each, rules, "octet by octet: {pieces:02X?}");
        assert_eq!(slices, rules, "in slices: {pieces:02X?}");
        for receiver in [&self.each, &self.slices] {
            assert_eq!(receiver.damaged(), self.rules.damaged, "{pieces:02X?}");
            assert_eq!(receiver.is_receiving(), !self.rules.octets.is_empty(), "{pieces:02X?}");
        }
        rules
    }

    fn character_error(&mut self) {
        self.now = self.now + CHARACTER_TBIT;
        self.rules.character_error(self.now);
        self.each.character_error(self.now);
        self.slices.character_error(self.now);
    }
}

/// Two cuts anywhere in `octets`.
fn cuts(octets: &[u8]) -> impl Iterator<Item = [&[u8]; 3]> {
    (0..=octets.len()).flat_map(move |second| {
        (0..=second).map(move |first| [&octets[..first], &octets[first..second], &octets[second..]])
    })
}

#[test]
fn every_telegram_is_received_in_pieces_of_any_size() {
    for octets in telegrams() {
        let mut line = Line::new();
        for pieces in cuts(&octets) {
            line.now = line.now + 33;
            let received = line.pieces(&pieces);
            let Ok(telegram) = Telegram::parse(&octets) else { panic!("no telegram: {octets:02X?}") };
            assert_eq!(received, [(line.now, format!("{telegram:02X?}"))], "{pieces:02X?}");
        }
    }
}

#[test]
fn all_receivers_report_a_damaged_octet_alike_and_receive_the_next_telegram_after_t_syn() {
    let next = hex("10 08 02 49 53 16");
    for octets in telegrams().into_iter().filter(|octets| octets.len() < 20) {
        for index in 0..octets.len() {
            for bit in 0..8 {
                let mut damaged = octets.clone();
                damaged[index] ^= 1 << bit;
                for idle in [0, 32, 33] {
                    let mut line = Line::new();
                    line.now = BitTime(33);
                    let (front, back) = damaged.split_at(index);
                    line.pieces(&[front, back]);
                    line.now = line.now + idle;
                    let received = line.pieces(&[&next]);
                    assert!(idle < 33 || received.len() == 1, "{damaged:02X?}");
                }
            }
        }
    }
}

/// Some telegrams one after the other, with an octet altered here and there, cut off anywhere.
fn chunk(rng: &mut Rng, telegrams: &[Vec<u8>]) -> Vec<u8> {
    let mut octets = Vec::new();
    for _ in 0..rng.usize(1..4) {
        octets.extend_from_slice(&telegrams[rng.usize(..telegrams.len())]);
    }
    if rng.u8(..3) == 0 {
        let index = rng.usize(..octets.len());
        octets[index] ^= 1 << rng.u8(..8);
    }
    if rng.u8(..3) == 0 {
        octets.truncate(rng.usize(1..=octets.len()));
    }
    octets
}

#[test]
fn all_receivers_report_random_pieces_gaps_and_errors_alike() {
    let telegrams = telegrams();
    let times = std::env::var("PROFIVAC_FUZZ").ok().and_then(|times| times.parse().ok()).unwrap_or(1);
    for seed in 0..2_000 * times {
        let mut rng = Rng::with_seed(seed);
        let mut line = Line::new();
        for _ in 0..20 {
            let octets = chunk(&mut rng, &telegrams);
            let mut pieces = Vec::new();
            let mut rest = octets.as_slice();
            while !rest.is_empty() {
                let (piece, behind) = rest.split_at(rng.usize(1..=rest.len().min(40)));
                (pieces, rest) = ([pieces, vec![piece]].concat(), behind);
            }
            line.pieces(&pieces);
            match rng.u8(..20) {
                0 => line.character_error(),
                // A clock that was set back.
                1 => line.now = BitTime(line.now.0 - rng.u64(..line.now.0.min(100))),
                _ => line.now = line.now + [0, 1, 32, 33, 34, 100][rng.usize(..6)],
            }
        }
    }
}

#[test]
fn a_damaged_telegram_changes_nothing_in_a_slave() {
    let requests = [
        // Data_Exchange, other outputs than before; then Set_Prm that would unlock, and Chk_Cfg of another configuration.
        "68 05 05 68 08 02 7D AA 55 86 16",
        "68 0C 0C 68 88 82 7D 3D 3E 40 00 00 00 12 34 00 88 16",
        "68 06 06 68 88 82 7D 3E 3E 21 24 16",
    ];
    for octets in requests.map(hex) {
        let mut rig = Rig::exchanging(Gauge::default());
        let reported = |rig: &Rig| format!("{:?} {:?}", rig.slave.state(), rig.slave.device());
        let before = reported(&rig);
        for index in 0..octets.len() {
            for flipped in 1..=0xFF {
                let mut damaged = octets.clone();
                damaged[index] ^= flipped;
                let mut receiver = Receiver::new(BitTime(0));
                let mut end = BitTime(33);
                for octet in &damaged {
                    end = end + CHARACTER_TBIT;
                    if let Received::Telegram(telegram) = receiver.octet(end, *octet) {
                        assert_eq!(rig.slave.telegram(end, &telegram), None, "{damaged:02X?}");
                    }
                }
                assert_eq!(reported(&rig), before, "{damaged:02X?}");
            }
        }
        assert!(rig.raw(&octets).is_some(), "undamaged, it is answered");
        assert_ne!(reported(&rig), before, "undamaged, it changes something");
    }
}
