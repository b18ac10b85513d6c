//! The parameters of gauges and controllers as the manuals and the errata describe them: what a read returns, and what a
//! write does or why it is refused. Nothing here knows the tables of `crates/devices`.

pub mod bcg450;
pub mod img400;
pub mod kept;
pub mod pressure;
pub mod pxg55x;
pub mod tpg;
pub mod xpg400;

use fastrand::Rng;
use pressure::{Form, Scale, Unit};
use std::collections::BTreeMap;
use std::fmt::Debug;

/// Slot, instance (0: for all) and index.
pub type Key = (u8, u8, u8);

/// Why a write is refused: a row of the table of refusals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    Mode,
    Already,
    NotNow,
    Range,
}

/// What a parameter is. Numbers in brackets are errata.
#[derive(Clone, Copy, Debug)]
pub enum Rule {
    /// These octets.
    Fixed(&'static [u8]),
    /// A text, filled with blanks.
    Text(&'static str, usize),
    /// A block type: a word and two zeros (31).
    Block(u16),
    /// Device Block State Command.
    Command,
    /// Device State.
    State,
    DataType,
    DataUnit,
    /// A data unit or data type that a write does not change.
    ShowsUnit,
    ShowsType,
    /// A number in one octet or two between these values, with the one as delivered if it is known.
    Within(u16, u16, Option<u16>),
    /// A constant pressure in mbar.
    Limit(f64),
    /// A stored pressure in mbar as delivered, if it is known. Any number can be stored.
    Kept(Option<f64>),
    /// The device knows: the reason is in [`crate::slave_model::open_points::OF_THE_DEVICE`].
    Device(u8),
    /// The particular device has its own rule.
    Own,
}

/// What a read returns.
#[derive(Clone, Debug)]
pub enum Content {
    Octets(Vec<u8>),
    /// A number that was computed: the last digit is free.
    About(Vec<u8>),
    /// Only these bits are certain.
    Bits(Vec<u8>, Vec<u8>),
    /// What the device has, with the number of the reason.
    Device(u8),
}

/// What a write leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Done,
    Refused(Reason),
    /// Either, with the number of the reason.
    Open(u8),
}

/// Device time has passed or not: the values of sensors are not yet there.
pub const MOVING: u8 = 1;

/// The states of Device State.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    Init,
    SelfTest,
    Idle,
    Executing,
    Abort,
}

/// A stored pressure.
#[derive(Clone, Debug)]
struct Stored {
    mbar: f64,
    /// How it was written; it reads the same in this form.
    written: Option<(Form, Vec<u8>)>,
}

/// What all devices have.
#[derive(Clone, Debug)]
pub struct Common {
    pub phase: Phase,
    pub exchange: bool,
    /// EXECUTING begins with IDLE: the exchange began during the self test.
    execute: bool,
    /// Something has happened that takes the device time.
    pub moving: bool,
    /// EXECUTING has begun, and the device had no time to measure: its last value is not certain.
    pub unmeasured: bool,
    /// A Reset or a self test may have changed what commands had switched.
    pub restarted: bool,
    pub form: Form,
    pressures: BTreeMap<Key, Stored>,
    numbers: BTreeMap<Key, u16>,
    /// Data Type needs IDLE too (91).
    pub type_in_idle: bool,
    /// Whether the unit needs IDLE and no exchange; without, it can always be written (147).
    pub unit_in_idle: bool,
}

/// What one device has.
pub trait Particular: Debug {
    fn boxed(&self) -> Box<dyn Particular>;
    fn rule(&self, key: Key) -> Rule;
    /// COUNTS of a parameter.
    fn scale(&self, key: Key) -> Scale;
    /// Codes of the units.
    fn units(&self) -> &'static [(u16, Unit)];
    fn read(&self, _: &Common, key: Key) -> Content {
        unreachable!("{key:?} has a rule")
    }
    fn write(&mut self, _: &mut Common, key: Key, _: &[u8]) -> Verdict {
        unreachable!("{key:?} has a rule")
    }
    /// Octets for a write of an own parameter.
    fn suggest(&self, _: Key, length: usize, random: &mut Rng) -> Vec<u8> {
        (0..length).map(|_| random.u8(0..3)).collect()
    }
    /// Process data beside the parameter channel.
    fn suggest_process(&self, length: usize, _: &mut Rng) -> Vec<u8> {
        vec![0; length]
    }
    /// The process data beside the parameter channel; `None` is the safe state.
    fn process(&mut self, _: &mut Common, _: Option<&[u8]>) {}
    /// A state command besides 0 to 6.
    fn command(&mut self, _: &mut Common, _: u8) -> Verdict {
        Verdict::Refused(Reason::Range)
    }
    /// A refused write, which leaves no other trace than this.
    fn refused(&mut self, _: Key, _: &[u8]) {}
    fn settled(&mut self, _: &mut Common) {}
    /// A unit in the user parameters; `None` is none.
    fn unit_of(&self, user: &[u8]) -> Option<u16> {
        user.get(3..5).map(|it| u16::from_be_bytes([it[0], it[1]]))
    }
    /// The code of INIT in Device State.
    fn init_code(&self) -> u8 {
        0
    }
}

/// A device.
#[derive(Debug)]
pub struct Contents {
    pub common: Common,
    pub particular: Box<dyn Particular>,
}

impl Clone for Contents {
    fn clone(&self) -> Self {
        Self { common: self.common.clone(), particular: self.particular.boxed() }
    }
}

impl Common {
    /// As delivered: IDLE, float, mbar (73).
    pub fn new(torr: f64, top: u16) -> Self {
        Self {
            phase: Phase::Idle,
            exchange: false,
            execute: false,
            moving: false,
            unmeasured: false,
            restarted: false,
            form: Form { unit: Unit::Mbar, float: true, torr, top },
            pressures: BTreeMap::new(),
            numbers: BTreeMap::new(),
            type_in_idle: true,
            unit_in_idle: true,
        }
    }

    pub fn executing(&self) -> bool {
        self.phase == Phase::Executing
    }

    /// A stored number.
    pub fn number(&self, key: Key) -> Option<u16> {
        self.numbers.get(&key).copied()
    }

    pub fn set_number(&mut self, key: Key, number: u16) {
        self.numbers.insert(key, number);
    }

    /// A stored pressure in mbar.
    pub fn pressure(&self, key: Key) -> Option<f64> {
        self.pressures.get(&key).map(|it| it.mbar)
    }

    /// Replaces a stored pressure by a computed one.
    pub fn set_pressure(&mut self, key: Key, mbar: f64) {
        self.pressures.insert(key, Stored { mbar, written: None });
    }

    /// The device knows a stored pressure.
    pub fn forget_pressure(&mut self, key: Key) {
        self.pressures.remove(&key);
    }

    /// The octets of a pressure.
    pub fn show(&self, mbar: f64, scale: Scale) -> Content {
        Content::About(self.form.octets(self.form.number(mbar, scale)))
    }

    /// A stored pressure, or the one as delivered; without both the device knows.
    pub fn kept(&self, key: Key, factory: Option<f64>, scale: Scale) -> Content {
        match (self.pressures.get(&key), factory) {
            (Some(Stored { written: Some((form, octets)), .. }), _) if *form == self.form => {
                // A number near 0 has no digits in COUNTS, and 0 has two floats.
                let has_others = form.float && (form.unit == Unit::Counts || form.parse(octets) == Some(0.0));
                if has_others { Content::About(octets.clone()) } else { Content::Octets(octets.clone()) }
            }
            (Some(stored), _) => self.show(stored.mbar, scale),
            (None, Some(mbar)) => self.show(mbar, scale),
            (None, None) => Content::Device(2),
        }
    }

    /// Stores a written pressure. A number that is no pressure is refused, and what is no pressure is open.
    pub fn keep(&mut self, key: Key, octets: &[u8], scale: Scale) -> Verdict {
        let Some((mbar, verdict)) = self.evaluate(octets, scale) else { return Verdict::Refused(Reason::Range) };
        self.pressures.insert(key, Stored { mbar, written: Some((self.form, octets.to_vec())) });
        verdict
    }

    /// The pressure of octets, and whether it is accepted.
    pub fn evaluate(&self, octets: &[u8], scale: Scale) -> Option<(f64, Verdict)> {
        let number = self.form.parse(octets).filter(|it| it.is_finite())?;
        let mbar = self.form.mbar(number, scale);
        let logarithm = self.form.unit == Unit::Counts && matches!(scale, Scale::Logarithm { .. });
        let negative = number < 0.0 && !(logarithm && self.form.float);
        let vanishes = mbar == 0.0 && number != 0.0;
        let open = negative || vanishes || !(0.0..1e28).contains(&mbar);
        Some((mbar, if open { Verdict::Open(3) } else { Verdict::Done }))
    }

    /// Device Block State Command, 3.1.2.1 (84, 88, 89).
    fn command(&mut self, number: u8) -> Option<Verdict> {
        use Phase::{Abort, Executing, Idle, Init, SelfTest};
        let already = Verdict::Refused(Reason::Already);
        let not_now = Verdict::Refused(Reason::NotNow);
        let next = match (number, self.phase) {
            (0, _) => return Some(Verdict::Done),
            (1, _) => Init,
            // (89) says nothing about these states.
            (2..=6, Init | SelfTest) => return Some(Verdict::Open(4)),
            (2, Idle | Executing) => Abort,
            (2, Abort) => return Some(already),
            (3, Abort) => Idle,
            // (89): 201 is equally right.
            (3, Idle) => return Some(Verdict::Open(4)),
            (3, Executing) => return Some(not_now),
            (4, Idle) => Executing,
            (4, Executing) => return Some(already),
            (5, Executing) => Idle,
            (5, Idle) => return Some(already),
            (4 | 5, Abort) => return Some(not_now),
            (6, Idle | Executing) => SelfTest,
            (6, Abort) => return Some(not_now),
            _ => return None,
        };
        self.phase = next;
        self.execute = false;
        self.moving = true;
        self.unmeasured |= next == Executing;
        self.restarted |= matches!(next, Init | SelfTest);
        Some(Verdict::Done)
    }
}

impl Contents {
    pub fn new(common: Common, particular: impl Particular + 'static) -> Self {
        Self { common, particular: Box::new(particular) }
    }

    /// The length of a parameter whose type the configuration selects.
    pub const fn length(&self) -> usize {
        self.common.form.length()
    }

    /// What a read returns.
    pub fn read(&self, key: Key) -> Content {
        let common = &self.common;
        let scale = || self.particular.scale(key);
        let wide = |number: u16, word: bool| Content::Octets(number.to_be_bytes()[usize::from(!word)..].to_vec());
        match self.particular.rule(key) {
            Rule::Fixed(octets) => Content::Octets(octets.to_vec()),
            Rule::Text(text, length) => Content::Octets(format!("{text:<length$}").into_bytes()),
            Rule::Block(number) => Content::Octets([&number.to_be_bytes()[..], &[0, 0]].concat()),
            Rule::Command => Content::Octets(vec![0]),
            Rule::State => Content::Octets(vec![match common.phase {
                Phase::Init => self.particular.init_code(),
                Phase::SelfTest => 1,
                Phase::Idle => 2,
                Phase::Executing => 4,
                Phase::Abort => 5,
            }]),
            Rule::DataType | Rule::ShowsType => Content::Octets(vec![if common.form.float { 8 } else { 3 }]),
            Rule::DataUnit | Rule::ShowsUnit => {
                let (code, _) = self.particular.units().iter().find(|it| it.1 == common.form.unit).expect("a unit");
                wide(*code, *code > 0xFF)
            }
            // Key Lock is volatile.
            Rule::Within(..) if common.restarted && key == (0, 0, 203) => Content::Device(6),
            Rule::Within(_, to, factory) => match common.number(key).or(factory) {
                Some(number) => wide(number, to > 0xFF),
                None => Content::Device(2),
            },
            Rule::Limit(mbar) => common.show(mbar, scale()),
            Rule::Kept(factory) => common.kept(key, factory, scale()),
            Rule::Device(reason) => Content::Device(reason),
            Rule::Own => self.particular.read(common, key),
        }
    }

    /// What a write of the right length does.
    pub fn write(&mut self, key: Key, data: &[u8]) -> Verdict {
        let range = Verdict::Refused(Reason::Range);
        let word = data.iter().take(2).fold(0, |it, octet| it << 8 | u16::from(*octet));
        let common = &mut self.common;
        match self.particular.rule(key) {
            Rule::Command => match common.command(data[0]) {
                Some(verdict) => verdict,
                None => self.particular.command(common, data[0]),
            },
            Rule::DataType => {
                if common.exchange || (common.type_in_idle && common.phase != Phase::Idle) {
                    return Verdict::Refused(Reason::Mode);
                }
                match data {
                    [3] => common.form.float = false,
                    [8] => common.form.float = true,
                    _ => return range,
                }
                Verdict::Done
            }
            Rule::DataUnit => {
                if common.unit_in_idle && (common.exchange || common.phase != Phase::Idle) {
                    return Verdict::Refused(Reason::Mode);
                }
                let found = self.particular.units().iter().find(|it| it.0 == word);
                let Some((_, unit)) = found else { return range };
                common.form.unit = *unit;
                Verdict::Done
            }
            Rule::Within(from, to, _) if (from..=to).contains(&word) => {
                common.set_number(key, word);
                common.moving = true;
                Verdict::Done
            }
            Rule::Within(..) => range,
            Rule::Kept(_) => {
                common.moving = true;
                let scale = self.particular.scale(key);
                common.keep(key, data, scale)
            }
            Rule::Own => self.particular.write(common, key, data),
            other => unreachable!("{key:?} is {other:?}, which is not written"),
        }
    }

    /// Octets for a write.
    pub fn suggest(&self, key: Key, length: usize, random: &mut Rng) -> Vec<u8> {
        let one_of = |random: &mut Rng, of: &[u16]| of[random.usize(..of.len())];
        let number = match self.particular.rule(key) {
            Rule::Command => one_of(random, &[0, 1, 2, 3, 3, 4, 4, 4, 5, 5, 6, 7, 127, 200, 255]),
            Rule::DataType => one_of(random, &[3, 8, 3, 8, 0, 6]),
            Rule::DataUnit => {
                let units = self.particular.units();
                units[random.usize(..units.len())].0 ^ one_of(random, &[0, 0, 0, 0, 1, 0x20])
            }
            Rule::Within(from, to, _) => match random.u8(..4) {
                0 => random.u16(from..=to),
                1 => one_of(random, &[from, to]),
                2 => one_of(random, &[from.saturating_sub(1), to.saturating_add(1)]),
                _ => one_of(random, &[0, 0xFF, 0x7FFF, 0x8000, 0xFFFF]),
            },
            Rule::Kept(_) => return self.some_pressure(random),
            _ => return self.particular.suggest(key, length, random),
        };
        number.to_be_bytes()[2 - length.min(2)..].to_vec()
    }

    /// A number of the present form.
    pub fn some_pressure(&self, random: &mut Rng) -> Vec<u8> {
        if !self.common.form.float {
            let random = [random.u16(..), random.u16(..0x7FFF), 0, 0x7FFF, 0x8000, 21_500][random.usize(..6)];
            return random.to_be_bytes().to_vec();
        }
        let number = if random.u8(..8) == 0 {
            [0.0, -1.0, f32::NAN, f32::INFINITY, 1e38, -0.0, 1e-40, f32::MIN][random.usize(..8)]
        } else if self.common.form.unit == Unit::Counts {
            random.f32() * 40_000.0
        } else {
            10f32.powf(random.f32() * 16.0 - 10.0)
        };
        number.to_be_bytes().to_vec()
    }

    /// Accepted user parameters.
    pub fn set_prm(&mut self, user: &[u8]) {
        let code = self.particular.unit_of(user);
        if let Some((_, unit)) = self.particular.units().iter().find(|it| Some(it.0) == code) {
            self.common.form.unit = *unit;
        }
    }

    /// An accepted configuration.
    pub fn set_type(&mut self, float: Option<bool>) {
        self.common.form.float = float.unwrap_or(self.common.form.float);
    }

    /// Data_Exch begins: command 4 from IDLE (90).
    pub fn begin(&mut self) {
        let common = &mut self.common;
        common.moving = true;
        // open(18).
        if std::mem::replace(&mut common.exchange, true) {
            return;
        }
        match common.phase {
            Phase::Idle => (common.phase, common.unmeasured) = (Phase::Executing, true),
            Phase::Init | Phase::SelfTest => common.execute = true,
            _ => {}
        }
    }

    /// Data_Exch ends (90).
    pub fn end(&mut self) {
        let common = &mut self.common;
        (common.exchange, common.execute, common.moving) = (false, false, true);
        if common.executing() {
            common.phase = Phase::Idle;
        }
    }

    /// Time enough for everything that takes time.
    pub fn settle(&mut self) {
        let common = &mut self.common;
        common.moving = false;
        if matches!(common.phase, Phase::Init | Phase::SelfTest) {
            common.phase = if common.execute { Phase::Executing } else { Phase::Idle };
            common.execute = false;
        }
        common.unmeasured &= !common.executing();
        self.particular.settled(common);
    }
}
