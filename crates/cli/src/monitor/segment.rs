//! Monitors one segment, from the search for its slaves to their release.

use super::display::MonitorView;
use super::plan::Plan;
use super::row::Row;
use super::slave::MonitoredSlave;
use crate::failure::Failure;
use crate::output::check;
use profivac_dp::master::{ExchangeError, HandlerState, Mode};
use profivac_host::port::Notice;
use profivac_host::readiness::{KeptReadiness, Readiness, wait};
use profivac_host::session::BusSession;
use std::time::{Duration, Instant, SystemTime};

/// The interval between two rows.
const PERIOD: Duration = Duration::from_secs(1);

/// The interval between two updates of a screen.
const FRAME: Duration = Duration::from_millis(200);

/// The timeout for unlocking the slaves.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// A segment that is monitored.
pub struct SegmentMonitor<'a> {
    /// The segment and its slaves.
    pub plan: &'a Plan,
    /// The number of the segment.
    pub number: usize,
    /// The view that shows it.
    pub show: &'a MonitorView<'a>,
    /// Descriptors that become readable when the command ends.
    pub ends: &'a [Readiness<'a>],
    /// The time at which the command ends in any case.
    pub end: Option<Instant>,
}

impl SegmentMonitor<'_> {
    /// Finds the slaves, takes ownership, shows their values, releases them.
    pub fn run(&self) -> Result<(), Failure> {
        let done = self.monitor();
        if let Err(failure) = &done {
            self.show.ended(self.number, failure);
        }
        done
    }

    /// Ends the search for slaves when the command ends: a slave that does not answer takes up to the timeout.
    fn cancellation(&self) -> Option<Box<dyn Fn() -> bool + Send>> {
        let ends: Vec<_> = self.ends.iter().filter_map(|end| end.keep().ok()).collect();
        Some(Box::new(move || is_ready(&ends.iter().map(KeptReadiness::readiness).collect::<Vec<_>>())))
    }

    fn monitor(&self) -> Result<(), Failure> {
        let mut session = self.plan.bus.open_lasting()?;
        let mut slaves = Vec::new();
        session.set_cancellation(self.cancellation());
        for address in &self.plan.addresses {
            if is_ready(self.ends) {
                return Ok(());
            }
            let found = MonitoredSlave::find(&mut session, *address, self.plan);
            // Reported first, because a lost port is the reason for a missing answer.
            self.forward_notices(&mut session);
            let slave = match found {
                Err(_) if is_ready(self.ends) => return Ok(()),
                found => found?,
            };
            if let MonitoredSlave::Unknown(unknown) = &slave {
                self.show.notice(self.number, unknown);
            }
            slaves.push(slave);
        }
        session.set_cancellation(None);
        slaves.iter().try_for_each(|slave| slave.take(&mut session))?;
        session.master().set_mode(Mode::Operate);
        let shown = self.exchange(&mut session, &mut slaves);
        let verdict = check_exchanged(&mut session, &slaves);
        release_slaves(&mut session, &slaves)?;
        shown.and(verdict)
    }

    fn forward_notices(&self, session: &mut BusSession) {
        while let Some(notice) = session.next_notice() {
            self.show.notice(self.number, &notice);
        }
    }

    /// Exchanges data and shows the values until the command ends.
    fn exchange(&self, session: &mut BusSession, slaves: &mut [MonitoredSlave]) -> Result<(), Failure> {
        let period = if self.show.is_screen() { FRAME } else { PERIOD };
        self.show.print_header();
        let mut next = Instant::now() + period;
        let mut loss = PortLoss::default();
        while self.serve_until(session, next, slaves, &mut loss)? {
            next += period;
            slaves.iter_mut().for_each(|slave| slave.read(session));
            let mut rows = self.rows(session, slaves);
            loss.mark(&mut rows);
            self.show.rows(self.number, rows);
            check()?;
        }
        Ok(())
    }

    /// Serves the line until `moment`. Returns false when the command ends.
    fn serve_until(
        &self,
        session: &mut BusSession,
        moment: Instant,
        slaves: &[MonitoredSlave],
        loss: &mut PortLoss,
    ) -> Result<bool, Failure> {
        loop {
            let now = Instant::now();
            if self.end.is_some_and(|end| end <= now) {
                return Ok(false);
            }
            let wait = self.end.unwrap_or(moment).min(moment).saturating_duration_since(now);
            let readable = session.serve(self.ends, wait)?;
            while let Some(notice) = session.next_notice() {
                if matches!(notice, Notice::Lost(_)) {
                    loss.begin(&self.rows(session, slaves));
                }
                self.show.notice(self.number, &notice);
            }
            while session.master().next_event().is_some() {}
            match readable.contains(&true) {
                true => return Ok(false),
                false if Instant::now() >= moment => return Ok(true),
                false => {}
            }
        }
    }

    fn rows(&self, session: &mut BusSession, slaves: &[MonitoredSlave]) -> Vec<Row> {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let rows = |slave: &MonitoredSlave| slave.rows(self.plan.name.as_deref(), session, now.as_secs_f64());
        slaves.iter().flat_map(rows).collect()
    }
}

/// The loss of a port: until a slave answers again, its last answers say nothing about it.
#[derive(Default)]
struct PortLoss {
    /// The slaves that have not exchanged data since the port was lost, with their exchanges.
    waiting: Vec<(u8, u32)>,
}

impl PortLoss {
    /// The port is lost; `rows` are the slaves at this moment.
    fn begin(&mut self, rows: &[Row]) {
        self.waiting = rows.iter().map(|row| (row.address, row.exchanges)).collect();
    }

    /// Names the port as the reason in the rows of slaves that have not exchanged data since it was lost.
    fn mark(&mut self, rows: &mut [Row]) {
        self.waiting.retain(|slave| rows.iter().any(|row| (row.address, row.exchanges) == *slave));
        for row in rows.iter_mut().filter(|row| self.waiting.contains(&(row.address, row.exchanges))) {
            row.set_offline("the port was lost");
        }
    }
}

/// Fails if a slave has never exchanged data.
fn check_exchanged(session: &mut BusSession, slaves: &[MonitoredSlave]) -> Result<(), Failure> {
    let master = session.master();
    for slave in slaves.iter().filter(|slave| slave.is_owned()) {
        let address = slave.address();
        if master.counters(address).is_some_and(|counters| counters.exchanges == 0) {
            let error = master.exchange_error(address);
            let reason = error
                .map_or_else(|| "the command ended before the slave was ready".to_owned(), |error| error.to_string());
            let sentence = format!("no data from the slave at address {address}: {reason}");
            return Err(match error {
                None | Some(ExchangeError::NoAnswer(_)) => Failure::no_answer(sentence),
                Some(ExchangeError::PrmFault) => Failure::refused(sentence + slave.advice()),
                Some(_) => Failure::refused(sentence),
            });
        }
    }
    Ok(())
}

/// Whether one of the sources is readable.
fn is_ready(sources: &[Readiness<'_>]) -> bool {
    wait(sources, Duration::ZERO).is_ok_and(|ready| ready.contains(&true))
}

/// Unlocks the slaves and waits until that is done.
fn release_slaves(session: &mut BusSession, slaves: &[MonitoredSlave]) -> Result<(), Failure> {
    let end = Instant::now() + RELEASE_TIMEOUT;
    let owned: Vec<_> = slaves.iter().filter(|slave| slave.is_owned()).map(MonitoredSlave::address).collect();
    owned.iter().for_each(|address| session.master().release(*address));
    let is_free = |session: &mut BusSession| {
        let master = session.master();
        owned.iter().all(|address| master.state(*address) == Some(HandlerState::Inactive))
    };
    while Instant::now() < end && !is_free(session) {
        session.serve(&[], end.saturating_duration_since(Instant::now()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::row::RowState;
    use super::*;

    /// A row of a slave that exchanges data.
    fn row(address: u8, exchanges: u32) -> Row {
        let row = Row::empty(None, address, "bcg450".to_owned(), 0.0);
        Row { state: RowState::Handler(HandlerState::Data { diag: false }), pressure: Some(1.0), exchanges, ..row }
    }

    #[test]
    fn after_the_port_was_lost_a_row_says_so_until_the_slave_has_exchanged_data() {
        let mut loss = PortLoss::default();
        let rows =
            |counts: &[(u8, u32)]| counts.iter().map(|(address, count)| row(*address, *count)).collect::<Vec<_>>();
        let mut marked = |counts: &[(u8, u32)], lost_at: Option<&[(u8, u32)]>| {
            lost_at.iter().for_each(|counts| loss.begin(&rows(counts)));
            let mut rows = rows(counts);
            loss.mark(&mut rows);
            rows.iter().map(|row| (row.state.to_string(), row.remarks_text(), row.pressure)).collect::<Vec<_>>()
        };
        let online = || ("DATA".to_owned(), String::new(), Some(1.0));
        let offline = || ("OFFLINE".to_owned(), "the port was lost".to_owned(), None);
        assert_eq!(marked(&[(5, 10), (9, 20)], None), [online(), online()]);
        assert_eq!(marked(&[(5, 11), (9, 20)], Some(&[(5, 11), (9, 20)])), [offline(), offline()]);
        assert_eq!(marked(&[(5, 12), (9, 20)], None), [online(), offline()]);
        assert_eq!(marked(&[(5, 12), (9, 21)], None), [online(), online()]);
        assert_eq!(marked(&[(5, 12), (9, 21)], None), [online(), online()], "a slave may be silent for another reason");
    }
}
