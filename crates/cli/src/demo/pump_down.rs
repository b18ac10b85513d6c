//! The plant state in which the demonstration begins: it suppresses the alarm of the vented chamber, and ends in high vacuum.

use super::alarms::CHAMBER;
use crate::failure::Failure;
use profivac_station::alarm::AlarmService;
use profivac_station::view::Gauge;
use profivac_web_server::auth::Actor;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Its name.
pub const NAME: &str = "Chamber pump-down";

/// The reason of its declaration.
const REASON: &str = "the chamber was vented";

/// Far longer than the pump-down lasts, also when the demonstration runs slowly.
pub const LONGEST: Duration = Duration::from_secs(3600);

/// A tenth of the limit of the chamber's alarm, in Pa.
const EVACUATED_PA: f64 = 0.01;

/// The plant state that the demonstration has declared.
pub struct PumpDown {
    declared_by: Actor,
}

impl PumpDown {
    /// Declares the plant state.
    pub fn declare(alarms: &AlarmService, declared_by: Actor) -> Result<Self, Failure> {
        alarms.declare(NAME, &declared_by, REASON, LONGEST).map_err(|error| Failure::usage(error.to_string()))?;
        Ok(Self { declared_by })
    }

    /// Ends the declaration, unless a user has ended it or declared another one. The plant goes on while the disk is written.
    pub fn end(self, alarms: &Arc<AlarmService>) {
        let states = alarms.plant_states();
        let declared = states.into_iter().find(|state| state.name == NAME).and_then(|state| state.declared);
        if declared.is_none_or(|declared| declared.reason != REASON) {
            return;
        }
        let alarms = Arc::clone(alarms);
        // A user who ends it meanwhile does the same.
        thread::spawn(move || alarms.end_plant_state(NAME, &self.declared_by, "high vacuum").ok());
    }
}

/// Whether a gauge is that of the chamber, and measures high vacuum.
pub fn is_evacuated(gauge: &Gauge) -> bool {
    let pa = gauge.readings.first().and_then(|reading| reading.pa);
    gauge.name == CHAMBER && pa.is_some_and(|pa| pa < EVACUATED_PA)
}
