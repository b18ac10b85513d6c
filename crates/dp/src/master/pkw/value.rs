//! The eight octets that the parameter channel carries each way. errata-bpg-bcg-tpg 17 to 24, errata-pxg55x-img400 1 to 12.
//!
//! | Octet | 1 | 2 | 3 | 4 | 5 to 8 |
//! |---|---|---|---|---|---|
//! | | AK in the high nibble | slot | index | 0 | value, right-aligned |

use core::fmt;

/// The number of octets of the channel each way.
pub(in crate::master) const OCTETS: usize = 8;

/// AK of a task.
const READ: u8 = 1;
const WRITE_WORD: u8 = 2;
const WRITE_DOUBLE_WORD: u8 = 3;

/// AK of an answer.
const NOTHING: u8 = 0;
const WORD: u8 = 1;
const DOUBLE_WORD: u8 = 2;
const REFUSED: u8 = 7;
const BYTE: u8 = 11;

/// A value, with its width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Value {
    /// One octet.
    Byte(u8),
    /// Two octets.
    Word(u16),
    /// Four octets: also floats, and arrays of three octets behind a zero (errata-bpg-bcg-tpg 20).
    DoubleWord(u32),
}

impl Value {
    /// The value of these octets, if there is a width for them.
    #[must_use]
    pub const fn from_octets(octets: &[u8]) -> Option<Self> {
        Some(match *octets {
            [d] => Self::Byte(d),
            [c, d] => Self::Word(u16::from_be_bytes([c, d])),
            [a, b, c, d] => Self::DoubleWord(u32::from_be_bytes([a, b, c, d])),
            _ => return None,
        })
    }

    /// The four octets of the channel, the value on the right.
    #[must_use]
    pub fn octets(self) -> [u8; 4] {
        match self {
            Self::Byte(value) => u32::from(value),
            Self::Word(value) => u32::from(value),
            Self::DoubleWord(value) => value,
        }
        .to_be_bytes()
    }

    /// The width of the value in octets.
    #[must_use]
    pub const fn width(self) -> usize {
        match self {
            Self::Byte(_) => 1,
            Self::Word(_) => 2,
            Self::DoubleWord(_) => 4,
        }
    }

    const fn answer_ak(self) -> u8 {
        match self {
            Self::Byte(_) => BYTE,
            Self::Word(_) => WORD,
            Self::DoubleWord(_) => DOUBLE_WORD,
        }
    }
}

/// The error number of a refused task (AK 7). Its meaning is in the manual of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorNumber(pub u16);

impl fmt::Display for ErrorNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error number {}", self.0)
    }
}

/// How an answer differs from the one that the task expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AnswerMismatch {
    /// No answer has this AK.
    Signature(u8),
    /// The answer names another parameter.
    Location {
        /// Slot and index of the task.
        expected: (u8, u8),
        /// Slot and index of the answer.
        received: (u8, u8),
    },
    /// The value has another width than the written or expected value.
    Width {
        /// The expected number of octets.
        expected: usize,
        /// The number of octets received.
        received: usize,
    },
    /// Octets that the answer does not use are not 0.
    Padding,
    /// The slave answered before the task was sent: it did not answer AK 0 with AK 0.
    Unrequested,
}

impl fmt::Display for AnswerMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Signature(ak) => write!(f, "the parameter channel answers with AK {ak}, which is no answer"),
            Self::Location { expected: (slot, index), received: (other_slot, other_index) } => {
                write!(f, "the parameter channel answers about {other_slot}/{other_index} instead of {slot}/{index}")
            }
            Self::Width { expected, received } => {
                write!(f, "the parameter channel answers with {received} octets instead of {expected}")
            }
            Self::Padding => f.write_str("the parameter channel answers with octets that should be 0"),
            Self::Unrequested => f.write_str("the parameter channel keeps answering without a request"),
        }
    }
}

/// A read or write of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Instruction {
    pub(super) slot: u8,
    pub(super) index: u8,
    /// The value to write; `None` reads.
    pub(super) write: Option<Value>,
    /// The width in octets that a value read must have, if known.
    pub(super) width: Option<usize>,
    /// AK of a write of one octet.
    pub(super) byte_ak: u8,
}

/// The answer of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Nothing,
    Value(Value),
    Refused(ErrorNumber),
}

impl core::error::Error for AnswerMismatch {}

impl Instruction {
    /// The octets of the task in the outputs.
    pub(super) fn octets(&self) -> [u8; OCTETS] {
        let ak = match self.write {
            None => READ,
            Some(Value::Byte(_)) => self.byte_ak,
            Some(Value::Word(_)) => WRITE_WORD,
            Some(Value::DoubleWord(_)) => WRITE_DOUBLE_WORD,
        };
        let [a, b, c, d] = self.write.map_or([0; 4], Value::octets);
        [ak << 4, self.slot, self.index, 0, a, b, c, d]
    }

    /// The answer in the octets of the inputs.
    pub(super) fn answer(&self, [pke, slot, index, _, value @ ..]: [u8; OCTETS]) -> Result<Answer, AnswerMismatch> {
        let ak = pke >> 4;
        if ak == NOTHING {
            return Ok(Answer::Nothing);
        }
        let (expected, received) = ((self.slot, self.index), (slot, index));
        if expected != received {
            return Err(AnswerMismatch::Location { expected, received });
        }
        match (ak, value) {
            (REFUSED, [0, 0, high, low]) => Ok(Answer::Refused(ErrorNumber(u16::from_be_bytes([high, low])))),
            (BYTE, [0, 0, 0, d]) => self.checked(Value::Byte(d)),
            (WORD, [0, 0, c, d]) => self.checked(Value::Word(u16::from_be_bytes([c, d]))),
            (DOUBLE_WORD, octets) => self.checked(Value::DoubleWord(u32::from_be_bytes(octets))),
            (REFUSED | BYTE | WORD, _) => Err(AnswerMismatch::Padding),
            (other, _) => Err(AnswerMismatch::Signature(other)),
        }
    }

    fn checked(&self, value: Value) -> Result<Answer, AnswerMismatch> {
        let expected = match self.write {
            Some(written) if written.answer_ak() == value.answer_ak() => return Ok(Answer::Value(value)),
            // Where a byte is written as a word, the answer is as wide as the parameter: errata-bpg-bcg-tpg 133.
            Some(Value::Word(_)) if self.byte_ak == WRITE_WORD && value.width() == 1 => {
                return Ok(Answer::Value(value));
            }
            Some(written) => written.width(),
            None => match self.width {
                Some(width) if width != value.width() => width,
                _ => return Ok(Answer::Value(value)),
            },
        };
        Err(AnswerMismatch::Width { expected, received: value.width() })
    }
}

/// Whether the channel carries no answer (AK 0).
pub(super) const fn is_rest(octets: &[u8; OCTETS]) -> bool {
    let [pke, ..] = octets;
    *pke >> 4 == NOTHING
}
