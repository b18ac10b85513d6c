//! Code tables: the numbers of a parameter that have names in the manual. A client shows a value by its name, sends a
//! command by its name, and checks a value before it sends it.
//!
//! `codes!` in `code_table` makes the table of a row together with an enum of its codes.

/// The meaning of the numbers of a parameter.
#[derive(Debug, PartialEq)]
pub enum Codes {
    /// A number without further meaning.
    Plain,
    /// A number within these bounds, both included.
    Range(i64, i64),
    /// Tenths of a percent within these bounds, both included: 500 is 50 %.
    PerMille(i64, i64),
    /// A number in a unit of its own, which is no pressure unit of the device.
    Quantity(Quantity),
    /// Each number has a name.
    Names(&'static [Code]),
    /// Each number is a command: the device executes it and does not keep it.
    Commands(&'static [Code]),
    /// Each bit has a name.
    Bits(&'static [(u8, &'static str)]),
    /// The code of a pressure unit: [`Model::units`](super::Model::units).
    Units,
    /// Commands, one for each bit.
    BitCommands(&'static [Code]),
    /// A nibble for each of six digits, a zero for a hyphen, and one for a letter: 50973101h is `509731-A`.
    Version,
}

/// A number in a unit: a speed, a flow, a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// The unit.
    pub unit: &'static str,
    /// One step of the number in the record, in this unit.
    pub factor: f64,
    /// The lowest and the highest number in the record, if the manual limits it.
    pub range: Option<(i64, i64)>,
}

/// A number with a name.
#[derive(Debug, PartialEq)]
pub struct Code {
    /// The number; of a command record the command in the high octet and its value in the low one.
    pub number: u16,
    /// The manual's name, in lower case.
    pub name: &'static str,
    /// The conditions under which it may be written.
    pub preconditions: &'static [Precondition],
    /// The damage it can do when it is written at the wrong time. Empty if it is harmless.
    pub risk: &'static str,
}

/// A condition that must hold before a command is sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Precondition {
    /// Device State is EXECUTING.
    Executing,
    /// The emission of the same part is on.
    EmissionOn,
    /// Degas Status of the same part is off.
    DegasOff,
    /// The Process Value of this instance, or of the same part if `None`, is below this pressure in Pa.
    PressureBelow(Option<u8>, f64),
    /// The Process Value of this instance, or of the same part if `None`, is above this pressure in Pa.
    PressureAbove(Option<u8>, f64),
    /// The Process Value of the same part is below this part of its Full Scale.
    BelowPartOfFullScale(f64),
}

/// A code with a number and a name, without conditions and harmless.
#[must_use]
pub const fn code(number: u16, name: &'static str) -> Code {
    Code { number, name, preconditions: &[], risk: "" }
}

impl Codes {
    /// The numbers with names; empty for tables without them.
    #[must_use]
    pub const fn codes(&self) -> &'static [Code] {
        match self {
            Self::Names(codes) | Self::Commands(codes) | Self::BitCommands(codes) => codes,
            Self::Plain
            | Self::Range(..)
            | Self::PerMille(..)
            | Self::Quantity(_)
            | Self::Bits(_)
            | Self::Units
            | Self::Version => &[],
        }
    }

    /// The code with this number.
    #[must_use]
    pub fn code(&self, number: i64) -> Option<&'static Code> {
        self.codes().iter().find(|code| i64::from(code.number) == number)
    }

    /// Whether writing it is a command and not a value.
    #[must_use]
    pub const fn is_command(&self) -> bool {
        matches!(self, Self::Commands(_) | Self::BitCommands(_))
    }
}
