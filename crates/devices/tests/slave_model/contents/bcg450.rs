//! BCG450-SP, from tira41d1. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::kept::Process;
use super::pressure::{Scale, Unit};
use super::{Common, Content, Key, MOVING, Particular, Reason, Rule, Verdict};
use fastrand::Rng;

/// COUNTS of all instances (59).
pub const SCALE: Scale = Scale::Logarithm { factor: 2000.0, offset: 25_000.0 };
/// 3.2.2.4 (5).
pub const UNITS: &[(u16, Unit)] =
    &[(1001, Unit::Counts), (1301, Unit::Torr), (1302, Unit::Micron), (1308, Unit::Mbar), (1309, Unit::Pascal)];

/// What commands made of the emission, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emission {
    /// The gauge decides, as after power-up.
    Gauge,
    /// A command has been there.
    Commanded,
}

#[derive(Clone, Debug)]
pub struct Bcg450 {
    mbar: f64,
    emission: Emission,
    degas: bool,
    /// A degas was refused, perhaps because of the pressure (96).
    too_high: bool,
    /// Transition Command and Value of the last telegram (101).
    pair: [u8; 2],
    last: [Option<f64>; 3],
}

impl Bcg450 {
    /// In a chamber at this pressure.
    pub const fn new(mbar: f64) -> Self {
        Self { mbar, emission: Emission::Gauge, degas: false, too_high: false, pair: [0; 2], last: [Some(0.0); 3] }
    }

    /// Underrange and overrange. Table "Limits".
    const fn range(instance: u8) -> (f64, f64) {
        match instance {
            1 => (5.5e-3, 1000.0),
            2 => (5e-10, 2e-2),
            _ => (1.0, 1500.0),
        }
    }

    /// PV Selector (78, 79).
    fn active(&self) -> u8 {
        match self.mbar {
            p if p > 3.16 => 3,
            p if p > 1.05e-2 => 1,
            _ => 2,
        }
    }

    /// Whether the instance measures and its pressure is in its range (54, 55).
    fn valid(&self, common: &Common, instance: u8) -> bool {
        let (under, over) = Self::range(instance);
        common.executing() && (under..=over).contains(&self.mbar) && (instance != 2 || self.mbar < 2.4e-2)
    }

    /// Values that depend on the emission and on time.
    const fn uncertain(&self, common: &Common) -> Option<u8> {
        if common.moving {
            Some(MOVING)
        } else if matches!(self.emission, Emission::Commanded) {
            Some(6)
        } else {
            None
        }
    }

    /// Status Extension of an instance (57, 58). Outside EXECUTING only bit 0 is certain.
    fn extension(&self, common: &Common, instance: u8) -> Content {
        let (under, over) = Self::range(instance);
        let bits = u8::from(!self.valid(common, instance))
            | u8::from(self.mbar > over) << 1
            | u8::from(self.mbar < under) << 2;
        Content::Bits(vec![if common.executing() { 0xFF } else { 0xF9 }], vec![bits])
    }

    /// Exception Detail Warning: ID 120 is its first detail; a refused degas may have set a bit (96).
    fn warning(&self, common: &Common, from: usize, to: usize) -> Content {
        let all = [2, 0, 0, 7, u8::from(!common.executing()), 0, 0, 0, 0, 0, 0, 1, 0];
        let mut mask = [0xFF; 13];
        mask[10] = if self.too_high { 0xF7 } else { 0xFF };
        mask[12] = if self.mbar > 1.0 { 0xF9 } else { 0xFF };
        if !common.executing() {
            mask[4] = 0xF9;
        }
        Content::Bits(mask[from..to].to_vec(), all[from..to].to_vec())
    }

    /// Hot Cathode Block State Command, 3.3.3.9 (93, 95, 102).
    fn hot_cathode(&mut self, common: &mut Common, command: u8, value: u8) -> Verdict {
        let known = self.emission == Emission::Gauge && !common.moving;
        if matches!(command, 1 | 3 | 128) && value > 1 {
            return Verdict::Refused(Reason::Range);
        }
        let verdict = match (command, value) {
            (0, 0) => return Verdict::Done,
            (0, _) => return Verdict::Open(7),
            (1, 1) if self.mbar >= 7.2e-6 || !common.executing() => Verdict::Refused(Reason::NotNow),
            (1, 1) if !known || self.degas => Verdict::Open(6),
            (1, 1) => Verdict::Done,
            (1, _) => Verdict::Done,
            (3, 1) if self.mbar >= 2.4e-2 => Verdict::Refused(Reason::NotNow),
            // (102) names no state of the device.
            (3, 1) if !common.executing() => Verdict::Open(6),
            (3 | 128, _) => Verdict::Done,
            _ => return Verdict::Refused(Reason::Range),
        };
        self.too_high |= (command, value) == (1, 1) && verdict == Verdict::Refused(Reason::NotNow);
        if verdict != Verdict::Refused(Reason::NotNow) {
            self.emission = Emission::Commanded;
            self.degas |= (command, value) == (1, 1);
            common.moving = true;
        }
        verdict
    }
}

/// tira41d1 3.1: the parameters of the Device Block.
const fn device_block(index: u8) -> Rule {
    match index {
        15 => Rule::Command,
        16 => Rule::Block(1),
        17 => Rule::Text("CG", 8),
        18 => Rule::Text("E54-0997", 9),
        19 => Rule::Text("INFICON AG", 20),
        // (36, 37): the number of a gauge.
        20..=23 => Rule::Device(8),
        24 => Rule::Text("BCG450-SP", 50),
        25 => Rule::State,
        // Without a fault: table "Exception records" (42).
        27 => Rule::Fixed(&[2, 0, 0, 6, 0, 0, 0, 0, 0, 0, 1, 0]),
        204 | 207 | 208 => Rule::Fixed(&[0]),
        205 => Rule::Fixed(&[0; 4]),
        206 => Rule::Fixed(&[0; 2]),
        _ => Rule::Own,
    }
}

impl Particular for Bcg450 {
    fn boxed(&self) -> Box<dyn Particular> {
        Box::new(self.clone())
    }

    fn rule(&self, (slot, instance, index): Key) -> Rule {
        match (slot, instance, index) {
            (0, _, _) => device_block(index),
            (1, 0, 16) => Rule::Block(3),
            (1, 1, 101) => Rule::Block(13),
            (1, 2, 101) => Rule::Block(16),
            (1, 3, 101) => Rule::Block(14),
            (1, 4, 101) => Rule::Block(256),
            (1, 1..=3, 20) => Rule::Fixed(&[0]),
            (1, 1 | 2 | 3 | 5 | 6, 21) => Rule::DataType,
            (1, 1 | 2 | 3 | 5 | 6, 22) => Rule::DataUnit,
            (1, 1..=3, 24 | 44) => Rule::Limit(Self::range(instance).1),
            (1, 1..=3, 45) => Rule::Limit(Self::range(instance).0),
            (1, 1..=3, 39) => Rule::Within(0, 3, Some(0)),
            (1, 1..=3, 40) => Rule::Kept(Some(0.0)),
            (1, 1..=3, 103) => Rule::Fixed(&[0, 0]),
            (1, 1 | 3, 104) => Rule::Fixed(&[0, 0]),
            // (56).
            (1, 5 | 6, 23) => Rule::Fixed(&[1]),
            // (26, 111).
            (1, 5 | 6, 201) => Rule::Within(0, 1, Some(0)),
            // (113).
            (1, 5 | 6, 202) => Rule::Within(10, 1400, Some(50)),
            _ => Rule::Own,
        }
    }

    fn scale(&self, _: Key) -> Scale {
        SCALE
    }

    fn units(&self) -> &'static [(u16, Unit)] {
        UNITS
    }

    fn read(&self, common: &Common, key: Key) -> Content {
        let (slot, instance, index) = key;
        let sure = |octets: Vec<u8>| self.uncertain(common).map_or(Content::Octets(octets), Content::Device);
        if let Some(reason) = self.uncertain(common)
            && !matches!((instance, index), (1 | 3, 19 | 23 | 102))
        {
            return Content::Device(reason);
        }
        let executing = u8::from(common.executing());
        match (slot, instance, index) {
            // (51, 52): the relays of atmosphere control set bit 6 (114).
            (0, _, 26) => {
                let mask = if self.mbar > 1.0 { 0xBF } else { 0xFF };
                let mask = if self.too_high { mask & 0xDF } else { mask };
                Content::Bits(vec![mask], vec![0x80 | (executing ^ 1) << 5])
            }
            (0, _, 28) => self.warning(common, 0, 13),
            (0, _, 209) => self.warning(common, 4, 8),
            (0, _, 210) => self.warning(common, 8, 11),
            (0, _, 211) => self.warning(common, 12, 13),
            (1, 0, 47) if common.executing() => sure(vec![self.active()]),
            (1, 0, 47) => Content::Device(9),
            (1, 0, 120) => Content::Bits(vec![if executing == 1 { 0xFF } else { 0xF9 }], vec![executing ^ 1]),
            (1, 1..=3, 19) => {
                let (under, over) = Self::range(instance);
                let mbar = (under..=over).contains(&self.mbar).then_some(self.mbar);
                let last = self.last[usize::from(instance) - 1];
                Process { mbar, full_scale: over, last }.content(common, key, SCALE)
            }
            (1, 1..=3, 23) if common.moving => Content::Device(MOVING),
            (1, 1..=3, 23) => Content::Octets(vec![u8::from(self.valid(common, instance))]),
            (1, 1..=3, 102) if common.moving => Content::Device(MOVING),
            (1, 1..=3, 102) => self.extension(common, instance),
            (1, 2, 104) => Content::Bits(vec![0xFF, if self.too_high { 0xF7 } else { 0xFF }], vec![0, 0]),
            // (97, 98): low or high is the choice of the gauge.
            (1, 2, 105) if !common.executing() || self.mbar > 3.2e-2 => sure(vec![0]),
            (1, 2, 105) => Content::Device(9),
            (1, 2, 106) if !common.executing() || self.mbar > 3.2e-2 => sure(vec![0; 4]),
            (1, 2, 106) => Content::Device(9),
            (1, 2, 109) => sure(vec![0]),
            (1, 2, 201) => sure(vec![1]),
            // 3.2.5.1 (109): the potentiometers are at 0 V.
            (1, 5 | 6, 19) => common.show(10f64.powf(-9.301_029_99), SCALE),
            // (106, 112).
            (1, 5 | 6, 20 | 203) if self.mbar > 1.0 => Content::Device(10),
            (1, 5 | 6, 20 | 203) => sure(vec![0]),
            _ => unreachable!("{key:?}"),
        }
    }

    fn write(&mut self, common: &mut Common, key: Key, data: &[u8]) -> Verdict {
        match (key, data) {
            ((1, 2, 14), &[command, value]) => self.hot_cathode(common, command, value),
            // (97).
            ((1, 2, 105), &[value @ 0..=1]) => self.hot_cathode(common, 3, value),
            // (98): the gauge chooses the current.
            ((1, 2, 106), &[a, b, c, d]) if [0.0, 0.025, 5.0, 20.0].contains(&f32::from_be_bytes([a, b, c, d])) => {
                Verdict::Done
            }
            // (116, 159).
            ((1, 4, 14), [0, _]) => Verdict::Done,
            ((1, 4, 14), [128, 0]) if !(300.0..=1200.0).contains(&self.mbar) => Verdict::Refused(Reason::NotNow),
            ((1, 4, 14), [128, 0 | 1]) => Verdict::Done,
            _ => Verdict::Refused(Reason::Range),
        }
    }

    fn suggest(&self, (_, _, index): Key, length: usize, random: &mut Rng) -> Vec<u8> {
        match index {
            106 => [0.0f32, 0.025, 5.0, 20.0, 1.0, f32::NAN][random.usize(..6)].to_be_bytes().to_vec(),
            14 => vec![[0, 1, 1, 3, 3, 128, 128, 2, 4, 255][random.usize(..10)], random.u8(0..3)],
            _ => (0..length).map(|_| random.u8(0..4)).collect(),
        }
    }

    fn suggest_process(&self, length: usize, random: &mut Rng) -> Vec<u8> {
        if length != 2 || random.u8(..8) != 0 {
            return vec![0; length];
        }
        self.suggest((1, 2, 14), 2, random)
    }

    fn process(&mut self, common: &mut Common, outputs: Option<&[u8]>) {
        let pair = outputs.and_then(|it| it.last_chunk::<2>().copied()).unwrap_or([0; 2]);
        let before = std::mem::replace(&mut self.pair, pair);
        if pair != before && pair[0] != 0 {
            self.hot_cathode(common, pair[0], pair[1]);
        }
    }

    fn refused(&mut self, key: Key, data: &[u8]) {
        self.too_high |= (key, data) == ((1, 2, 14), &[1, 1]);
    }

    fn settled(&mut self, common: &mut Common) {
        for instance in 1..=3 {
            if self.valid(common, instance) {
                let known = instance != 2 || self.emission == Emission::Gauge;
                self.last[usize::from(instance) - 1] = known.then_some(self.mbar);
            }
        }
    }
}
