//! MS1: read and write by the master that owns the slave. profibus-wire 4.2 and 4.3.

use super::{NO_RESOURCE, SERVICE_CLOSED, Server, prepared};
use crate::link::{Indication, Reply};
use crate::slave::{Device, Dpv1Error, Fault, Relation, SlaveState};
use profivac_wire::acyclic::{Function, PduError, Request, Response};

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    /// Whether MS1 is open: during data exchange, if Set_Prm enabled DP-V1 and the device has MS1; to the owner only, from
    /// any source access point.
    fn ms1_is_open_to(&self, sa: u8) -> bool {
        let SlaveState::DataExch(owner, _) = &self.state else { return false };
        owner.master == sa && owner.dpv1 && self.device.features().ms1
    }

    /// SAP 51.
    #[inline]
    pub(super) fn ms1(&mut self, request: &Indication<'_>) -> Reply<'_> {
        if !self.ms1_is_open_to(request.sa) {
            return SERVICE_CLOSED;
        }
        if request.du.is_empty() {
            return self.ms1.fetch(&mut self.device, Relation::Ms1, &mut self.du);
        }
        if self.ms1.is_occupied() {
            // profibus-wire 10, point 20
            return NO_RESOURCE;
        }
        match Request::parse(request.du) {
            Ok(Request::Read(wanted)) => self.ms1.read(&mut self.device, Relation::Ms1, wanted, &mut self.du),
            Ok(Request::Write(record)) => self.ms1.write(&mut self.device, Relation::Ms1, record),
            Err(PduError::Length(function @ (Function::Read | Function::Write))) => {
                self.ms1.refuse(function, Dpv1Error::TYPE_CONFLICT);
            }
            Ok(Request::AlarmAck(alarm)) if self.device.acknowledge_alarm(alarm) => {
                self.ms1.post(&Response::AlarmAck(alarm));
            }
            // An acknowledgement without its alarm is wrong; MS1 does not have the other functions.
            // Both end the relation: profibus-wire 10, point 19. chosen: the slave acknowledges the telegram itself.
            Ok(
                Request::AlarmAck(_)
                | Request::Idle(_)
                | Request::Initiate(_)
                | Request::Abort(_)
                | Request::DataTransport(_),
            )
            | Err(_) => self.enter_wait_prm(Fault::None),
        }
        Reply::ShortAck
    }

    /// SAP 50, which takes acknowledgements of alarms only: a long read or write does not hold them up. profibus-wire 4.5.
    pub(super) fn alarm(&mut self, request: &Indication<'_>) -> Reply<'_> {
        if !self.device.has_alarm_access_point() || !self.ms1_is_open_to(request.sa) {
            return SERVICE_CLOSED;
        }
        if request.du.is_empty() {
            let Some(alarm) = self.acknowledged.take() else { return Reply::ShortAck };
            let emitted = Response::AlarmAck(alarm).emit(&mut self.du);
            return prepared(&self.du, emitted);
        }
        if self.acknowledged.is_some() {
            return NO_RESOURCE;
        }
        match Request::parse(request.du) {
            Ok(Request::AlarmAck(alarm)) if self.device.acknowledge_alarm(alarm) => self.acknowledged = Some(alarm),
            // As over SAP 51.
            _ => self.enter_wait_prm(Fault::None),
        }
        Reply::ShortAck
    }
}
