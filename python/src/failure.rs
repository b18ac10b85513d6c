//! Errors with the exit code of the program, and the exceptions they become.

use profivac_client::discover::CyclicError;
use profivac_client::records::WriteEffect;
use profivac_client::settings::SettingsFileError;
use profivac_client::{ClientError, ErrorKind};
use pyo3::prelude::*;

mod exceptions {
    pyo3::import_exception!(profivac._errors, Connection);
    pyo3::import_exception!(profivac._errors, Refused);
    pyo3::import_exception!(profivac._errors, Usage);
}

/// A request that failed: its class and a sentence.
#[derive(Clone, Debug)]
pub struct Failure {
    kind: ErrorKind,
    sentence: String,
    /// The effect of a write that failed.
    effect: Option<WriteEffect>,
}

impl Failure {
    /// The request makes no sense: exit code 2.
    pub fn usage(sentence: impl ToString) -> Self {
        Self { kind: ErrorKind::Usage, sentence: sentence.to_string(), effect: None }
    }

    /// The device refuses, or would refuse: exit code 1.
    pub fn refused(sentence: impl ToString) -> Self {
        Self { kind: ErrorKind::Refused, sentence: sentence.to_string(), effect: None }
    }

    /// No line, or no answer: exit code 3.
    pub fn line(sentence: impl ToString) -> Self {
        Self { kind: ErrorKind::Line, sentence: sentence.to_string(), effect: None }
    }

    /// A write that failed. The exception has its effect as `effect`.
    pub fn of_write(error: ClientError) -> Self {
        let effect = Some(error.write_effect());
        Self { effect, ..error.into() }
    }

    /// The error of a settings file.
    pub fn of_file(error: &SettingsFileError) -> Self {
        Self::usage(error)
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        let advice = match error {
            ClientError::NoAnswer(_) => "; Bus.scan() shows the stations of the bus",
            ClientError::BeyondRange { .. } => "; to write it all the same pass force=True",
            ClientError::Target(_) => "; Gauge.parameters and Gauge.commands list the names",
            ClientError::Closed => "; open the bus again",
            _ => "",
        };
        Self { kind: error.kind(), sentence: format!("{error}{advice}"), effect: None }
    }
}

impl From<CyclicError> for Failure {
    fn from(error: CyclicError) -> Self {
        match error {
            CyclicError::Session(error) => ClientError::from(error).into(),
            CyclicError::NoAnswer(address) => ClientError::NoAnswer(address).into(),
            CyclicError::Client(error) => error.into(),
            error => Self { kind: error.kind(), sentence: error.to_string(), effect: None },
        }
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let Failure { kind, sentence, effect } = failure;
        let error = match kind {
            ErrorKind::Refused => exceptions::Refused::new_err(sentence),
            ErrorKind::Usage => exceptions::Usage::new_err(sentence),
            ErrorKind::Line => exceptions::Connection::new_err(sentence),
        };
        if let Some(effect) = effect {
            Python::attach(|py| error.value(py).setattr("effect", effect.name())).ok();
        }
        error
    }
}
