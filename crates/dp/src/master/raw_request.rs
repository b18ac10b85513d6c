//! The raw request: one request of the user beside the cycle.

use crate::link::active::{Answer, Confirmation, Failure, Request};
use core::fmt;
use profivac_wire::MAX_TELEGRAM;
use profivac_wire::control::{Function, StationType, Status};

/// The slot is in use: the previous request is not finished, or its confirmation was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Busy;

impl fmt::Display for Busy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the request before is not finished")
    }
}

impl core::error::Error for Busy {}

/// The slot for a request and then its confirmation. `octets` holds the data unit of the request or of the answer.
#[derive(Clone, Debug)]
pub(super) struct RawRequest {
    stage: Stage,
    octets: [u8; MAX_TELEGRAM],
    length: usize,
}

/// The stage of the request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Free,
    Waiting(Header),
    Sent,
    Answered { station: StationType, status: Status, repetitions: u8 },
    Unconfirmed,
    Failed(Failure),
}

/// A request without its data unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Header {
    da: u8,
    function: Function,
    dsap: Option<u8>,
    ssap: Option<u8>,
}

impl RawRequest {
    pub(super) const fn new() -> Self {
        Self { stage: Stage::Free, octets: [0; MAX_TELEGRAM], length: 0 }
    }

    pub(super) fn submit(&mut self, request: &Request<'_>) -> Result<(), Busy> {
        if self.stage != Stage::Free {
            return Err(Busy);
        }
        let &Request { da, function, dsap, ssap, du } = request;
        self.stage = if self.store(du) {
            Stage::Waiting(Header { da, function, dsap, ssap })
        } else {
            Stage::Failed(Failure::Impossible)
        };
        Ok(())
    }

    /// Whether a request waits to be sent.
    pub(super) const fn is_waiting(&self) -> bool {
        matches!(self.stage, Stage::Waiting(_))
    }

    /// Takes the request to send it now.
    pub(super) fn start(&mut self) -> Option<Request<'_>> {
        let Stage::Waiting(Header { da, function, dsap, ssap }) = self.stage else { return None };
        self.stage = Stage::Sent;
        Some(Request { da, function, dsap, ssap, du: self.du() })
    }

    pub(super) fn finish(&mut self, confirmation: Confirmation<'_>) {
        self.stage = match confirmation {
            Confirmation::Sent => Stage::Unconfirmed,
            Confirmation::Failed(failure) => Stage::Failed(failure),
            Confirmation::Answer(Answer { station, status, du, repetitions }) => {
                self.store(du);
                Stage::Answered { station, status, repetitions }
            }
        };
    }

    /// Takes the confirmation, which frees the slot.
    pub(super) fn take(&mut self) -> Option<Confirmation<'_>> {
        match core::mem::replace(&mut self.stage, Stage::Free) {
            stage @ (Stage::Free | Stage::Waiting(_) | Stage::Sent) => {
                self.stage = stage;
                None
            }
            Stage::Answered { station, status, repetitions } => {
                Some(Confirmation::Answer(Answer { station, status, du: self.du(), repetitions }))
            }
            Stage::Unconfirmed => Some(Confirmation::Sent),
            Stage::Failed(failure) => Some(Confirmation::Failed(failure)),
        }
    }

    fn du(&self) -> &[u8] {
        self.octets.get(..self.length).unwrap_or_default()
    }

    fn store(&mut self, du: &[u8]) -> bool {
        let Some(front) = self.octets.get_mut(..du.len()) else { return false };
        front.copy_from_slice(du);
        self.length = du.len();
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::services;
    use super::*;

    #[test]
    fn the_slot_holds_one_request_until_its_result_is_taken() {
        let mut request = RawRequest::new();
        assert_eq!(request.submit(&services::slave_diag(8)), Ok(()));
        assert_eq!(request.submit(&services::get_cfg(8)), Err(Busy));
        assert_eq!(request.take(), None);
        assert_eq!(request.start(), Some(services::slave_diag(8)));
        assert_eq!(request.start(), None);
        let answer = Answer { station: StationType::Slave, status: Status::DataLow, du: &[1, 2, 3], repetitions: 1 };
        request.finish(Confirmation::Answer(answer));
        assert_eq!(request.submit(&services::get_cfg(8)), Err(Busy));
        assert_eq!(request.take(), Some(Confirmation::Answer(answer)));
        assert_eq!(request.take(), None);
        assert_eq!(request.submit(&services::get_cfg(8)), Ok(()));
    }

    #[test]
    fn a_data_unit_that_no_telegram_can_carry_fails_at_once() {
        let mut request = RawRequest::new();
        assert_eq!(request.submit(&services::set_slave_add(8, &[0; 300])), Ok(()));
        assert_eq!(request.take(), Some(Confirmation::Failed(Failure::Impossible)));
    }
}
