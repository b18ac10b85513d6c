//! One segment that is watched, from finding its slaves to giving them back.

use super::display::MonitorView;
use super::plan::Plan;
use super::row::Row;
use crate::failure::Failure;
use crate::output::check;
use profivac_client::cyclic::CyclicSlave;
use profivac_dp::master::{ExchangeError, HandlerState, Mode};
use profivac_host::port;
use profivac_host::session::{BusSession, add_or_restart};
use rustix::fd::BorrowedFd;
use std::time::{Duration, Instant, SystemTime};

/// How often rows are made.
const PERIOD: Duration = Duration::from_secs(1);

/// How often a screen is told.
const FRAME: Duration = Duration::from_millis(200);

/// How long slaves are given to be unlocked.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// What a segment is watched with.
pub struct SegmentMonitor<'a> {
    /// What is watched.
    pub plan: &'a Plan,
    /// Which of all segments.
    pub number: usize,
    /// Where it is shown.
    pub show: &'a MonitorView<'a>,
    /// What becomes readable when it is time to end.
    pub ends: &'a [BorrowedFd<'a>],
    /// When it is time to end in any case.
    pub end: Option<Instant>,
}

impl SegmentMonitor<'_> {
    /// Finds the slaves, takes them, shows them, gives them back.
    pub fn run(&self) -> Result<(), Failure> {
        let done = self.monitor();
        if let Err(failure) = &done {
            self.show.ended(self.number, failure);
        }
        done
    }

    fn monitor(&self) -> Result<(), Failure> {
        let mut tool = self.plan.bus.open_lasting()?;
        let mut slaves = Vec::new();
        for address in &self.plan.addresses {
            if port::wait(self.ends, Duration::ZERO).is_ok_and(|ready| ready.contains(&true)) {
                return Ok(());
            }
            let found = CyclicSlave::find(&mut tool, *address, self.plan.bus.master());
            // If the port went meanwhile, that is why nobody answers.
            self.forward_notices(&mut tool);
            slaves.push(found?);
        }
        for slave in &slaves {
            let parameters = slave.parameters(tool.baud());
            add_or_restart(tool.master(), &parameters).map_err(|error| Failure::usage(error.to_string()))?;
        }
        tool.master().set_mode(Mode::Operate);
        let shown = self.exchange(&mut tool, &slaves);
        let verdict = check_exchanged(&mut tool, &slaves);
        release_slaves(&mut tool, &slaves)?;
        shown.and(verdict)
    }

    fn forward_notices(&self, tool: &mut BusSession) {
        while let Some(said) = tool.next_notice() {
            self.show.notice(self.number, &said);
        }
    }

    /// Exchanges data and tells what they say until it is time to end.
    fn exchange(&self, tool: &mut BusSession, slaves: &[CyclicSlave]) -> Result<(), Failure> {
        let period = if self.show.is_screen() { FRAME } else { PERIOD };
        self.show.print_header();
        let mut next = Instant::now() + period;
        while self.serve_until(tool, next)? {
            next += period;
            self.show.rows(self.number, self.rows(tool, slaves));
            check()?;
        }
        Ok(())
    }

    /// Serves the line until `moment`. False when it is time to end.
    fn serve_until(&self, tool: &mut BusSession, moment: Instant) -> Result<bool, Failure> {
        loop {
            let now = Instant::now();
            if self.end.is_some_and(|end| end <= now) {
                return Ok(false);
            }
            let wait = self.end.unwrap_or(moment).min(moment).saturating_duration_since(now);
            let readable = tool.serve(self.ends, wait)?;
            self.forward_notices(tool);
            while tool.master().next_event().is_some() {}
            match readable.contains(&true) {
                true => return Ok(false),
                false if Instant::now() >= moment => return Ok(true),
                false => {}
            }
        }
    }

    fn rows(&self, tool: &mut BusSession, slaves: &[CyclicSlave]) -> Vec<Row> {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let row = |slave| Row::of(self.plan.name.as_deref(), slave, tool.master(), now.as_secs_f64());
        slaves.iter().flat_map(row).collect()
    }
}

/// A slave that never exchanged data is a failure.
fn check_exchanged(tool: &mut BusSession, slaves: &[CyclicSlave]) -> Result<(), Failure> {
    let master = tool.master();
    for address in slaves.iter().map(|slave| slave.address) {
        if master.counters(address).is_some_and(|counters| counters.exchanges == 0) {
            let trouble = master.exchange_error(address);
            let reason =
                trouble.map_or_else(|| "it was not asked long enough".to_owned(), |trouble| trouble.to_string());
            let sentence = format!("no data from the slave at address {address}: {reason}");
            return Err(match trouble {
                None | Some(ExchangeError::NoAnswer(_)) => Failure::no_answer(sentence),
                Some(_) => Failure::refused(sentence),
            });
        }
    }
    Ok(())
}

/// Unlocks the slaves.
fn release_slaves(tool: &mut BusSession, slaves: &[CyclicSlave]) -> Result<(), Failure> {
    let end = Instant::now() + RELEASE_TIMEOUT;
    for slave in slaves {
        tool.master().release(slave.address);
    }
    let is_free = |tool: &mut BusSession| {
        let master = tool.master();
        slaves.iter().all(|slave| master.state(slave.address) == Some(HandlerState::Inactive))
    };
    while Instant::now() < end && !is_free(tool) {
        tool.serve(&[], end.saturating_duration_since(Instant::now()))?;
    }
    Ok(())
}
