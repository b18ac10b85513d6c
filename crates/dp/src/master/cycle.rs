//! The cycle of a master: the order of its requests to the slaves, and its beginning and end. profibus-wire 3.10.

use super::state::CyclicRequest;
use super::{Master, Mode, Pending};
use crate::link::BitTime;

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// The next request of the cycle; `None` at its end.
    #[inline]
    pub(super) fn next_in_cycle(&mut self, now: BitTime) -> Option<Pending> {
        if self.mode == Mode::Stop && !self.is_shutting_down() {
            return None;
        }
        let first = match self.next_in_list {
            Some(first) => first,
            None => self.begin_cycle(now)?,
        };
        if let Some(control) = self.next_control() {
            return Some(control);
        }
        let next = self.next_slave(first, now);
        if next.is_none() {
            self.end_cycle();
        }
        next
    }

    /// Whether a stopping master still sends: until every slave in data exchange has been sent safe outputs.
    #[cold]
    fn is_shutting_down(&mut self) -> bool {
        if let Some(Some(since)) = self.shutdown
            && self.all_exchanged_since(since, None)
        {
            self.shutdown = None;
            self.next_in_list = None;
        }
        self.shutdown.is_some()
    }

    fn begin_cycle(&mut self, now: BitTime) -> Option<usize> {
        if self.cycles > 0 && now < self.began + self.settings.min_cycle_tbit && self.shutdown.is_none() {
            return None;
        }
        self.cycle_tbit = now - self.began;
        self.began = now;
        self.cycles = self.cycles.wrapping_add(1);
        self.controls.mode_due |= self.cycles.checked_rem(self.settings.control_cycles) == Some(0);
        self.prepare_controls(now);
        if let Some(since) = &mut self.shutdown {
            since.get_or_insert(now);
        }
        self.offline_polled = false;
        self.next_in_list = Some(0);
        self.next_in_list
    }

    fn end_cycle(&mut self) {
        self.next_in_list = None;
        if !self.offline_polled {
            self.offline_from = 0;
        }
    }

    /// The next slave from index `first` on that needs a request.
    #[inline]
    fn next_slave(&mut self, first: usize, now: BitTime) -> Option<Pending> {
        for index in first..self.slaves.len() {
            let request = self.slaves.get(index).and_then(|slave| slave.next_request(now));
            if let Some(request) = request
                && (request == CyclicRequest::DataExch || self.may_request(index, request))
            {
                self.next_in_list = Some(index.saturating_add(1));
                return Some(Pending::Slave(index, request));
            }
        }
        None
    }

    /// Whether a request other than Data_Exchange is allowed in this cycle: a stopping master starts no slaves.
    fn may_request(&mut self, index: usize, request: CyclicRequest) -> bool {
        match request {
            CyclicRequest::FdlStatus => self.shutdown.is_none() && self.may_poll_offline(index),
            CyclicRequest::SetPrm | CyclicRequest::ChkCfg | CyclicRequest::Unlock => self.shutdown.is_none(),
            CyclicRequest::SlaveDiag | CyclicRequest::DataExch => true,
        }
    }

    /// Whether the master polls this absent slave in this cycle.
    const fn may_poll_offline(&mut self, index: usize) -> bool {
        if self.offline_polled || index < self.offline_from {
            return false;
        }
        self.offline_polled = true;
        self.offline_from = index.saturating_add(1);
        true
    }
}
