//! PCG55x and PSG55x, from tira56e1. Numbers in brackets are those of errata-pxg55x-img400.

use super::kept::Process;
use super::pressure::{Scale, Unit};
use super::{Common, Content, Key, MOVING, Particular, Phase, Reason, Rule, Verdict};
use fastrand::Rng;

/// 8.1.6 (14).
const UNITS: &[(u16, Unit)] =
    &[(0x1001, Unit::Counts), (0x1301, Unit::Torr), (0x1308, Unit::Mbar), (0x1309, Unit::Pascal)];
/// Torr of a millibar, 8.1.3 (83).
pub const TORR: f64 = 1.0 / 1.333_223_69;

/// A sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sensor {
    Diaphragm,
    Pirani,
    Atmosphere,
}

#[derive(Clone, Debug)]
pub struct Pxg55x {
    psg: bool,
    atmosphere: bool,
    mbar: f64,
    /// An adjustment has changed the readings.
    adjusted: bool,
    last: [Option<f64>; 2],
}

impl Pxg55x {
    /// In a chamber at this pressure.
    pub const fn new(psg: bool, atmosphere: bool, mbar: f64) -> Self {
        Self { psg, atmosphere, mbar, adjusted: false, last: [Some(0.0); 2] }
    }

    const fn sensor(&self, instance: u8) -> Sensor {
        match (instance, self.psg) {
            (1, false) => Sensor::Diaphragm,
            (3, _) => Sensor::Atmosphere,
            _ => Sensor::Pirani,
        }
    }

    /// Underrange, full scale and overrange (86).
    const fn range(&self, instance: u8) -> (f64, f64, f64) {
        match self.sensor(instance) {
            Sensor::Diaphragm => (1.0, 1500.0, 1500.0),
            _ => (5e-5, 1000.0, 1200.0),
        }
    }

    const fn pirani(&self) -> u8 {
        if self.psg { 1 } else { 2 }
    }

    /// Why a reading is not certain.
    fn uncertain(&self, common: &Common) -> Option<u8> {
        let pirani_off = common.number((1, self.pirani(), 201)).unwrap_or(0) != 0;
        if common.moving {
            Some(MOVING)
        } else if self.adjusted || pirani_off {
            Some(12)
        } else {
            None
        }
    }

    fn valid(&self, common: &Common, instance: u8) -> bool {
        let (under, _, over) = self.range(instance);
        common.executing() && (under..=over).contains(&self.mbar)
    }

    /// AIBlockAdjust Command, 8.1.1, 8.2.1, 8.3.1 (78, 79, 80, 164).
    fn adjust(&mut self, common: &mut Common, instance: u8, command: u8) -> Verdict {
        let gain = match (self.sensor(instance), command) {
            (Sensor::Atmosphere, 1) => !(300.0..=1200.0).contains(&self.mbar),
            (Sensor::Pirani, 1) => self.mbar < 100.0,
            (Sensor::Diaphragm | Sensor::Pirani, 0) => false,
            _ => return Verdict::Done,
        };
        if common.executing() && gain && self.uncertain(common).is_none() {
            return Verdict::Refused(Reason::NotNow);
        }
        // (78): IDLE is free. An adjustment has changed the reading that the next one needs.
        let certain = common.executing() && self.uncertain(common).is_none();
        let verdict = if certain { Verdict::Done } else { Verdict::Open(12) };
        self.adjusted = true;
        common.moving = true;
        verdict
    }

    /// Status of a trip point (97, 98, 104): between the two points of a hysteresis the gauge knows.
    fn trip(&self, common: &Common, slot: u8) -> Content {
        if !common.executing() && !common.moving {
            return Content::Octets(vec![0]);
        }
        let enabled = |index: u8, factory: u16| common.number((slot, 0, index)).unwrap_or(factory) == 1;
        if !enabled(18, 0) && !enabled(20, 1) && !common.moving {
            return Content::Octets(vec![0]);
        }
        Content::Device(if common.moving { MOVING } else { 10 })
    }

    /// Whether Setpoint Mode computes the trip point (101).
    fn computed(common: &Common, slot: u8, index: u8) -> bool {
        let mode = common.number((slot, 0, 202)).unwrap_or(0);
        matches!((mode, index), (1, 19) | (2, 17))
    }

    /// A hysteresis is a difference of pressures: only in linear units is it a number of its own (32).
    fn hysteresis(common: &Common, key: Key) -> Content {
        match common.pressure(key) {
            Some(mbar) if mbar.is_finite() && common.form.unit != Unit::Counts => {
                common.kept(key, None, Scale::Line(1.0))
            }
            _ => Content::Device(11),
        }
    }
}

impl Particular for Pxg55x {
    fn boxed(&self) -> Box<dyn Particular> {
        Box::new(self.clone())
    }

    fn rule(&self, (slot, instance, index): Key) -> Rule {
        let sensor = self.sensor(instance);
        match (slot, instance, index) {
            (0, _, 15) => Rule::Command,
            (0, _, 16) => Rule::Block(1),
            (0, _, 17) if self.psg => Rule::Text("VPG", 8),
            (0, _, 17) => Rule::Text("CVG", 8),
            (0, _, 18) => Rule::Text("E54-0997", 9),
            (0, _, 19) => Rule::Text("INFICON AG", 20),
            (0, _, 20..=24 | 36 | 202 | 211 | 212) => Rule::Device(8),
            (0, _, 25) => Rule::State,
            (0, _, 27) if self.psg => Rule::Fixed(&[2, 0, 0, 2, 0, 0, 1, 0]),
            (0, _, 27) => Rule::Fixed(&[2, 0, 0, 4, 0, 0, 0, 0, 1, 0]),
            (0, _, 204 | 207) => Rule::Fixed(&[0; 2]),
            (0, _, 205 | 209) if self.psg => Rule::Fixed(&[0; 2]),
            (0, _, 205 | 209) => Rule::Fixed(&[0; 4]),
            (0, _, 206 | 210) => Rule::Fixed(&[0]),
            (1, 1..=3, 16) => Rule::Block(2),
            (1, 1..=3, 20) => Rule::Fixed(&[0]),
            (1, 1..=3, 21) | (2 | 3, _, 29) => Rule::DataType,
            (1, 1..=3, 22) | (2 | 3, _, 28) => Rule::DataUnit,
            (1, 3, 24 | 44 | 45) => Rule::Device(8),
            (1, 1 | 2, 24) => Rule::Limit(self.range(instance).1),
            (1, 1 | 2, 44) => Rule::Limit(self.range(instance).2),
            (1, 1 | 2, 45) => Rule::Limit(self.range(instance).0),
            (1, 1..=3, 39) => Rule::Within(0, 3, Some(0)),
            (1, 1..=3, 40) => Rule::Kept(Some(0.0)),
            (1, 1, 41) => Rule::Within(0, 1, None),
            (1, _, 101) if sensor == Sensor::Diaphragm => Rule::Block(14),
            (1, _, 101) if sensor == Sensor::Atmosphere => Rule::Block(256),
            (1, _, 101) => Rule::Block(13),
            (1, _, 103 | 104) => Rule::Fixed(&[0, 0]),
            (1, _, 201) => Rule::Within(0, 2, Some(0)),
            (2 | 3, _, 16) => Rule::Block(17),
            (2 | 3, _, 18) => Rule::Within(0, 1, Some(0)),
            (2 | 3, _, 20) => Rule::Within(0, 1, Some(1)),
            (2 | 3, _, 26) => Rule::Fixed(&[1]),
            (4 | 5, _, 16) => Rule::Block(7),
            (4 | 5, _, 20) => Rule::Fixed(&[0]),
            _ => Rule::Own,
        }
    }

    /// tira56e1 8.1.3, 8.3.3 (81, 82).
    fn scale(&self, (slot, instance, _): Key) -> Scale {
        if slot == 1 && instance == 3 {
            return Scale::Line(16.0);
        }
        Scale::Logarithm { factor: 3511.0, offset: 3511.0 * 1_048_576f64.log10() + 1.0 }
    }

    fn units(&self) -> &'static [(u16, Unit)] {
        UNITS
    }

    fn read(&self, common: &Common, key: Key) -> Content {
        let (slot, instance, index) = key;
        let executing = u8::from(common.executing());
        let status = Content::Bits(vec![if executing == 1 { 0xFF } else { 0xF9 }], vec![executing ^ 1]);
        let uncertain = self.uncertain(common);
        match (slot, instance, index) {
            (1, _, 15) => Content::Octets(vec![0, 0]),
            (2 | 3, _, 17 | 19) if Self::computed(common, slot, index) => Content::Device(10),
            (2 | 3, _, 17 | 19) => common.kept(key, None, self.scale(key)),
            (2 | 3, _, 21) => self.trip(common, slot),
            // (93): it mirrors the trip point of the same relay.
            (4 | 5, _, 19) => self.trip(common, slot - 2),
            (2 | 3, _, 31 | 32) => Self::hysteresis(common, key),
            (2 | 3, _, 201) => match common.pressure(key) {
                Some(factor) => Content::Octets((factor as f32).to_be_bytes().to_vec()),
                None => Content::Device(2),
            },
            (2 | 3, _, 202) => Content::Octets(vec![common.number(key).unwrap_or(0) as u8]),
            // A sensor of the ambient pressure is not in the chamber.
            (1, 3, _) => Content::Device(8),
            _ if uncertain.is_some() => Content::Device(uncertain.unwrap_or(MOVING)),
            // (36).
            (0, _, 26) => Content::Octets(vec![0x80 | (executing ^ 1) << 5]),
            (0, _, 28) => {
                let octets: &[u8] =
                    if self.psg { &[2, 0, 0, 3, 0, 0, 0, 1, 0] } else { &[2, 0, 0, 5, 0, 0, 0, 0, 0, 1, 0] };
                let (mut octets, mut mask) = (octets.to_vec(), vec![0xFF; octets.len()]);
                octets[4] = executing ^ 1;
                mask[4] = if executing == 1 { 0xFF } else { 0xF9 };
                Content::Bits(mask, octets)
            }
            (0, _, 208) | (1, 0, 120) => status,
            (1, 0, 47) if self.psg => Content::Octets(vec![1]),
            (1, 0, 47) if !common.executing() => Content::Device(9),
            // (67).
            (1, 0, 47) => Content::Octets(vec![if self.mbar >= 50.0 { 1 } else { 2 }]),
            (1, 1 | 2, 19) => {
                let (under, full_scale, over) = self.range(instance);
                let mbar = (under..=over).contains(&self.mbar).then_some(self.mbar);
                let last = self.last[usize::from(instance) - 1];
                Process { mbar, full_scale, last }.content(common, key, self.scale(key))
            }
            (1, 1 | 2, 23) => Content::Octets(vec![u8::from(self.valid(common, instance))]),
            (1, 1 | 2, 102) => {
                let (under, _, over) = self.range(instance);
                let bits = u8::from(!self.valid(common, instance))
                    | u8::from(self.mbar > over) << 1
                    | u8::from(self.mbar < under) << 2;
                Content::Bits(vec![if executing == 1 { 0xFF } else { 0xF9 }], vec![bits])
            }
            _ => unreachable!("{key:?}"),
        }
    }

    fn write(&mut self, common: &mut Common, key: Key, data: &[u8]) -> Verdict {
        let refused = Verdict::Refused(Reason::Range);
        match (key, data) {
            ((1, instance, 15), &[command, _]) => self.adjust(common, instance, command),
            ((2 | 3, _, 17 | 19), _) if Self::computed(common, key.0, key.2) => Verdict::Refused(Reason::Mode),
            ((2 | 3, _, 17 | 19), _) => {
                common.moving = true;
                common.keep(key, data, self.scale(key))
            }
            ((2 | 3, _, 31 | 32), _) => {
                common.moving = true;
                if common.form.unit != Unit::Counts {
                    return common.keep(key, data, Scale::Line(1.0));
                }
                let Some(number) = common.form.parse(data).filter(|it| !it.is_nan()) else { return refused };
                common.set_pressure(key, f64::NAN);
                if number >= 0.0 && number.is_finite() { Verdict::Open(11) } else { refused }
            }
            ((2 | 3, _, 201), &[a, b, c, d]) => {
                let factor = f32::from_be_bytes([a, b, c, d]);
                if !factor.is_finite() {
                    return refused;
                }
                common.set_pressure(key, factor.into());
                common.moving = true;
                if (0.0..1e6).contains(&factor) { Verdict::Done } else { Verdict::Open(14) }
            }
            // (100).
            ((2 | 3, _, 202), &[mode]) if matches!(mode, 0 | 4) || (self.atmosphere && matches!(mode, 1 | 2)) => {
                if common.number(key).is_some_and(|it| matches!(it, 1 | 2)) || matches!(mode, 1 | 2) {
                    common.forget_pressure((key.0, 0, 17));
                    common.forget_pressure((key.0, 0, 19));
                }
                common.set_number(key, mode.into());
                common.moving = true;
                Verdict::Done
            }
            _ => refused,
        }
    }

    /// tira56e1 7.2.2: 129 is Reset. 128, Factory Reset, is not in the conversations.
    fn command(&mut self, common: &mut Common, number: u8) -> Verdict {
        if number != 129 {
            return Verdict::Refused(Reason::Range);
        }
        common.phase = Phase::Init;
        common.moving = true;
        Verdict::Done
    }

    fn suggest(&self, (_, _, index): Key, length: usize, random: &mut Rng) -> Vec<u8> {
        match index {
            17 | 19 | 31 | 32 if length == 4 && random.u8(..8) == 0 => {
                [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30][random.usize(..5)].to_be_bytes().to_vec()
            }
            17 | 19 | 31 | 32 if length == 4 => 10f32.powf(random.f32() * 8.0 - 4.0).to_be_bytes().to_vec(),
            17 | 19 | 31 | 32 => random.u16(..0x8100).to_be_bytes().to_vec(),
            201 => [0.9f32, 1.0, 0.0, 2.5, f32::NAN, f32::INFINITY][random.usize(..6)].to_be_bytes().to_vec(),
            15 => vec![[0, 1, 2, 255][random.usize(..4)], random.u8(0..3)],
            _ => (0..length).map(|_| random.u8(0..6)).collect(),
        }
    }

    fn settled(&mut self, common: &mut Common) {
        for instance in 1..=2 {
            if self.valid(common, instance) {
                let known = self.uncertain(common).is_none();
                self.last[usize::from(instance) - 1] = known.then_some(self.mbar);
            }
        }
    }
}
