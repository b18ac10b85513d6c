//! What the numbers of a parameter mean: the code tables of the manuals, for whoever shows a value by its name, sends a
//! command by its name, or checks a value before it is sent.

/// What the numbers of a parameter mean.
#[derive(Debug, PartialEq)]
pub enum Codes {
    /// Just numbers.
    Plain,
    /// Numbers from one to another.
    Range(i64, i64),
    /// Each number has a name.
    Names(&'static [Code]),
    /// Each number is a command: carried out, never kept.
    Commands(&'static [Code]),
    /// Each bit has a name.
    Bits(&'static [(u8, &'static str)]),
    /// The code of a pressure unit: [`Model::units`](super::Model::units).
    Units,
    /// Commands, one for each bit.
    BitCommands(&'static [Code]),
}

/// A number with a name.
#[derive(Debug, PartialEq)]
pub struct Code {
    /// The number; of a command record the command in the high octet and its value in the low one.
    pub number: u16,
    /// The manual's name, in lower case.
    pub name: &'static str,
    /// What must be the case when it is written.
    pub preconditions: &'static [Precondition],
    /// What may go wrong when it is written at the wrong time. Empty if it is harmless.
    pub risk: &'static str,
}

/// What must be the case before a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Precondition {
    /// Device State is EXECUTING.
    Executing,
    /// The emission of the same part is on.
    EmissionOn,
    /// The Process Value of this instance, or else of the same part, is below so many Pa.
    PressureBelow(Option<u8>, f64),
}

/// A number that has a name and nothing else.
#[must_use]
pub const fn code(number: u16, name: &'static str) -> Code {
    Code { number, name, preconditions: &[], risk: "" }
}

impl Codes {
    /// The numbers with names.
    #[must_use]
    pub const fn codes(&self) -> &'static [Code] {
        match self {
            Self::Names(codes) | Self::Commands(codes) | Self::BitCommands(codes) => codes,
            Self::Plain | Self::Range(..) | Self::Bits(_) | Self::Units => &[],
        }
    }

    /// The code with this number.
    #[must_use]
    pub fn code(&self, number: i64) -> Option<&'static Code> {
        self.codes().iter().find(|code| i64::from(code.number) == number)
    }

    /// Whether writing it is an order and not a value.
    #[must_use]
    pub const fn is_command(&self) -> bool {
        matches!(self, Self::Commands(_) | Self::BitCommands(_))
    }
}

/// The codes of a row, which not every row has.
macro_rules! codes {
    () => {
        $crate::model::Codes::Plain
    };
    ($codes:ident) => {
        $codes
    };
}

pub(crate) use codes;
