//! Alarms as the API and the dashboard show them. Times are milliseconds since 1970.

use super::plant_state::PlantState;
use super::registry::RegisteredAlarm;
use super::rule::{Condition, PointTest, Rule};
use crate::view::unix_ms;
use profivac_model::{AlarmState, AlarmStatus, ConditionKind, Declaration, Priority, Suppression, words};
use profivac_web_server::auth::Role;
use serde::Serialize;
use utoipa::ToSchema;

/// An alarm.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct AlarmView {
    /// The name.
    pub name: String,
    /// The kind of its condition.
    pub condition: ConditionKind,
    /// The gauge, if the alarm is about one.
    pub gauge: Option<String>,
    /// The measuring part, by the name under which it is recorded, if the alarm is about one.
    pub series: Option<String>,
    /// The point of a slave, if the alarm is about a limit of one. Gateways show the limit with the point.
    #[serde(skip)]
    pub point: Option<LimitedPoint>,
    /// The gauges, if the alarm is about several.
    pub several: Option<SeveralView>,
    /// The segment, if the alarm is about one.
    pub segment: Option<String>,
    /// How soon an operator must respond.
    pub priority: Priority,
    /// The state.
    pub state: AlarmState,
    /// The time of the last change; `null` if there was none.
    pub since_ms: Option<i64>,
    /// The number of the last occurrence, needed to acknowledge it; 0 if the alarm was never raised.
    pub occurrence: i64,
    /// When it was raised last.
    pub raised_ms: Option<i64>,
    /// The value that raised it.
    pub raised_value: Option<f64>,
    /// A sentence about why it was raised.
    pub text: String,
    /// The present value.
    pub value: Option<f64>,
    /// The limit.
    pub limit: Option<f64>,
    /// The value at which the condition ends.
    pub reset: Option<f64>,
    /// The unit of values and limits.
    pub unit: Option<&'static str>,
    /// The user who acknowledged it.
    pub acknowledged_by: Option<String>,
    /// When it was acknowledged.
    pub acknowledged_ms: Option<i64>,
    /// Why it is shelved; `null` unless it is.
    pub shelved: Option<SuppressionView>,
    /// Why it is out of service; `null` unless it is.
    pub out_of_service: Option<SuppressionView>,
    /// Which plant state suppresses it, and why; `null` unless one does.
    pub suppressed: Option<SuppressionView>,
    /// The instruction for the operator, from the station's file.
    pub message: Option<String>,
}

/// The gauges of an alarm about several, and the condition that `limit` of them must meet.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct SeveralView {
    /// The measuring parts, by the names under which they are recorded.
    pub series: Vec<String>,
    /// The condition of each.
    pub condition: LimitKind,
    /// The limit of each.
    pub limit: Option<f64>,
    /// The unit of the limit.
    pub unit: Option<&'static str>,
}

words! {
    /// The condition of each gauge of an alarm about several.
    pub enum LimitKind {
        /// The pressure is above the limit.
        Above = "above",
        /// The pressure is below the limit.
        Below = "below",
        /// The pressure rises quickly.
        Rise = "rise",
    }
}

impl LimitKind {
    const fn of(condition: &Condition) -> Option<Self> {
        match condition {
            Condition::Above { .. } => Some(Self::Above),
            Condition::Below { .. } => Some(Self::Below),
            Condition::Rise { .. } => Some(Self::Rise),
            _ => None,
        }
    }
}

/// A point of a slave with a limit.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct LimitedPoint {
    /// The name of the point.
    pub name: String,
    /// On which side of the limit the alarm is raised.
    pub side: LimitKind,
}

impl LimitedPoint {
    fn of(condition: &Condition) -> Option<Self> {
        let Condition::Point { point, test, .. } = condition else { return None };
        let side = match test {
            PointTest::Above { .. } => LimitKind::Above,
            PointTest::Below { .. } => LimitKind::Below,
            PointTest::Is(_) => return None,
        };
        Some(Self { name: point.clone(), side })
    }
}

impl SeveralView {
    fn of(condition: &Condition) -> Option<Self> {
        let Condition::Several { conditions, .. } = condition else { return None };
        let first = conditions.first()?;
        let series = condition.all_series().into_iter().map(|series| series.name.clone()).collect();
        Some(Self { series, condition: LimitKind::of(first)?, limit: first.limit(), unit: first.unit() })
    }
}

/// Why an alarm is shelved, out of service or suppressed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct SuppressionView {
    /// The user who shelved it, took it out of service, or declared the plant state that suppresses it.
    pub user: String,
    /// When.
    pub at_ms: i64,
    /// The reason; of a plant state with its name before it.
    pub reason: String,
    /// When it ends by itself; `null` if a user must return it to service.
    pub until_ms: Option<i64>,
}

impl AlarmView {
    /// The alarm of a rule that was never evaluated.
    #[must_use]
    pub fn planned(rule: &Rule) -> Self {
        Self::of(rule, &AlarmStatus::default(), None)
    }

    fn of(rule: &Rule, status: &AlarmStatus, value: Option<f64>) -> Self {
        let condition = &rule.condition;
        let acknowledged = status.acknowledged.as_ref().filter(|_| status.state != AlarmState::Unacknowledged);
        let suppression_in = |state: AlarmState| {
            let suppression = status.suppression.as_ref().filter(|_| status.state == state);
            suppression.map(SuppressionView::from)
        };
        let has_changed = status.occurrence > 0 || status.state != AlarmState::Normal;
        Self {
            name: rule.name.clone(),
            condition: condition.kind(),
            gauge: condition.gauge().map(str::to_owned),
            series: condition.series().map(|series| series.name.clone()),
            point: LimitedPoint::of(condition),
            several: SeveralView::of(condition),
            segment: condition.segment().map(str::to_owned),
            priority: rule.priority,
            state: status.state,
            since_ms: has_changed.then(|| unix_ms(status.since)),
            occurrence: status.occurrence,
            raised_ms: status.raised.map(unix_ms),
            raised_value: status.value,
            text: status.text.clone(),
            value,
            limit: condition.limit(),
            reset: condition.reset(),
            unit: condition.unit(),
            acknowledged_by: acknowledged.map(|by| by.user.clone()),
            acknowledged_ms: acknowledged.map(|by| unix_ms(by.at)),
            shelved: suppression_in(AlarmState::Shelved),
            out_of_service: suppression_in(AlarmState::OutOfService),
            suppressed: suppression_in(AlarmState::Suppressed),
            message: rule.message.clone(),
        }
    }
}

impl From<&Suppression> for SuppressionView {
    fn from(Suppression { by, reason, until }: &Suppression) -> Self {
        let until_ms = until.map(unix_ms);
        Self { user: by.user.clone(), at_ms: unix_ms(by.at), reason: reason.clone(), until_ms }
    }
}

impl From<&RegisteredAlarm> for AlarmView {
    fn from(alarm: &RegisteredAlarm) -> Self {
        Self::of(alarm.rule(), alarm.status(), alarm.value())
    }
}

/// A plant state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlantStateView {
    /// The name.
    pub name: String,
    /// A sentence about it, from the station's file.
    pub description: Option<String>,
    /// The longest time in minutes for which it is declared or extended.
    pub longest_minutes: u64,
    /// The lowest role that declares and extends it.
    pub role: Role,
    /// The names of the alarms that it suppresses while it is declared.
    pub alarms: Vec<String>,
    /// Its declaration; `null` unless it is declared.
    pub declared: Option<DeclaredPlantState>,
}

/// A declared plant state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct DeclaredPlantState {
    /// The name of the plant state.
    pub name: String,
    /// The user who declared it.
    pub user: String,
    /// When.
    pub at_ms: i64,
    /// The reason of the declaration, or of the last extension.
    pub reason: String,
    /// When it ends by itself.
    pub until_ms: i64,
}

impl DeclaredPlantState {
    fn of(state: &PlantState) -> Option<Self> {
        let Declaration { by, reason, until } = state.declaration()?;
        let (name, user) = (state.rule().name.clone(), by.user.clone());
        Some(Self { name, user, at_ms: unix_ms(by.at), reason: reason.clone(), until_ms: unix_ms(*until) })
    }
}

impl From<&PlantState> for PlantStateView {
    fn from(state: &PlantState) -> Self {
        let rule = state.rule();
        Self {
            name: rule.name.clone(),
            description: rule.description.clone(),
            longest_minutes: rule.longest.as_secs() / 60,
            role: rule.role,
            alarms: rule.alarms.iter().cloned().collect(),
            declared: DeclaredPlantState::of(state),
        }
    }
}

/// The number of alarms of a priority.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct AlarmCount {
    /// Alarms whose condition is met.
    pub active: usize,
    /// Alarms that wait for an acknowledgement, whether their condition is still met or not.
    pub unacknowledged: usize,
}

/// The alarms at one moment.
#[derive(Clone, Debug)]
pub struct AlarmsNow {
    /// Their numbers.
    pub overview: AlarmOverview,
    /// The alarms that are neither normal nor shelved nor out of service nor suppressed, the most urgent first.
    pub standing: Vec<AlarmView>,
}

impl AlarmsNow {
    /// The alarms with these states.
    #[must_use]
    pub fn of(alarms: &[RegisteredAlarm], plant_states: &[PlantState], problem: Option<String>) -> Self {
        let mut standing: Vec<_> =
            alarms.iter().filter(|alarm| is_standing(alarm.status().state)).map(AlarmView::from).collect();
        standing.sort_by(by_urgency);
        Self { overview: AlarmOverview::of(alarms, plant_states, problem), standing }
    }
}

/// The alarms at one moment, in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct AlarmOverview {
    /// Why this overview may be wrong: the alarms were not evaluated for a while, or cannot be stored.
    pub problem: Option<String>,
    /// Alarms of high priority.
    pub high: AlarmCount,
    /// Alarms of medium priority.
    pub medium: AlarmCount,
    /// Alarms of low priority.
    pub low: AlarmCount,
    /// The number of shelved alarms.
    pub shelved: usize,
    /// The number of alarms out of service.
    pub out_of_service: usize,
    /// The number of alarms that a plant state suppresses.
    pub suppressed: usize,
    /// The declared plant states, in the order of the station's file.
    pub plant_states: Vec<DeclaredPlantState>,
}

impl AlarmOverview {
    /// The overview of these alarms.
    fn of(alarms: &[RegisteredAlarm], plant_states: &[PlantState], problem: Option<String>) -> Self {
        let plant_states = plant_states.iter().filter_map(DeclaredPlantState::of).collect();
        let mut overview = Self { problem, plant_states, ..Self::default() };
        for alarm in alarms {
            let state = alarm.status().state;
            let count = match alarm.rule().priority {
                Priority::High => &mut overview.high,
                Priority::Medium => &mut overview.medium,
                Priority::Low => &mut overview.low,
            };
            count.active = count.active.saturating_add(usize::from(state.is_active()));
            count.unacknowledged = count.unacknowledged.saturating_add(usize::from(state.needs_acknowledgement()));
            match state {
                AlarmState::Normal | AlarmState::Unacknowledged | AlarmState::Acknowledged | AlarmState::Returned => {}
                AlarmState::Shelved => overview.shelved = overview.shelved.saturating_add(1),
                AlarmState::OutOfService => overview.out_of_service = overview.out_of_service.saturating_add(1),
                AlarmState::Suppressed => overview.suppressed = overview.suppressed.saturating_add(1),
            }
        }
        overview
    }
}

/// Whether an alarm in this state is in the list of an operator.
const fn is_standing(state: AlarmState) -> bool {
    matches!(state, AlarmState::Unacknowledged | AlarmState::Acknowledged | AlarmState::Returned)
}

/// Active alarms come first; among these the highest priority, then unacknowledged ones, then the latest.
fn by_urgency(one: &AlarmView, other: &AlarmView) -> std::cmp::Ordering {
    let rank = |alarm: &AlarmView| {
        (alarm.state.is_active(), alarm.priority, alarm.state.needs_acknowledgement(), alarm.since_ms)
    };
    rank(other).cmp(&rank(one))
}
