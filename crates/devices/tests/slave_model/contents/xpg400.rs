//! BPG400-SP and HPG400-SP, from tira36e1. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::bcg450::UNITS;
use super::kept::Process;
use super::pressure::{Scale, Unit};
use super::{Common, Content, Key, MOVING, Particular, Reason, Rule, Verdict};
use fastrand::Rng;

#[derive(Clone, Debug)]
pub struct Xpg400 {
    hpg: bool,
    mbar: f64,
    /// A command has changed the emission or adjusts the Pirani.
    commanded: bool,
    last: [Option<f64>; 2],
}

impl Xpg400 {
    /// In a chamber at this pressure.
    pub const fn new(hpg: bool, mbar: f64) -> Self {
        Self { hpg, mbar, commanded: false, last: [Some(0.0); 2] }
    }

    /// Underrange and overrange. Table "Limits".
    const fn range(&self, instance: u8) -> (f64, f64) {
        match (instance, self.hpg) {
            (1, false) => (5.5e-3, 1000.0),
            (1, true) => (1e-2, 1000.0),
            (_, false) => (5e-10, 2e-2),
            (_, true) => (1e-6, 1.0),
        }
    }

    /// The pressure at which PV Selector and emission change (77, 82).
    const fn threshold(&self) -> f64 {
        if self.hpg { 1.0 } else { 5.5e-3 }
    }

    fn valid(&self, common: &Common, instance: u8) -> bool {
        let (under, over) = self.range(instance);
        common.executing() && (under..=over).contains(&self.mbar)
    }

    const fn uncertain(&self, common: &Common) -> Option<u8> {
        if common.moving {
            Some(MOVING)
        } else if self.commanded {
            Some(6)
        } else {
            None
        }
    }

    /// Hot Cathode Block State Command, 3.3.3.8, and Emission Status (93 to 97).
    fn hot_cathode(&mut self, common: &mut Common, command: u8, value: u8) -> Verdict {
        let verdict = match (command, value) {
            (0, 0) => return Verdict::Done,
            (0, _) => return Verdict::Open(7),
            (1, 1) if self.mbar >= 7.2e-6 || !common.executing() => return Verdict::Refused(Reason::NotNow),
            (1, 1) if self.uncertain(common).is_some() => Verdict::Open(6),
            (1, 0 | 1) => Verdict::Done,
            _ => return Verdict::Refused(Reason::Range),
        };
        self.commanded = true;
        common.moving = true;
        verdict
    }

    /// Exception Detail Warning.
    fn warning(&self, common: &Common, from: usize, to: usize) -> Content {
        let all = [2, 0, 0, 5, u8::from(!common.executing()), 0, 0, 0, 0, 1, 0];
        let mut mask = [0xFF; 11];
        mask[8] = 0xF7;
        if !common.executing() {
            mask[4] = 0xF9;
        }
        Content::Bits(mask[from..to].to_vec(), all[from..to].to_vec())
    }
}

impl Particular for Xpg400 {
    fn boxed(&self) -> Box<dyn Particular> {
        Box::new(self.clone())
    }

    fn rule(&self, (slot, instance, index): Key) -> Rule {
        match (slot, instance, index) {
            (0, _, 15) => Rule::Command,
            (0, _, 16) => Rule::Block(1),
            (0, _, 17) => Rule::Text("CG", 8),
            (0, _, 18) => Rule::Text("E54-0997", 9),
            (0, _, 19) => Rule::Text("INFICON AG", 20),
            (0, _, 20..=23) => Rule::Device(8),
            (0, _, 24) if self.hpg => Rule::Text("HPG400-SP", 50),
            (0, _, 24) => Rule::Text("BPG400-SP", 50),
            (0, _, 25) => Rule::State,
            (0, _, 27) => Rule::Fixed(&[2, 0, 0, 4, 0, 0, 0, 0, 1, 0]),
            // (38, 82): position 0 of the switch is 1 mbar.
            (0, _, 202) => Rule::Limit(1.0),
            (0, _, 203) => Rule::Device(8),
            (0, _, 204 | 206 | 207 | 209) => Rule::Fixed(&[0]),
            (0, _, 205) => Rule::Fixed(&[0; 4]),
            (1, 0, 16) => Rule::Block(3),
            (1, 1, 101) => Rule::Block(13),
            (1, 2, 101) => Rule::Block(16),
            (1, 1 | 2, 20) => Rule::Fixed(&[0]),
            (1, 1..=4, 21) => Rule::DataType,
            (1, 1..=4, 22) => Rule::DataUnit,
            (1, 1 | 2, 24 | 44) => Rule::Limit(self.range(instance).1),
            (1, 1 | 2, 45) => Rule::Limit(self.range(instance).0),
            (1, 1 | 2, 39) => Rule::Within(0, 3, Some(0)),
            (1, 1 | 2, 40) => Rule::Kept(Some(0.0)),
            (1, 1 | 2, 103) | (1, 1, 104) => Rule::Fixed(&[0, 0]),
            // (56).
            (1, 3 | 4, 23) => Rule::Fixed(&[1]),
            _ => Rule::Own,
        }
    }

    /// Table "COUNTS formulas".
    fn scale(&self, (slot, instance, _): Key) -> Scale {
        let (factor, offset) = match (slot, instance) {
            _ if !self.hpg => (2000.0, 25_000.0),
            (0, _) | (1, 1) => (4000.0 / 6.0, 42.5 * 4000.0 / 6.0),
            (1, 2) => (16_000.0 / 6.0, 9.125 * 16_000.0 / 6.0),
            _ => (2444.0, 22_999.0),
        };
        Scale::Logarithm { factor, offset }
    }

    fn units(&self) -> &'static [(u16, Unit)] {
        UNITS
    }

    fn read(&self, common: &Common, key: Key) -> Content {
        let (slot, instance, index) = key;
        if let Some(reason) = self.uncertain(common)
            && index != 19
        {
            return Content::Device(reason);
        }
        let executing = u8::from(common.executing());
        let high = self.mbar >= self.threshold();
        match (slot, instance, index) {
            (0, _, 26) => Content::Octets(vec![0x80 | (executing ^ 1) << 5]),
            (0, _, 28) => self.warning(common, 0, 11),
            (0, _, 208) => self.warning(common, 5, 9),
            (1, 0, 47) if common.executing() => Content::Octets(vec![if high { 1 } else { 2 }]),
            (1, 0, 47) => Content::Device(9),
            (1, 0, 120) => Content::Bits(vec![if executing == 1 { 0xFF } else { 0xF9 }], vec![executing ^ 1]),
            (1, 1 | 2, 19) => {
                let (under, over) = self.range(instance);
                let measures = (under..=over).contains(&self.mbar) && (instance == 1 || !self.commanded);
                let last = self.last[usize::from(instance) - 1];
                let mbar = measures.then_some(self.mbar);
                Process { mbar, full_scale: over, last }.content(common, key, self.scale(key))
            }
            (1, 1 | 2, 23) => Content::Octets(vec![u8::from(self.valid(common, instance))]),
            (1, 1 | 2, 102) => {
                let (under, over) = self.range(instance);
                let bits = u8::from(!self.valid(common, instance))
                    | u8::from(self.mbar > over) << 1
                    | u8::from(self.mbar < under) << 2;
                Content::Bits(vec![if executing == 1 { 0xFF } else { 0xF9 }], vec![bits])
            }
            (1, 2, 104) => Content::Bits(vec![0xFF, 0xF7], vec![0, 0]),
            (1, 2, 105) if !common.executing() || high => Content::Octets(vec![0]),
            (1, 2, 105) if self.hpg => Content::Octets(vec![1]),
            (1, 2, 106) if !common.executing() || high => Content::Octets(vec![0; 4]),
            (1, 2, 105 | 106) => Content::Device(9),
            (1, 2, 109) | (1, 1, 140) => Content::Octets(vec![0]),
            // 3.2.4.1 (109): the potentiometers are at 0 V.
            (1, 3 | 4, 19) if self.hpg => common.show(1e-6, self.scale(key)),
            (1, 3 | 4, 19) => common.show(10f64.powf(-9.301_029_99), self.scale(key)),
            // (106): open above the threshold.
            (1, 3 | 4, 20) => Content::Octets(vec![0]),
            _ => unreachable!("{key:?}"),
        }
    }

    fn write(&mut self, common: &mut Common, key: Key, data: &[u8]) -> Verdict {
        match (key, data) {
            // AI Block Adjust Command, 3.2.1.1 (103).
            ((1, 0, 15), [0]) => Verdict::Done,
            ((1, 0, 15), [1]) if !common.executing() => Verdict::Refused(Reason::NotNow),
            ((1, 0, 15), [1]) => {
                let verdict = if self.uncertain(common).is_some() { Verdict::Open(6) } else { Verdict::Done };
                self.commanded = true;
                common.moving = true;
                verdict
            }
            ((1, 2, 14), &[command, value]) => self.hot_cathode(common, command, value),
            // (97).
            ((1, 2, 105), [1]) if self.mbar >= 3.2e-2 && !self.hpg => Verdict::Refused(Reason::NotNow),
            ((1, 2, 105), [0 | 1]) => {
                self.commanded = true;
                common.moving = true;
                if data[0] == 0 { Verdict::Done } else { Verdict::Open(6) }
            }
            // (98).
            ((1, 2, 106), &[a, b, c, d]) if [0.0, 0.025, 5.0, 20.0].contains(&f32::from_be_bytes([a, b, c, d])) => {
                Verdict::Done
            }
            _ => Verdict::Refused(Reason::Range),
        }
    }

    fn suggest(&self, (_, _, index): Key, length: usize, random: &mut Rng) -> Vec<u8> {
        match index {
            106 => [0.0f32, 0.025, 5.0, 20.0, 1.0, f32::NAN][random.usize(..6)].to_be_bytes().to_vec(),
            _ => (0..length).map(|_| random.u8(0..4)).collect(),
        }
    }

    fn settled(&mut self, common: &mut Common) {
        for instance in 1..=2 {
            if self.valid(common, instance) {
                self.last[usize::from(instance) - 1] = (!self.commanded).then_some(self.mbar);
            }
        }
    }
}
