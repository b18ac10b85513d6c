//! TPG300 and TPG500 with the boards IF300P and IF301P, from i9973ber/a. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::pressure::{Scale, Unit};
use super::{Common, Content, Key, Particular, Reason, Rule, Verdict};
use fastrand::Rng;

/// 3.2.4.1 (147).
const UNITS: &[(u16, Unit)] = &[(1, Unit::Mbar), (2, Unit::Torr), (3, Unit::Pascal)];
/// A controller has no COUNTS.
const NO_COUNTS: Scale = Scale::Line(1.0);

#[derive(Clone, Debug)]
pub struct Tpg {
    /// Channels with a gauge.
    fitted: [bool; 4],
    /// Sensor On_Off of the last telegram (128).
    sensors: u8,
    /// A request to store is under way (143).
    storing: Option<u8>,
}

impl Tpg {
    /// With gauges on these channels.
    pub const fn new(fitted: [bool; 4]) -> Self {
        Self { fitted, sensors: 0, storing: None }
    }

    /// Index 20 of a threshold block: 1 as delivered.
    fn valid(common: &Common, slot: u8) -> bool {
        common.number((slot, 0, 20)).unwrap_or(1) == 1
    }

    /// Threshold validation, 3.2.4.2 (137, 139).
    fn validate(common: &mut Common, slot: u8, value: u8) -> Verdict {
        let refused = Verdict::Refused(Reason::Range);
        let next = match value {
            0 => 0,
            1 if Self::valid(common, slot) => return Verdict::Done,
            1 => match (common.pressure((slot, 0, 21)), common.pressure((slot, 0, 22))) {
                (Some(upper), Some(lower)) if lower > upper => return refused,
                (Some(_), Some(_)) => 1,
                // One of them is as delivered, which the manual does not give.
                _ => {
                    common.set_number((slot, 0, 20), 1);
                    return Verdict::Open(2);
                }
            },
            _ => return refused,
        };
        common.set_number((slot, 0, 20), next);
        common.moving = true;
        Verdict::Done
    }
}

impl Particular for Tpg {
    fn boxed(&self) -> Box<dyn Particular> {
        Box::new(self.clone())
    }

    fn rule(&self, (slot, _, index): Key) -> Rule {
        match (slot, index) {
            // (131): the version that the table prints, BG509780-F.
            (0, 21) => Rule::Fixed(&[0x50, 0x97, 0x80, 0x06]),
            // (144).
            (0, 25) => Rule::Within(0, 1, None),
            (1..=4, 22) => Rule::DataUnit,
            // (146).
            (1..=4, 23) => Rule::Within(1, 3, None),
            (5..=10, 24) => Rule::Device(10),
            _ => Rule::Own,
        }
    }

    fn scale(&self, _: Key) -> Scale {
        NO_COUNTS
    }

    fn units(&self) -> &'static [(u16, Unit)] {
        UNITS
    }

    fn read(&self, common: &Common, key: Key) -> Content {
        match key {
            (0, _, 20) => Content::Octets(vec![self.sensors]),
            (0, _, 24) => Content::Octets(common.number(key).unwrap_or(0).to_be_bytes().to_vec()),
            (0, _, 26) => match self.storing {
                None => Content::Octets(vec![0]),
                Some(_) if !common.moving => Content::Octets(vec![0]),
                Some(_) => Content::Device(1),
            },
            // Status of a channel: no hardware is 5 (124).
            (1..=4, _, 21) if !self.fitted[usize::from(key.0) - 1] => Content::Octets(vec![5]),
            (1..=4, _, 21) => Content::Device(10),
            (5..=10, _, 20) => Content::Octets(vec![u8::from(Self::valid(common, key.0))]),
            (5..=10, _, 21 | 22) => common.kept(key, None, NO_COUNTS),
            (5..=10, _, 23) => common.number(key).map_or(Content::Device(2), |it| Content::Octets(vec![it as u8])),
            _ => unreachable!("{key:?}"),
        }
    }

    fn write(&mut self, common: &mut Common, key: Key, data: &[u8]) -> Verdict {
        let refused = Verdict::Refused(Reason::Range);
        let not_now = Verdict::Refused(Reason::Mode);
        match (key, data) {
            // (132).
            ((0, _, 24), &[high, low]) => {
                if common.number(key) == Some(9919) {
                    return not_now;
                }
                let code = u16::from_be_bytes([high, low]);
                if code > 9999 {
                    return refused;
                }
                common.set_number(key, code);
                Verdict::Done
            }
            // (143).
            ((0, _, 26), &[value @ 0..=2]) => {
                if value != 0 {
                    (self.storing, common.moving) = (Some(value), true);
                }
                Verdict::Done
            }
            ((5..=10, _, 20), &[value]) => Self::validate(common, key.0, value),
            // (138).
            ((5..=10, ..), _) if Self::valid(common, key.0) => not_now,
            // (137).
            ((5..=10, _, 21 | 22), _) => match common.evaluate(data, NO_COUNTS) {
                Some((mbar, _)) if mbar > 0.0 => common.keep(key, data, NO_COUNTS),
                _ => refused,
            },
            // (140).
            ((5..=10, _, 23), &[source @ 1..=4]) => {
                common.set_number(key, source.into());
                common.moving = true;
                Verdict::Done
            }
            _ => refused,
        }
    }

    fn suggest(&self, key: Key, length: usize, random: &mut Rng) -> Vec<u8> {
        match key {
            (5..=10, _, 21 | 22) if random.u8(..6) == 0 => {
                [0.0, -1.0, f32::NAN, f32::INFINITY, 2.3e15, 1e30][random.usize(..6)].to_be_bytes().to_vec()
            }
            (5..=10, _, 21 | 22) => 10f32.powf(random.f32() * 8.0 - 5.0).to_be_bytes().to_vec(),
            (5..=10, _, 20) => vec![[0, 0, 1, 2][random.usize(..4)]],
            (0, _, 24) => [0u16, 1, 1234, 9999, 10_000, 0x8000, 0xFFFF][random.usize(..7)].to_be_bytes().to_vec(),
            _ => (0..length).map(|_| random.u8(0..6)).collect(),
        }
    }

    fn suggest_process(&self, length: usize, random: &mut Rng) -> Vec<u8> {
        (0..length).map(|_| if random.bool() { 0 } else { random.u8(..) }).collect()
    }

    fn process(&mut self, common: &mut Common, outputs: Option<&[u8]>) {
        if let Some(&[sensors]) = outputs {
            self.sensors = sensors;
            common.moving |= sensors != 0;
        }
    }

    fn unit_of(&self, _: &[u8]) -> Option<u16> {
        None
    }

    fn settled(&mut self, _: &mut Common) {
        self.storing = None;
    }
}
