//! IMG 400 with the board IF 400 P, from BG 5530, with the gauges BAG, EXT, TPR and CMR in high vacuum. Numbers in brackets
//! are those of errata-pxg55x-img400.

use super::kept::Process;
use super::pressure::{Scale, Unit};
use super::{Common, Content, Key, MOVING, Particular, Reason, Rule, Verdict};
use fastrand::Rng;

/// 4.4.2 (14).
const UNITS: &[(u16, Unit)] = &[
    (0x1001, Unit::Counts),
    (0x1301, Unit::Torr),
    (0x1302, Unit::Micron),
    (0x1308, Unit::Mbar),
    (0x1309, Unit::Pascal),
];
/// 4.4.2 (134).
const SCALE: Scale = Scale::Logarithm { factor: 4000.0, offset: 50_000.0 };

#[derive(Clone, Debug)]
pub struct Img400 {
    mbar: f64,
    /// The emission of channels 1 and 2, while it is known.
    emission: [Option<bool>; 2],
    degas: [bool; 2],
    /// A zero adjust has changed the reading.
    adjusted: [bool; 4],
    pair: [u8; 2],
    last: [Option<f64>; 2],
}

impl Img400 {
    /// In a chamber at this pressure: below 1e-5 hPa.
    pub const fn new(mbar: f64) -> Self {
        Self {
            mbar,
            emission: [Some(false); 2],
            degas: [false; 2],
            adjusted: [false; 4],
            pair: [0; 2],
            last: [Some(0.0); 2],
        }
    }

    /// Hot Cathode Block State Command, 4.4.4 (149 to 152).
    fn hot_cathode(&mut self, common: &mut Common, channel: usize, command: u8, value: u8) -> Verdict {
        match (command, value) {
            (0, 0) | (4, 0 | 1) => Verdict::Done,
            (0, _) => Verdict::Open(7),
            (1, 1) => match self.emission[channel] {
                Some(false) if !common.restarted => Verdict::Refused(Reason::NotNow),
                Some(true) if !common.moving && !common.restarted && !self.degas[channel] => {
                    self.degas[channel] = true;
                    common.moving = true;
                    Verdict::Done
                }
                _ => {
                    self.degas[channel] = true;
                    Verdict::Open(6)
                }
            },
            (1, 0) => Verdict::Done,
            (3, 0 | 1) => {
                self.emission[channel] = Some(value == 1);
                common.moving = true;
                Verdict::Done
            }
            _ => Verdict::Refused(Reason::Range),
        }
    }

    /// Block Adjust Command, 4.4.2 (131). The command 1 or the target 2 are no values at all.
    fn adjust(&mut self, common: &mut Common, slot: u8, command: u8, target: u8) -> Verdict {
        let allowed = match slot {
            1 | 2 => target == 1,
            4 => true,
            _ => false,
        };
        if command != 0 || target > 1 {
            // (131) gives 202 and 2, and no order.
            return if slot == 3 { Verdict::Open(15) } else { Verdict::Refused(Reason::Range) };
        }
        if !allowed {
            return Verdict::Refused(Reason::NotNow);
        }
        self.adjusted[usize::from(slot) - 1] = true;
        common.moving = true;
        Verdict::Open(12)
    }

    fn uncertain(&self, common: &Common, channel: usize) -> Option<u8> {
        if common.moving {
            Some(MOVING)
        } else if self.adjusted[channel] {
            Some(12)
        } else if channel < 2 && (common.restarted || self.emission[channel].is_none() || self.degas[channel]) {
            Some(6)
        } else {
            None
        }
    }

    /// Numbers of trip point and upper threshold of a relay, if they are known and have a difference (138, 140).
    fn points(common: &Common, slot: u8) -> (Option<f64>, Option<f64>) {
        let number = |index: u8| {
            let mbar = common.pressure((slot, 0, index)).filter(|it| it.is_finite())?;
            (mbar > 0.0 || common.form.unit != Unit::Counts).then(|| common.form.number(mbar, SCALE))
        };
        (number(19), number(201))
    }

    /// Writes of a trip point, its hysteresis and its upper threshold (138 to 141).
    fn trip(common: &mut Common, key: Key, data: &[u8]) -> Verdict {
        let refused = Verdict::Refused(Reason::Range);
        let (slot, _, index) = key;
        let Some(number) = common.form.parse(data).filter(|it| it.is_finite()) else { return refused };
        let (low, upper) = Self::points(common, slot);
        common.moving = true;
        let at = |common: &mut Common, number: Option<f64>| {
            let mbar = number.map_or(f64::NAN, |it| common.form.mbar(it, SCALE));
            common.set_pressure((slot, 0, 201), mbar);
        };
        match index {
            19 => {
                let verdict = common.keep(key, data, SCALE);
                let hysteresis = low.zip(upper).map(|(low, upper)| upper - low);
                at(common, hysteresis.map(|it| number + it));
                // In COUNTS a hysteresis is a factor, and the upper threshold may become enormous.
                let enormous = match hysteresis {
                    Some(hysteresis) => common.form.mbar(number + hysteresis, SCALE) >= 1e28,
                    None => low.is_some() && common.form.unit == Unit::Counts,
                };
                if enormous && verdict == Verdict::Done { Verdict::Open(3) } else { verdict }
            }
            24 if number < 0.0 => refused,
            24 => {
                at(common, low.map(|low| low + number));
                if number < 1e20 && low.is_some() { Verdict::Done } else { Verdict::Open(3) }
            }
            _ => match low {
                Some(low) if number < low => refused,
                Some(_) => common.keep(key, data, SCALE),
                None => match common.keep(key, data, SCALE) {
                    Verdict::Done => Verdict::Open(2),
                    other => other,
                },
            },
        }
    }
}

impl Particular for Img400 {
    fn boxed(&self) -> Box<dyn Particular> {
        Box::new(self.clone())
    }

    fn rule(&self, (slot, _, index): Key) -> Rule {
        match (slot, index) {
            (0, 15) => Rule::Command,
            (0, 16) => Rule::Block(1),
            (0, 25) => Rule::State,
            // A gauge of this pressure is below the range of TPR and CMR (126).
            (0, 26) => Rule::Fixed(&[0xA0]),
            // (129).
            (0, 203) => Rule::Within(0, 3, Some(0)),
            (1..=4, 16) => Rule::Block(2),
            (1..=4, 20) => Rule::Fixed(&[0]),
            (1..=4, 21) => Rule::DataType,
            // (143).
            (1..=4, 22) | (5..=11, 28) => Rule::ShowsUnit,
            // (142).
            (5..=11, 29) => Rule::ShowsType,
            // (133).
            (1..=4, 24 | 44 | 45) => Rule::Device(13),
            (1..=4, 39) => Rule::Within(0, 3, Some(0)),
            (1..=4, 40) => Rule::Kept(Some(0.0)),
            (5..=11, 16) => Rule::Block(17),
            (5..=11, 20) => Rule::Within(0, 1, None),
            (5..=11, 21) => Rule::Device(10),
            (5..=11, 27) => Rule::Within(1, 4, None),
            (1 | 2, 101) => Rule::Block(16),
            (3, 101) => Rule::Block(13),
            (4, 101) => Rule::Block(14),
            (1..=4, 103 | 104) => Rule::Fixed(&[0, 0]),
            _ => Rule::Own,
        }
    }

    fn scale(&self, _: Key) -> Scale {
        SCALE
    }

    fn units(&self) -> &'static [(u16, Unit)] {
        UNITS
    }

    fn init_code(&self) -> u8 {
        100
    }

    fn read(&self, common: &Common, key: Key) -> Content {
        let (slot, _, index) = key;
        let channel = usize::from(slot.saturating_sub(1));
        match (slot, index) {
            (0, 204) => Content::Device(10),
            (1..=4, 15) | (1 | 2, 14) => Content::Octets(vec![0, 0]),
            (5..=11, 19 | 201) => match common.pressure(key) {
                Some(mbar) if mbar.is_finite() => common.kept(key, None, SCALE),
                _ => Content::Device(2),
            },
            (5..=11, 24) => match Self::points(common, slot) {
                (Some(low), Some(upper)) if upper != low && (upper - low).abs() < 1e-9 * low => Content::Device(17),
                (Some(low), Some(upper)) => Content::About(common.form.octets(upper - low)),
                _ => Content::Device(2),
            },
            (1..=4, _) if let Some(reason) = self.uncertain(common, channel) => Content::Device(reason),
            (1 | 2, 19) => {
                let mbar = (self.emission[channel] == Some(true)).then_some(self.mbar);
                if common.number((slot, 0, 39)) == Some(1) {
                    return Content::Device(13);
                }
                Process { mbar, full_scale: 0.0, last: self.last[channel] }.content(common, key, SCALE)
            }
            (3 | 4, 19) => Content::Device(13),
            // (125).
            (1..=4, 23) => Content::Octets(vec![u8::from(common.executing())]),
            (1 | 2, 102) => {
                let measures = common.executing() && self.emission[channel] == Some(true);
                Content::Bits(vec![if measures { 0xFF } else { 0xF9 }], vec![u8::from(!measures)])
            }
            (3 | 4, 102) => {
                let executing = common.executing();
                Content::Bits(vec![if executing { 0xFF } else { 0xF9 }], vec![4 | u8::from(!executing)])
            }
            (1 | 2, 105) => Content::Octets(vec![u8::from(self.emission[channel] == Some(true))]),
            (1 | 2, 107) => Content::Device(9),
            (1 | 2, 110) => Content::Octets(vec![0]),
            _ => unreachable!("{key:?}"),
        }
    }

    fn write(&mut self, common: &mut Common, key: Key, data: &[u8]) -> Verdict {
        let refused = Verdict::Refused(Reason::Range);
        match (key, data) {
            // (128).
            ((0, _, 205), _) => Verdict::Done,
            ((1..=4, _, 15), &[command, target]) => self.adjust(common, key.0, command, target),
            ((slot @ 1..=2, _, 14), &[command, value]) => {
                self.hot_cathode(common, usize::from(slot) - 1, command, value)
            }
            ((slot @ 1..=2, _, 105), &[value @ 0..=1]) => self.hot_cathode(common, usize::from(slot) - 1, 3, value),
            // (147).
            ((1 | 2, _, 107), &[a, b, c, d]) => {
                let code = f32::from_be_bytes([a, b, c, d]);
                if [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0].contains(&code) { Verdict::Done } else { refused }
            }
            ((5..=11, ..), _) => Self::trip(common, key, data),
            _ => refused,
        }
    }

    fn suggest(&self, (slot, _, index): Key, length: usize, random: &mut Rng) -> Vec<u8> {
        match (slot, index) {
            (_, 107) => [0.0f32, 1.0, 4.0, 6.0, 7.0, 0.1, f32::NAN][random.usize(..7)].to_be_bytes().to_vec(),
            (_, 14) => vec![[0, 1, 1, 3, 3, 4, 2, 128][random.usize(..8)], random.u8(0..3)],
            (5..=11, _) if length == 4 && random.u8(..8) == 0 => {
                [0.0, -1.0, f32::NAN, f32::INFINITY][random.usize(..4)].to_be_bytes().to_vec()
            }
            (5..=11, _) if length == 4 => 10f32.powf(random.f32() * 8.0 - 4.0).to_be_bytes().to_vec(),
            (5..=11, _) => random.u16(..).to_be_bytes().to_vec(),
            _ => (0..length).map(|_| random.u8(0..4)).collect(),
        }
    }

    fn suggest_process(&self, length: usize, random: &mut Rng) -> Vec<u8> {
        if length != 2 || random.u8(..8) != 0 {
            return vec![0; length];
        }
        vec![[1, 3, 3, 4, 2][random.usize(..5)], random.u8(0..3)]
    }

    fn process(&mut self, common: &mut Common, outputs: Option<&[u8]>) {
        let pair = outputs.and_then(|it| it.last_chunk::<2>().copied()).unwrap_or([0; 2]);
        let before = std::mem::replace(&mut self.pair, pair);
        if pair != before && pair != [0, 0] {
            // (116).
            for channel in 0..2 {
                self.hot_cathode(common, channel, pair[0], pair[1]);
            }
        }
    }

    fn settled(&mut self, common: &mut Common) {
        for channel in 0..2 {
            if common.executing() && self.emission[channel] == Some(true) {
                self.last[channel] = self.uncertain(common, channel).is_none().then_some(self.mbar);
            }
        }
    }
}
