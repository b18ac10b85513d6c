//! Records of a slave, independent of the service that reads and writes them.

use crate::values::Value;
use profivac_devices::model::{AccessPath, DataType, LengthError};
use profivac_dp::master::{ConnectionEnd, ExchangeError, SlaveListError, SubmitError, ms1, pkw};
use profivac_host::session::SessionError;
use profivac_wire::acyclic::{ErrorCode, Negative};
use std::fmt;

/// Reads and writes the records of one slave.
///
/// [`Ms2`](crate::ms2::Ms2) and [`Class1Session`](crate::class1::Class1Session) implement it; a test may implement it without a
/// bus.
///
/// ```
/// use profivac_client::Gauge;
/// use profivac_client::records::{RecordError, Records};
/// use profivac_devices::catalog::model_named;
/// use profivac_devices::model::AccessPath;
///
/// /// A gauge in EXECUTING that has no other records.
/// struct Executing;
///
/// impl Records for Executing {
///     fn via(&self) -> AccessPath {
///         AccessPath::Class2
///     }
///
///     fn read(&mut self, _slot: u8, _index: u8) -> Result<Vec<u8>, RecordError> {
///         Ok(vec![4])
///     }
///
///     fn write(&mut self, _slot: u8, _index: u8, _octets: &[u8]) -> Result<(), RecordError> {
///         Ok(())
///     }
/// }
///
/// let mut gauge = Gauge::with_model(Executing, 5, model_named("bcg450").ok_or("no such model")?);
/// assert_eq!(gauge.read("device.device-state")?.text, "EXECUTING");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Records {
    /// The service that carries the records.
    fn via(&self) -> AccessPath;

    /// Reads a record.
    ///
    /// # Errors
    /// [`RecordError`] tells a refusal of the slave from a lost answer.
    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError>;

    /// Writes a record. `Ok` means that the slave has accepted it.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError>;

    /// Keeps a temporary change that could not be undone, for the next [`Gauge`](crate::Gauge) at this address.
    ///
    /// The default forgets it. Implementations on a bus store it in the bus session.
    fn keep_unrestored(&mut self, _record: UnrestoredRecord) {}

    /// Takes the record that [`keep_unrestored`](Self::keep_unrestored) stored.
    fn take_unrestored(&mut self) -> Option<UnrestoredRecord> {
        None
    }

    /// While this is true, a guard restores what it has changed: see
    /// [`BusSession::set_restoring`](profivac_host::session::BusSession::set_restoring).
    fn set_restoring(&mut self, _is_restoring: bool) {}
}

pub use profivac_host::session::UnrestoredRecord;

impl<R: Records + ?Sized> Records for Box<R> {
    fn via(&self) -> AccessPath {
        (**self).via()
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        (**self).read(slot, index)
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        (**self).write(slot, index, octets)
    }

    fn keep_unrestored(&mut self, record: UnrestoredRecord) {
        (**self).keep_unrestored(record);
    }

    fn take_unrestored(&mut self) -> Option<UnrestoredRecord> {
        (**self).take_unrestored()
    }

    fn set_restoring(&mut self, is_restoring: bool) {
        (**self).set_restoring(is_restoring);
    }
}

/// The reason why a record was not read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The bus session failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The bus session failed before the request was sent.
    #[error(transparent)]
    NotSent(SessionError),
    /// The slave refused.
    #[error("{0}")]
    Refused(RefusalCodes),
    /// The slave does not offer this service, or not for this record.
    #[error(transparent)]
    Unavailable(#[from] Unavailable),
    /// No usable answer arrived.
    #[error(transparent)]
    Interrupted(#[from] Interruption),
    /// The slave answered with a record that is no value of the parameter.
    #[error(transparent)]
    Malformed(#[from] LengthError),
}

/// The class of an error, as exit codes tell them apart.
///
/// ```
/// # use profivac_client::{Bus, ErrorKind};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let kind = |error: profivac_client::ClientError| error.kind();
/// assert_eq!(bus.gauge(5)?.write("pirani.safe-value", "much").map_err(kind).unwrap_err(), ErrorKind::Usage);
/// assert_eq!(bus.gauge(5)?.command("degas on").map_err(kind).unwrap_err(), ErrorKind::Refused);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The device refused, or would refuse.
    Refused,
    /// The request makes no sense for this device.
    Usage,
    /// No answer, or no line.
    Line,
}

impl RecordError {
    /// The class of the error: [`ErrorKind::Line`] without an answer, [`ErrorKind::Refused`] with one.
    ///
    /// ```
    /// use profivac_client::ErrorKind;
    /// use profivac_client::records::{Interruption, RecordError, Unavailable};
    ///
    /// assert_eq!(RecordError::from(Interruption::NoAnswer).kind(), ErrorKind::Line);
    /// assert_eq!(RecordError::from(Unavailable::NoMs1).kind(), ErrorKind::Refused);
    /// ```
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::Session(SessionError::Parameters(_)) | Self::NotSent(SessionError::Parameters(_)) => ErrorKind::Usage,
            // The device has answered.
            Self::Interrupted(Interruption::UnknownUnit) => ErrorKind::Refused,
            Self::Session(_) | Self::NotSent(_) | Self::Interrupted(_) => ErrorKind::Line,
            Self::Refused(_) | Self::Unavailable(_) | Self::Malformed(_) => ErrorKind::Refused,
        }
    }

    /// The effect of a write that ended with this error.
    ///
    /// ```
    /// use profivac_client::records::{Interruption, RecordError, Unavailable, WriteEffect};
    ///
    /// assert_eq!(RecordError::from(Interruption::NoAnswer).write_effect(), WriteEffect::PossiblyExecuted);
    /// assert_eq!(RecordError::from(Unavailable::NoConnection).write_effect(), WriteEffect::NotSent);
    /// ```
    #[must_use]
    pub const fn write_effect(&self) -> WriteEffect {
        match self {
            Self::Session(_) | Self::Malformed(_) => WriteEffect::PossiblyExecuted,
            Self::NotSent(_) | Self::Unavailable(_) => WriteEffect::NotSent,
            Self::Refused(_) => WriteEffect::Refused,
            Self::Interrupted(reason) => reason.write_effect(),
        }
    }
}

/// The effect of a write that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteEffect {
    /// The device does not have the value: it was not sent, or the device did not take the telegram.
    NotSent,
    /// The device has refused the value.
    Refused,
    /// The device may have the value: its answer was lost.
    PossiblyExecuted,
    /// The device has accepted the value, and reading it back failed.
    Executed,
}

impl WriteEffect {
    /// The word of the JSON output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotSent => "not-sent",
            Self::Refused => "refused",
            Self::PossiblyExecuted => "possibly-executed",
            Self::Executed => "executed",
        }
    }
}

/// Reads a record as a value of this type.
pub(crate) fn read_value(
    records: &mut impl Records,
    (slot, index): (u8, u8),
    data_type: DataType,
) -> Result<Value, RecordError> {
    Ok(Value::decode(data_type, &records.read(slot, index)?)?)
}

/// Reads a record as an unsigned integer of this type. A number beyond 16 bits is none of a code table.
pub(crate) fn read_code(
    records: &mut impl Records,
    location: (u8, u8),
    data_type: DataType,
) -> Result<Option<u16>, RecordError> {
    let value = read_value(records, location, data_type)?;
    Ok(if let Value::Integer(code) = value { u16::try_from(code).ok() } else { None })
}

/// The reason why a service cannot be used with a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unavailable {
    /// The device has no DP-V1 services.
    #[error("it has no DP-V1 services")]
    NoDpv1,
    /// The device has no MS1.
    #[error("it has no MS1")]
    NoMs1,
    /// No configuration of the device has a parameter channel.
    #[error("no configuration of it has a parameter channel")]
    NoParameterChannel,
    /// The parameter channel carries 1, 2 or 4 octets.
    #[error("the parameter channel carries 1, 2 or 4 octets")]
    TooLongForChannel,
    /// The slave has closed the access point of the resource manager, or all connections are in use. The master has searched for one
    /// that an earlier program with its station address has left: [`profivac_dp::master::ms2`]. The slave closes one of another address
    /// after 2 T without a request and T in which its Abort waits for a poll (profibus-wire 4.9), with the T of 5 s that this client asks
    /// for.
    #[error(
        "it has no MS2 connection, or none left: other class 2 masters may hold them, or a program with another station address that ended without closing its own: wait 15 s and try again; a connection of another program may last longer"
    )]
    NoConnection,
    /// The slave refused the connection.
    #[error("{0}")]
    ConnectionRefused(ConnectionEnd),
    /// The master cannot have a slave with these parameters.
    #[error("{0}")]
    Parameters(SlaveListError),
    /// The slave refuses to exchange data.
    #[error("the gauge does not exchange data: {0}")]
    NoExchange(ExchangeError),
    /// None of the parameters can be read by this service.
    #[error("no parameter of it can be read by this service")]
    NothingReadable,
    /// Another master moves the Channel Instance Selector between two requests.
    #[error("another master also changes the Channel Instance Selector; read again when it has finished")]
    SelectorContention,
    /// Another master changes the unit between two requests.
    #[error("another master also changes the unit; read again when it has finished")]
    UnitContention,
}

/// The reason why no usable answer arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Interruption {
    /// The connection ended, and the slave may have executed the request.
    #[error("{0}")]
    Ended(ConnectionEnd),
    /// The connection could not be opened or ended, and the slave has not executed the request.
    #[error("{0}")]
    NotExecuted(ConnectionEnd),
    /// The MS1 request failed.
    #[error("{0}")]
    Ms1(ms1::RequestError),
    /// The task in the parameter channel failed.
    #[error("{0}")]
    ParameterChannel(pkw::TaskError),
    /// The master did not accept the request.
    #[error("{0}")]
    NotSubmitted(SubmitError),
    /// No answer arrived in time.
    #[error("no answer")]
    NoAnswer,
    /// The connection that was kept between requests has ended.
    #[error("the connection that was kept has ended, as after a power failure of the gauge; repeat the request")]
    KeptConnectionEnded,
    /// The slave did not exchange data in time.
    #[error("the gauge does not exchange data: {}", exchange_reason(.0))]
    NoExchange(Option<ExchangeError>),
    /// The unit code is in no table of the device.
    #[error("the gauge reports a unit that its table does not have")]
    UnknownUnit,
}

impl Interruption {
    /// The effect of a write that was interrupted.
    pub(crate) const fn write_effect(&self) -> WriteEffect {
        match self {
            Self::Ended(_) | Self::NoAnswer => WriteEffect::PossiblyExecuted,
            Self::Ms1(error) => match error {
                ms1::RequestError::NotExecuted(_) | ms1::RequestError::NotSent => WriteEffect::NotSent,
                _ => WriteEffect::PossiblyExecuted,
            },
            Self::ParameterChannel(error) => match error {
                // The slave still answered an earlier task, so the master has not sent this one.
                pkw::TaskError::Mismatch(pkw::AnswerMismatch::Unrequested) => WriteEffect::NotSent,
                _ => WriteEffect::PossiblyExecuted,
            },
            Self::NotExecuted(_)
            | Self::NotSubmitted(_)
            | Self::KeptConnectionEnded
            | Self::NoExchange(_)
            | Self::UnknownUnit => WriteEffect::NotSent,
        }
    }
}

fn exchange_reason(error: &Option<ExchangeError>) -> String {
    error.map_or_else(|| "it was not asked long enough".to_owned(), |error| error.to_string())
}

/// The error codes of a refusal.
///
/// ```
/// use profivac_client::records::RefusalCodes;
///
/// let refused = RefusalCodes { code_1: None, code: RefusalCodes::MODE };
/// assert_eq!(refused.to_string(), "code 17: instruction not allowed in this state");
/// assert_eq!(refused.text(), "instruction not allowed in this state");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefusalCodes {
    /// Error_Code_1 of DP-V1. The parameter channel has none.
    pub code_1: Option<ErrorCode>,
    /// The manual's own code: that of the parameter channel, and Error_Code_2 of DP-V1.
    pub code: u8,
}

/// The codes of the parameter channel as the manuals word them: tira41d1 2.2.1.1, tira56e1 4.3.3, i9973ber/a 3.2.2.1.
const CODES: [(u8, &str); 19] = [
    (0, "undefined slot"),
    (1, "parameter not changeable"),
    (2, "lower or upper value range limit overflow"),
    (3, "index error"),
    (4, "no array"),
    (5, "data type error"),
    (6, "setting not allowed, only resetting"),
    (7, "description element not changeable"),
    (10, "access group error"),
    (11, "no operation sovereignty"),
    (12, "password error"),
    (13, "a text cannot be read this way"),
    (14, "a name cannot be read this way"),
    (15, "no text array"),
    (17, "instruction not allowed in this state"),
    (18, "other errors"),
    (19, "data cannot be read this way"),
    (201, "object state conflict: already in the requested state"),
    (202, "object state conflict: not possible in the present state"),
];

impl RefusalCodes {
    /// Already in the requested state.
    pub const ALREADY: u8 = 201;
    /// Not possible in this state.
    pub const CONFLICT: u8 = 202;
    /// Not allowed in this operating mode.
    pub const MODE: u8 = 17;
    /// Outside the range.
    pub const RANGE: u8 = 2;

    /// The code in the words of the manual.
    #[must_use]
    pub fn text(&self) -> &'static str {
        CODES
            .into_iter()
            .find(|(code, _)| *code == self.code)
            .map_or("a code the manual does not have", |(_, text)| text)
    }
}

impl fmt::Display for RefusalCodes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.code_1, self.code) {
            // Error_Code_2 may be 0 without a meaning.
            (Some(code_1), 0) if code_1 != ErrorCode::INVALID_SLOT => write!(f, "{code_1}"),
            (Some(code_1), code) => write!(f, "{code_1}, code {code}: {}", self.text()),
            (None, code) => write!(f, "code {code}: {}", self.text()),
        }
    }
}

impl From<Negative> for RefusalCodes {
    fn from(negative: Negative) -> Self {
        Self { code_1: Some(negative.code_1), code: negative.code_2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_displayed_in_the_words_of_the_manual() {
        let refused = |code_1, code| RefusalCodes { code_1, code }.to_string();
        assert_eq!(
            refused(Some(ErrorCode::STATE_CONFLICT), 17),
            "state conflict (B5), code 17: instruction not allowed in this state"
        );
        assert_eq!(refused(None, 3), "code 3: index error");
        assert_eq!(refused(Some(ErrorCode::INVALID_SLOT), 0), "invalid slot (B2), code 0: undefined slot");
        assert_eq!(refused(Some(ErrorCode::READ_ERROR), 0), "read error (A0)");
        assert_eq!(refused(None, 12), "code 12: password error");
        assert_eq!(refused(None, 99), "code 99: a code the manual does not have");
    }
}
