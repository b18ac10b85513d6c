//! A slave in the views of the API.

use super::SegmentSlave;
use super::points::planned_points;
use crate::config;
use crate::segment::moment::Moment;
use crate::view::{self, BusStationState, GaugeKind};
use profivac_recorder::validity;
use std::sync::Arc;

impl SegmentSlave {
    /// The slave as a station on the bus.
    pub fn bus_station(&self) -> view::BusStation {
        let description = match (&self.problem, self.state) {
            (Some(problem), _) => problem.clone(),
            (None, BusStationState::DataExchange) if self.config.is_owned => "in data exchange".to_owned(),
            (None, BusStationState::DataExchange) => "in data exchange with another master".to_owned(),
            (None, BusStationState::Fault) if self.reports.is_empty() => "a fault".to_owned(),
            (None, BusStationState::Fault) => self.reports.join("; "),
            (None, _) => "is being brought into data exchange".to_owned(),
        };
        view::BusStation {
            address: self.config.address,
            state: self.state,
            name: Some(self.config.name.clone()),
            device: Some(self.config.model()),
            ident: Some(format!("0x{:04X}", self.config.gsd.ident())),
            description,
        }
    }

    /// The slave as the API shows it.
    pub fn view_at(&self, segment: &str, now: Moment) -> view::Gauge {
        let (exceptions, warnings) =
            if self.has_fault { (self.reports.clone(), Vec::new()) } else { (Vec::new(), self.reports.clone()) };
        view::Gauge {
            listen_only: !self.config.is_owned,
            state: self.state,
            problem: self.problem.clone(),
            exceptions,
            warnings,
            parameters: Arc::clone(&self.points),
            age_ms: self.read.map(|read| view::duration_ms(now.since(read))),
            read_at: self.read.map(|read| read.wall),
            lost_at: self.lost_at,
            is_awaited: self.first_round.is_awaited(now),
            ..planned_slave(&self.config, segment)
        }
    }
}

/// A slave of the station's file before anything was heard of it: with its points, without their values.
#[must_use]
pub fn planned_slave(config: &config::Slave, segment: &str) -> view::Gauge {
    view::Gauge {
        name: config.name.clone(),
        kind: GaugeKind::Slave,
        segment: segment.to_owned(),
        address: config.address,
        device: config.model(),
        model: None,
        vendor: config.vendor().map(Arc::from),
        integers: None,
        has_dpv1: false,
        listen_only: !config.is_owned,
        assumptions: Vec::new(),
        state: BusStationState::Missing,
        problem: None,
        exceptions: Vec::new(),
        warnings: Vec::new(),
        gas: String::new(),
        levels: Vec::new(),
        readings: Vec::new(),
        parameters: planned_points(config).into(),
        age_ms: None,
        read_at: None,
        lost_at: None,
        is_awaited: false,
        poll_ms: view::duration_ms(config.poll),
        stale_after_ms: validity::stale_after_ms(view::duration_ms(config.poll)),
    }
}
