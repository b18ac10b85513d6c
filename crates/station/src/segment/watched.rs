//! The parameters that gateways show beside the pressures: emission, degas, trip points and relays. The station reads them one after
//! the other, while a gateway runs.
//!
//! Most are read every [`INTERVAL`]. A parameter of an instance needs a move of the selector, which the gauge keeps in its nonvolatile
//! memory (BCG450 manual 3.2.1.2, store class N), so it is read when the gauge was found, after an operation of the station, and every
//! [`SELECTED_INTERVAL`].

use super::moment::Moment;
use super::records::records_of;
use crate::view::WatchedParameter;
use profivac_client::Gauge;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::Ms2Line;
use profivac_client::names::{NamedParameter, ParameterNames};
use profivac_client::values::Value;
use profivac_devices::model::{AccessPath, Codes, DataType, Direction, Model, Role};
use profivac_recorder::Quality;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time between two readings of a parameter. chosen: people who look at a trip point wait no longer.
const INTERVAL: Duration = Duration::from_secs(10);

/// The time between two readings of a parameter that needs a move of the selector. chosen: at most sixteen writes of the selector a
/// day, so that a memory of 100,000 writes lasts for 17 years.
const SELECTED_INTERVAL: Duration = Duration::from_secs(6 * 3600);

/// The shortest time between two readings on a segment, so that they take a small part of the line. chosen.
pub const PAUSE: Duration = Duration::from_millis(250);

/// The beginnings of the names of locations whose parameters are watched: PCG55x and PSG55x have trip points and relays, BPG400 and
/// BCG450 set points, the controllers relays.
const LOCATIONS: [&str; 3] = ["Trip Point", "Setpoint", "Relay"];

/// One watched parameter of a gauge.
struct Watched {
    parameter: &'static NamedParameter,
    read_at: Instant,
}

/// The watched parameters of a gauge.
#[derive(Default)]
pub struct WatchedParameters {
    model: Option<&'static str>,
    list: Vec<Watched>,
    /// The last values, in the order of the tables. Views share them: a view is made ten times a second, a value changes rarely.
    values: Arc<[WatchedParameter]>,
}

impl WatchedParameters {
    /// The gauge is a `model` now; a gauge of another model has other parameters.
    pub fn found(&mut self, model: &'static Model, now: Instant) {
        if self.model == Some(model.name) {
            return;
        }
        self.model = Some(model.name);
        let watched = |parameter| Watched { parameter, read_at: now };
        self.list = watched_of(model).map(watched).collect();
        self.values = planned(model).into();
    }

    /// When the next parameter is to be read; `None` for a device without watched parameters.
    pub fn due(&self) -> Option<Instant> {
        self.list.iter().map(|watched| watched.read_at).min()
    }

    /// The parameter that is to be read now, if there is one. If so, sets the time of its next reading.
    pub fn takes_turn(&mut self, now: Instant) -> Option<&'static NamedParameter> {
        let due =
            self.list.iter_mut().filter(|watched| watched.read_at <= now).min_by_key(|watched| watched.read_at)?;
        due.read_at = now + interval(due.parameter);
        Some(due.parameter)
    }

    /// Takes a value. Without one, the gauge did not answer or refused: the last value is no longer true.
    pub fn take(&mut self, parameter: &NamedParameter, value: Option<WatchedParameter>) {
        let index = self.list.iter().position(|watched| watched.parameter.name == parameter.name);
        if let Some(place) = index.and_then(|index| Arc::make_mut(&mut self.values).get_mut(index)) {
            *place = value.unwrap_or_else(|| absent(parameter));
        }
    }

    /// An operation may have changed every parameter: all are read again.
    pub fn changed(&mut self, now: Instant) {
        self.list.iter_mut().for_each(|watched| watched.read_at = now);
    }

    /// The values that were read, in the order of the tables.
    pub fn values(&self) -> Arc<[WatchedParameter]> {
        Arc::clone(&self.values)
    }
}

/// The watched parameters of a model without values.
#[must_use]
pub fn planned(model: &'static Model) -> Vec<WatchedParameter> {
    watched_of(model).map(absent).collect()
}

fn absent(parameter: &NamedParameter) -> WatchedParameter {
    let row = parameter.parameter.row;
    WatchedParameter {
        target: parameter.name.clone(),
        name: row.name.to_owned(),
        unit: match row.codes {
            Codes::PerMille(..) => Some("%"),
            _ => (row.data_type == DataType::ByType).then_some("Pa"),
        },
        number: None,
        text: String::new(),
        quality: Quality::Stale,
        read_at: None,
    }
}

const fn interval(parameter: &NamedParameter) -> Duration {
    if parameter.parameter.location.instance == 0 { INTERVAL } else { SELECTED_INTERVAL }
}

/// The parameters of a model that gateways show.
fn watched_of(model: &'static Model) -> impl Iterator<Item = &'static NamedParameter> {
    let via = if model.features.dpv1 { AccessPath::Class2 } else { AccessPath::ParameterChannel };
    let all = ParameterNames::of_catalog(model).map(ParameterNames::all).unwrap_or_default();
    all.iter().filter(move |named| named.parameter.row.access.allows(via, Direction::Read) && is_watched(named))
}

fn is_watched(named: &NamedParameter) -> bool {
    let row = named.parameter.row;
    let is_number = !matches!(
        row.data_type,
        DataType::Visible(_) | DataType::OctetString(_) | DataType::Array(_) | DataType::Record(_)
    );
    let describes_others = matches!(row.role, Some(Role::NumberType | Role::InstanceSelector | Role::BlockType))
        || row.codes == Codes::Units;
    let is_in_location = LOCATIONS.iter().any(|name| named.parameter.location.name.starts_with(name));
    let is_state = matches!(row.role, Some(Role::EmissionStatus | Role::DegasStatus));
    is_state || (is_in_location && is_number && !describes_others)
}

/// Reads a parameter; `None` if the gauge does not answer or refuses. `clock` gives the time of the answer.
pub fn read<L: Ms2Line>(
    line: &mut L,
    slave: &CyclicSlave,
    parameter: &NamedParameter,
    clock: impl FnOnce() -> Moment,
) -> Option<WatchedParameter> {
    let records = records_of(line, slave);
    let mut gauge = Gauge::with_model(records, slave.address, slave.model).with_unit(slave.unit);
    let reading = gauge.read_parameter(parameter).ok()?;
    let number = match &reading.value {
        _ if reading.named.parameter.row.data_type == DataType::ByType => gauge.pressure_pa(&reading),
        Value::Integer(number) => i32::try_from(*number).ok().map(f64::from),
        Value::Number(number) => Some(*number),
        Value::Text(_) | Value::Octets(_) => None,
    };
    Some(WatchedParameter {
        number,
        text: reading.text,
        quality: Quality::Valid,
        read_at: Some(clock().wall),
        ..absent(parameter)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::{MODELS, model_named};

    fn names(device: &str) -> Vec<String> {
        planned(model_named(device).unwrap()).into_iter().map(|parameter| parameter.target).collect()
    }

    #[test]
    fn emission_degas_and_trip_points_are_watched_and_descriptions_are_not() {
        assert!(names("bcg450").contains(&"ba.emission-status".to_owned()), "{:?}", names("bcg450"));
        assert!(names("bcg450").contains(&"ba.degas-status".to_owned()));
        assert!(names("psg550").contains(&"trip-point.1/high-trip-point".to_owned()), "{:?}", names("psg550"));
        assert!(names("tpg300").contains(&"relay.1/setpoint-status".to_owned()), "{:?}", names("tpg300"));
        for model in MODELS {
            let all = names(model.name);
            assert!(all.iter().all(|name| !name.contains("block-type") && !name.contains("data-units")), "{all:?}");
            assert!(all.len() <= 80, "{} has {}", model.name, all.len());
        }
    }

    #[test]
    fn each_parameter_has_its_turn_and_one_that_moves_the_selector_is_read_seldom() {
        let (mut watched, now) = (WatchedParameters::default(), Instant::now());
        watched.found(model_named("bcg450").unwrap(), now);
        let count = watched.list.len();
        let first: Vec<_> = std::iter::from_fn(|| watched.takes_turn(now)).collect();
        assert_eq!(first.len(), count);
        assert!(watched.takes_turn(now + INTERVAL - Duration::from_millis(1)).is_none());
        let again: Vec<_> = std::iter::from_fn(|| watched.takes_turn(now + INTERVAL)).collect();
        assert!(again.iter().all(|named| named.parameter.location.instance == 0));
        let rest: Vec<_> = std::iter::from_fn(|| watched.takes_turn(now + SELECTED_INTERVAL)).collect();
        assert_eq!(rest.len(), count);
        watched.changed(now + SELECTED_INTERVAL);
        assert!(watched.takes_turn(now + SELECTED_INTERVAL).is_some(), "after an operation");
    }
}
