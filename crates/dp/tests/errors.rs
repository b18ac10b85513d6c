//! Every error type of the crate is an error for callers: it has a text and works with `?`.

use profivac_dp::link::active::{Failure, Mismatch, OutOfRange};
use profivac_dp::master::{
    Busy, Cause, ConnectionEnd, ControlError, ExchangeError, ResponseMismatch, SlaveListError, SubmitError, ms1, ms2,
    pkw, services,
};
use profivac_dp::slave::{CfgFault, Dpv1Error, PrmFault};
use std::error::Error;

/// The compiler checks the list; an error type without the trait ends the build.
#[test]
fn every_error_type_implements_error() {
    fn is_error<E: Error + Send + Sync + 'static>() {}
    is_error::<PrmFault>();
    is_error::<CfgFault>();
    is_error::<Dpv1Error>();
    is_error::<OutOfRange>();
    is_error::<Failure>();
    is_error::<Mismatch>();
    is_error::<Busy>();
    is_error::<ControlError>();
    is_error::<SlaveListError>();
    is_error::<SubmitError>();
    is_error::<ms1::RequestError>();
    is_error::<ms2::RequestError>();
    is_error::<pkw::TaskError>();
    is_error::<pkw::AnswerMismatch>();
    is_error::<services::ServiceError>();
    is_error::<ConnectionEnd>();
    is_error::<Cause>();
    is_error::<ExchangeError>();
    is_error::<ResponseMismatch>();
}

#[test]
fn the_errors_of_a_device_have_a_text() {
    assert_eq!(PrmFault.to_string(), "the device does not accept the user parameters");
    assert_eq!(CfgFault.to_string(), "the device does not have this configuration");
    assert!(Dpv1Error::INVALID_INDEX.with(3).to_string().ends_with("error code 2 is 3"));
}
