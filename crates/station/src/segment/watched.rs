//! The parameters that gateways show beside the pressures: emission, degas, trip points, relays, and the numbers with a unit that a device
//! file adds. The station reads them one after the other, while a gateway runs.
//!
//! Most are read every [`INTERVAL`]. A parameter of an instance needs a move of the selector, which the gauge keeps in its nonvolatile
//! memory (BCG450 manual 3.2.1.2, store class N), so it is read when the gauge was found, after an operation of the station, and every
//! [`SELECTED_INTERVAL`].
//!
//! While a degas runs, its status and that of the emission are read every [`DEGAS_INTERVAL`], so that both stay valid.
//!
//! A state, such as emission or degas, changes without the station: its value is valid for [`VALID_FOR`] after it was read, then stale. A
//! setting changes only by a write, and stays valid.

use super::moment::Moment;
use super::records::records_of;
use crate::view::WatchedParameter;
use profivac_client::Gauge;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::Ms2Line;
use profivac_client::names::{NamedParameter, ParameterNames};
use profivac_client::values::Value;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{AccessPath, Codes, DataType, Direction, Model, Role, Row, Storage};
use profivac_recorder::Quality;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time between two readings of a parameter. chosen: people who look at a trip point wait no longer.
const INTERVAL: Duration = Duration::from_secs(10);

/// The time between two readings of a parameter that needs a move of the selector. chosen: at most sixteen writes of the selector a
/// day, so that a memory of 100,000 writes lasts for 17 years.
const SELECTED_INTERVAL: Duration = Duration::from_secs(6 * 3600);

/// The time between two readings of degas and emission while a degas runs, which the gauge ends by itself. chosen: a third of [`VALID_FOR`],
/// because a reading may wait on a busy line.
const DEGAS_INTERVAL: Duration = Duration::from_secs(20);

/// A degas that has not ended after this time is read as seldom as before: each reading moves the selector. chosen: a BCG450 ends it after
/// three minutes.
const LONGEST_DEGAS: Duration = Duration::from_mins(30);

/// How long the value of a parameter that changes by itself is valid after it was read. chosen: six intervals, so that a busy line makes no
/// value stale, and a degas of three minutes does not seem to last.
const VALID_FOR: Duration = Duration::from_secs(60);

/// The shortest time between two readings on a segment, so that they take a small part of the line. chosen.
pub const PAUSE: Duration = Duration::from_millis(250);

/// The beginnings of the names of locations whose parameters are watched: PCG55x and PSG55x have trip points and relays, BPG400 and
/// BCG450 set points, the controllers relays.
const LOCATIONS: [&str; 3] = ["Trip Point", "Setpoint", "Relay"];

/// One watched parameter of a gauge.
struct Watched {
    parameter: &'static NamedParameter,
    read_at: Instant,
    /// An operation of the station has changed it: it is read before all others.
    is_urgent: bool,
    /// When its value becomes stale; `None` without a value, and for a setting.
    valid_until: Option<Instant>,
    /// Since when a degas runs; only for its status.
    degas_since: Option<Instant>,
}

impl Watched {
    const fn due(&self) -> Due {
        Due { is_usual: !self.is_urgent, at: self.read_at }
    }
}

/// When a parameter is to be read. Urgent ones come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Due {
    is_usual: bool,
    at: Instant,
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
        let watched =
            |parameter| Watched { parameter, read_at: now, is_urgent: false, valid_until: None, degas_since: None };
        self.list = watched_of(model).map(watched).collect();
        self.values = planned(model).into();
    }

    /// When the next parameter is to be read; `None` for a device without watched parameters.
    pub fn due(&self) -> Option<Due> {
        self.list.iter().map(Watched::due).min()
    }

    /// The parameter that is to be read now, if there is one. If so, sets the time of its next reading.
    pub fn takes_turn(&mut self, now: Instant) -> Option<&'static NamedParameter> {
        let due = self.list.iter_mut().filter(|watched| watched.read_at <= now).min_by_key(|watched| watched.due())?;
        // What an operation has changed may take a moment: it is read once more.
        let pause = if due.is_urgent { INTERVAL } else { interval(due.parameter) };
        (due.read_at, due.is_urgent) = (now + pause, false);
        Some(due.parameter)
    }

    /// Takes a value that was read `now`. Without one, the gauge did not answer or refused: the last value is no longer true.
    pub fn take(&mut self, parameter: &NamedParameter, value: Option<WatchedParameter>, now: Moment) {
        let Some(index) = self.list.iter().position(|watched| watched.parameter.name == parameter.name) else { return };
        if let Some(watched) = self.list.get_mut(index) {
            watched.valid_until = (value.is_some() && changes_by_itself(parameter)).then(|| now.at + VALID_FOR);
        }
        let is_on = value.as_ref().map(|value| value.number.is_some_and(|code| code != 0.0));
        if let Some(place) = Arc::make_mut(&mut self.values).get_mut(index) {
            // A gauge that refuses again has lost nothing again.
            let lost_at = place.lost_at.or(Some(now.wall));
            *place = value.unwrap_or_else(|| WatchedParameter { lost_at, ..absent(parameter) });
        }
        if parameter.parameter.row.role == Some(Role::DegasStatus) {
            self.follow_degas(index, is_on, now.at);
        }
    }

    /// While a degas runs, its status and the emission of the same part are read again soon. `is_on` is `None` if its status was not read.
    fn follow_degas(&mut self, index: usize, is_on: Option<bool>, now: Instant) {
        let Some(degas) = self.list.get_mut(index) else { return };
        match is_on {
            Some(true) => degas.degas_since = degas.degas_since.or(Some(now)),
            Some(false) => degas.degas_since = None,
            None => {}
        }
        let is_followed = |since: Instant| now.saturating_duration_since(since) < LONGEST_DEGAS;
        let location = degas.parameter.parameter.location;
        if !degas.degas_since.is_some_and(is_followed) {
            return;
        }
        for watched in &mut self.list {
            let parameter = &watched.parameter.parameter;
            let is_status = matches!(parameter.row.role, Some(Role::EmissionStatus | Role::DegasStatus));
            if is_status && parameter.location == location {
                watched.read_at = watched.read_at.min(now + DEGAS_INTERVAL);
            }
        }
    }

    /// An operation has written `target` and may have changed every parameter: all are read again. The written one, and those that follow
    /// from it, are read first, and their old values are stale until then.
    pub fn changed(&mut self, target: &NamedParameter, now: Moment) {
        for watched in &mut self.list {
            let NamedParameter { name, parameter, .. } = watched.parameter;
            let follows = parameter.location == target.parameter.location && changes_by_itself(watched.parameter);
            watched.read_at = now.at;
            watched.is_urgent = *name == target.name || follows;
            if watched.is_urgent {
                watched.valid_until = Some(now.at);
            }
        }
        self.expire(now);
    }

    /// Makes the values stale that are too old to be true. They keep the time at which they were read, and get the time of this decision: a
    /// client that keeps one event for each time would keep the old value otherwise.
    pub fn expire(&mut self, now: Moment) {
        for (index, watched) in self.list.iter_mut().enumerate() {
            if watched.valid_until.take_if(|until| *until <= now.at).is_some()
                && let Some(place) = Arc::make_mut(&mut self.values).get_mut(index)
            {
                let (read_at, lost_at) = (place.read_at, Some(now.wall));
                *place = WatchedParameter { read_at, lost_at, ..absent(watched.parameter) };
            }
        }
    }

    /// A hot cathode gave a pressure in the data exchange of `read`: an older "off" of the only emission of the gauge is not true any more.
    pub fn emission_is_on(&mut self, read: Moment) {
        let is_emission = |it: &&mut Watched| it.parameter.parameter.row.role == Some(Role::EmissionStatus);
        let mut all = self.list.iter_mut().filter(is_emission);
        let (Some(watched), None) = (all.next(), all.next()) else { return };
        let value = self.values.iter().find(|value| value.target == watched.parameter.name);
        let is_off = |it: &WatchedParameter| it.number == Some(0.0) && it.read_at.is_some_and(|at| at < read.wall);
        if value.is_some_and(is_off) {
            watched.valid_until = Some(read.at);
            self.expire(read);
        }
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
            Codes::Quantity(quantity) => Some(quantity.unit),
            _ => (row.data_type == DataType::ByType).then_some("Pa"),
        },
        number: None,
        text: String::new(),
        quality: Quality::Stale,
        read_at: None,
        lost_at: None,
    }
}

/// Whether it changes without a write: a state, and not a setting.
const fn changes_by_itself(parameter: &NamedParameter) -> bool {
    matches!(parameter.parameter.row.storage, Storage::Volatile | Storage::Dynamic)
}

const fn interval(parameter: &NamedParameter) -> Duration {
    if parameter.parameter.location.instance == 0 { INTERVAL } else { SELECTED_INTERVAL }
}

/// The parameters of a model that gateways show.
fn watched_of(model: &'static Model) -> impl Iterator<Item = &'static NamedParameter> {
    let via = if model.features.dpv1 { AccessPath::Class2 } else { AccessPath::ParameterChannel };
    let all = ParameterNames::shared(model).all();
    all.iter().filter(move |named| named.parameter.row.access.allows(via, Direction::Read) && is_watched(named))
}

fn is_watched(named: &NamedParameter) -> bool {
    let row = named.parameter.row;
    let is_number = !matches!(
        row.data_type,
        DataType::Visible(_) | DataType::OctetString(_) | DataType::Array(_) | DataType::Record(_)
    );
    let describes_others =
        matches!(row.role, Some(Role::Unit | Role::NumberType | Role::InstanceSelector | Role::BlockType));
    let is_in_location = LOCATIONS.iter().any(|name| named.parameter.location.name.starts_with(name));
    let is_state = matches!(row.role, Some(Role::EmissionStatus | Role::DegasStatus));
    let is_quantity = matches!(row.codes, Codes::Quantity(_)) && !is_built_in(row);
    is_state || is_quantity || (is_in_location && is_number && !describes_others)
}

/// Whether a device that is compiled in has this row. Its emission current needs moves of the selector and follows from the emission
/// status, and its run hours say nothing about the vacuum. chosen: gateways show neither, also of a device that a file makes like it.
fn is_built_in(row: &Row) -> bool {
    let mut rows = MODELS.iter().flat_map(|model| model.blocks).flat_map(|placed| placed.block.rows);
    rows.any(|known| known.is_like(row))
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
    use profivac_devices::catalog::model_named;
    use profivac_recorder::Micros;

    /// The clock of the system at every decision of these tests.
    const DECIDED: Micros = Micros(50);

    fn decided(at: Instant) -> Moment {
        Moment { at, wall: DECIDED }
    }

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
            let is_unwatched = |name: &String| name.contains("emission-current") || name.contains("run-hours");
            assert!(!all.iter().any(is_unwatched), "{all:?}");
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
        let emission = watched.list.iter().find(|it| it.parameter.name == "ba.emission-status").unwrap().parameter;
        watched.changed(emission, decided(now + SELECTED_INTERVAL));
        assert!(watched.takes_turn(now + SELECTED_INTERVAL).is_some(), "after an operation");
    }

    /// All parameters of a `device`, read at `now` with the same value.
    fn read_at(device: &str, now: Instant) -> WatchedParameters {
        let mut watched = WatchedParameters::default();
        watched.found(model_named(device).unwrap(), now);
        while let Some(parameter) = watched.takes_turn(now) {
            watched.take(parameter, Some(read_value(parameter)), decided(now));
        }
        watched
    }

    fn read_value(parameter: &NamedParameter) -> WatchedParameter {
        let (text, read_at) = ("off".to_owned(), Some(Micros(7)));
        WatchedParameter { number: Some(0.0), text, quality: Quality::Valid, read_at, ..absent(parameter) }
    }

    fn value<'a>(values: &'a [WatchedParameter], target: &str) -> &'a WatchedParameter {
        values.iter().find(|value| value.target == target).unwrap()
    }

    #[test]
    fn a_state_that_was_read_long_ago_is_stale_from_the_time_of_that_decision_and_a_setting_stays_valid() {
        let now = Instant::now();
        let mut watched = read_at("bcg450", now);
        watched.expire(decided(now + VALID_FOR - Duration::from_millis(1)));
        assert!(watched.values().iter().all(|value| value.quality == Quality::Valid));
        watched.expire(decided(now + VALID_FOR));
        let values = watched.values();
        for state in ["ba.emission-status", "ba.degas-status", "setpoint-a.status", "setpoint-a.process-value"] {
            let value = value(&values, state);
            assert_eq!(
                (value.quality, value.number, value.read_at, value.lost_at),
                (Quality::Stale, None, Some(Micros(7)), Some(DECIDED)),
                "{state}"
            );
            assert_eq!(value.text, "", "{state}");
        }
        let setting = value(&values, "setpoint-a.percentage-of-atmosphere");
        assert_eq!((setting.quality, setting.number, setting.lost_at), (Quality::Valid, Some(0.0), None));
        // A reading makes it valid again.
        let emission = watched.list.iter().find(|it| it.parameter.name == "ba.emission-status").unwrap().parameter;
        let later = now + SELECTED_INTERVAL;
        watched.take(emission, Some(read_value(emission)), decided(later));
        watched.expire(decided(later));
        let emission = value(&watched.values(), "ba.emission-status").clone();
        assert_eq!((emission.quality, emission.lost_at), (Quality::Valid, None));
    }

    /// An archiver keeps one event for each time.
    #[test]
    fn a_parameter_that_the_gauge_does_not_give_any_more_is_lost_at_the_first_refusal() {
        let now = Instant::now();
        let mut watched = read_at("bcg450", now);
        let degas = watched.list.iter().find(|it| it.parameter.name == "ba.degas-status").unwrap().parameter;
        for wall in [Micros(60), Micros(70)] {
            watched.take(degas, None, Moment { at: now, wall });
            let value = value(&watched.values(), "ba.degas-status").clone();
            assert_eq!((value.quality, value.number, value.lost_at), (Quality::Stale, None, Some(Micros(60))));
        }
        watched.take(degas, Some(read_value(degas)), Moment { at: now, wall: Micros(80) });
        assert_eq!(value(&watched.values(), "ba.degas-status").lost_at, None);
    }

    /// The parameters of the hot cathode whose turn is at `now`.
    fn turns(watched: &mut WatchedParameters, now: Instant) -> Vec<&'static str> {
        let all = std::iter::from_fn(|| watched.takes_turn(now)).map(|named| named.name.as_str());
        all.filter(|name| name.starts_with("ba.")).collect()
    }

    #[test]
    fn while_a_degas_runs_its_status_and_the_emission_are_read_again_before_they_are_stale() {
        let begin = Instant::now();
        let mut watched = read_at("bcg450", begin);
        let named = |watched: &WatchedParameters, name: &str| {
            watched.list.iter().find(|it| it.parameter.name == name).unwrap().parameter
        };
        let (emission, degas) = (named(&watched, "ba.emission-status"), named(&watched, "ba.degas-status"));
        let reads = |watched: &mut WatchedParameters, number, now| {
            for parameter in [emission, degas] {
                watched.take(parameter, Some(WatchedParameter { number, ..read_value(parameter) }), decided(now));
            }
        };
        reads(&mut watched, Some(3.0), begin);
        let mut now = begin;
        for _ in 0..9 {
            assert_eq!(turns(&mut watched, now + DEGAS_INTERVAL / 2), Vec::<&str>::new());
            now += DEGAS_INTERVAL;
            watched.expire(decided(now));
            let values = watched.values();
            assert!([emission, degas].iter().all(|it| value(&values, &it.name).quality == Quality::Valid));
            assert_eq!(turns(&mut watched, now), ["ba.emission-status", "ba.degas-status"]);
            reads(&mut watched, Some(3.0), now);
        }
        // An answer that is missing does not end it, a degas that is off does.
        now += DEGAS_INTERVAL;
        assert_eq!(turns(&mut watched, now).len(), 2);
        watched.take(degas, None, decided(now));
        now += DEGAS_INTERVAL;
        assert_eq!(turns(&mut watched, now).len(), 2);
        reads(&mut watched, Some(0.0), now);
        assert_eq!(turns(&mut watched, now + VALID_FOR), Vec::<&str>::new(), "the selector is moved seldom");
        // A degas that does not end.
        reads(&mut watched, Some(3.0), now);
        reads(&mut watched, Some(3.0), now + LONGEST_DEGAS - DEGAS_INTERVAL);
        assert_eq!(turns(&mut watched, now + LONGEST_DEGAS).len(), 2);
        reads(&mut watched, Some(3.0), now + LONGEST_DEGAS);
        assert_eq!(turns(&mut watched, now + LONGEST_DEGAS + VALID_FOR), Vec::<&str>::new());
    }

    #[test]
    fn an_emission_that_was_off_is_stale_when_the_hot_cathode_measures() {
        let now = Instant::now();
        let mut watched = read_at("bcg450", now);
        watched.emission_is_on(Moment { at: now, wall: Micros(7) });
        assert_eq!(value(&watched.values(), "ba.emission-status").quality, Quality::Valid, "read after the exchange");
        watched.emission_is_on(Moment { at: now, wall: Micros(8) });
        let values = watched.values();
        let stale: Vec<_> = values.iter().filter(|value| value.quality == Quality::Stale).collect();
        let stale: Vec<_> = stale.iter().map(|value| (value.target.as_str(), value.read_at, value.lost_at)).collect();
        assert_eq!(stale, [("ba.emission-status", Some(Micros(7)), Some(Micros(8)))]);

        let mut watched = read_at("bcg450", now);
        let emission = watched.list.iter().find(|it| it.parameter.name == "ba.emission-status").unwrap().parameter;
        watched.take(emission, Some(WatchedParameter { number: Some(2.0), ..read_value(emission) }), decided(now));
        watched.emission_is_on(Moment { at: now, wall: Micros(8) });
        assert!(watched.values().iter().all(|value| value.quality == Quality::Valid), "it is on");
    }

    #[test]
    fn what_an_operation_wrote_is_read_first_and_its_old_value_is_not_valid() {
        let now = Instant::now();
        let mut watched = read_at("bcg450", now);
        let later = now + Duration::from_secs(1);
        let all = ParameterNames::shared(model_named("bcg450").unwrap()).all();
        let named = |name: &str| all.iter().find(|named| named.name == name).unwrap();
        watched.changed(named("setpoint-b.percentage-of-atmosphere"), decided(later));
        let is_valid =
            |watched: &WatchedParameters, name: &str| value(&watched.values(), name).quality == Quality::Valid;
        assert!(!is_valid(&watched, "setpoint-b.percentage-of-atmosphere"));
        assert!(is_valid(&watched, "setpoint-a.percentage-of-atmosphere"));
        assert!(is_valid(&watched, "ba.emission-status"), "of another block");
        let overdue = Due { is_usual: true, at: now };
        assert!(watched.due().unwrap() < overdue, "before the parameters of all other gauges");
        let first: Vec<_> = std::iter::from_fn(|| watched.takes_turn(later)).map(|named| named.name.as_str()).collect();
        assert!(first[..5].contains(&"setpoint-b.percentage-of-atmosphere"), "{first:?}");
        assert!(first[..5].iter().all(|name| name.starts_with("setpoint-b.")), "{first:?}");
        assert_eq!(first.len(), watched.list.len(), "all are read again");

        let mut watched = read_at("bcg450", now);
        watched.changed(named("ba.hot-cathode-block-state-command"), decided(later));
        let first: Vec<_> = std::iter::from_fn(|| watched.takes_turn(later)).map(|named| named.name.as_str()).collect();
        assert_eq!(first[..2], ["ba.emission-status", "ba.degas-status"], "a command has no value of its own");
        assert!(!is_valid(&watched, "ba.emission-status") && !is_valid(&watched, "ba.degas-status"));
        assert_eq!(turns(&mut watched, later + INTERVAL), first[..2], "once more, when the gauge has executed it");
        assert_eq!(turns(&mut watched, later + VALID_FOR), Vec::<&str>::new(), "the selector is moved seldom");
    }
}
