//! The request whose wait a cancellation has ended. The master accepts the next one to the slave after its outcome was taken.

use super::{Ms2Error, Ms2Line};
use profivac_dp::master::{Handle, Operation, SubmitError};
use profivac_host::session::BusMaster;
use std::time::Instant;

/// Takes the outcome of one request from the master. Returns false while there is none.
type TakeOutcome = Box<dyn Fn(&mut BusMaster) -> bool + Send>;

/// A request that was given up and has no outcome yet, if there is one.
pub(crate) struct Abandoned(Option<TakeOutcome>);

impl Abandoned {
    /// No request was given up.
    pub const NONE: Self = Self(None);

    /// Serves the line until the request of `handle` has an outcome, and keeps the request if the wait ends earlier.
    ///
    /// # Errors
    /// [`Ms2Error::Session`] or [`Ms2Error::NoAnswer`].
    pub fn wait_for<O: Operation + 'static, T>(
        &mut self,
        line: &mut impl Ms2Line,
        handle: Handle<O>,
        take: impl FnOnce(O::Outcome<'_>) -> T,
    ) -> Result<T, Ms2Error> {
        let outcome = line.wait_for(handle, take);
        if outcome.is_err() {
            self.0 = Some(Box::new(move |master| master.outcome(handle).is_some()));
        }
        outcome
    }

    /// Waits for the end of a request that was given up, and drops its outcome.
    ///
    /// # Errors
    /// [`Ms2Error::Session`], or [`SubmitError::Busy`] if the request has no outcome in time.
    pub fn finish(&mut self, line: &mut impl Ms2Line) -> Result<(), Ms2Error> {
        let begun = Instant::now();
        while let Some(take) = &self.0 {
            if take(line.master()) {
                self.0 = None;
            } else if !line.wait_while_busy(begun)? {
                return Err(SubmitError::Busy.into());
            }
        }
        Ok(())
    }
}
