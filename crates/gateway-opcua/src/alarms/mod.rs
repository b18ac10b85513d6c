//! Alarms as conditions (OPC 10000-9): an instance of `AlarmConditionType` for each alarm, an event for each change, `Acknowledge`,
//! shelving and `ConditionRefresh`.
//!
//! The library has events with filters, and no conditions. This module makes one from the points of an alarm:
//!
//! | State of the alarm | `ActiveState` | `AckedState` | `SuppressedState` | `OutOfServiceState` | `ShelvingState` | `Retain` |
//! |---|---|---|---|---|---|---|
//! | normal | Inactive | Acknowledged | Unsuppressed | In service | Unshelved | false |
//! | unacknowledged | Active | Unacknowledged | Unsuppressed | In service | Unshelved | true |
//! | acknowledged | Active | Acknowledged | Unsuppressed | In service | Unshelved | true |
//! | returned | Inactive | Unacknowledged | Unsuppressed | In service | Unshelved | true |
//! | out of service | Inactive | Acknowledged | Unsuppressed | Out of service | Unshelved | false |
//! | shelved | Inactive | Acknowledged | Unsuppressed | In service | TimedShelved | true |
//! | suppressed | Inactive | Acknowledged | Suppressed | In service | Unshelved | false |
//!
//! `SuppressedOrShelved` is true in the last three. A shelved alarm is retained, because a client that starts must find what it can
//! unshelve.
//!
//! | Module | Holds |
//! |---|---|
//! | `fields` | the fields of a condition |
//! | `condition` | an alarm as a condition and as an event |
//! | `rows` | which points are an alarm's |
//! | `nodes` | the instance in the address space |
//! | `method` | the methods of a condition |
//! | `conditions` | all conditions of the station, and their refresh |
//! | `calls` | what a call of a method does, and for whom |

mod calls;
mod condition;
mod conditions;
mod fields;
mod method;
mod nodes;
mod rows;

pub use condition::Condition;
pub use conditions::Conditions;
pub use method::Method;
pub use nodes::{delete, insert, register};

/// The library's name of a user who has not logged in; names of users are in lower case.
pub const ANONYMOUS: &str = "ANONYMOUS";

/// The severities of the priorities none, low, medium and high. chosen: the middle of the bands that OPC 10000-5 suggests.
const SEVERITIES: [u16; 4] = [1, 200, 500, 800];

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::condition::Condition;
    use super::conditions::{Conditions, MAX_REFRESHES, REFRESH_PAUSE};
    use super::fields::{Role, SHELVING, of_instance, text_of};
    use opcua_types::{ByteString, LocalizedText, NodeId, ObjectId, UAString, Variant};
    use profivac_gateway::Inputs;
    use profivac_gateway::model::Modeller;
    use profivac_recorder::Micros;
    use profivac_station::alarm::AlarmState;
    use profivac_station::alarm::view::SuppressionView;
    use profivac_station::gateway_status::GatewayStatuses;
    use std::path::Path;
    use std::sync::Arc;
    use std::time::Instant;

    const PLANT: &str = r#"
        [[segment]]
        name = "hall"
        port = "sim:hall.toml"
        [[segment.gauge]]
        name = "chamber"
        address = 5
        device = "bcg450"
        [[alarm]]
        name = "a/b"
        gauge = "chamber"
        above = "1e-3 mbar"
        priority = "high"
    "#;

    fn inputs() -> Inputs {
        Inputs::planned(&profivac_config::parse(PLANT, Path::new("plant.toml")).unwrap())
    }

    fn with(state: AlarmState, occurrence: i64) -> Inputs {
        let mut inputs = inputs();
        let alarm = inputs.alarms.iter_mut().find(|alarm| alarm.name == "a/b").unwrap();
        (alarm.state, alarm.occurrence) = (state, occurrence);
        inputs
    }

    fn conditions() -> Conditions {
        Conditions::new(GatewayStatuses::default().add("opcua"), None)
    }

    fn condition(state: AlarmState, occurrence: i64) -> Arc<Condition> {
        let snapshot = Modeller::default().next(with(state, occurrence), Micros(1));
        let changed = conditions().update(2, &snapshot, None);
        changed.into_iter().find(|it| &*it.alarm == "a/b").unwrap()
    }

    #[test]
    fn the_states_of_an_alarm_are_those_of_the_table() {
        for (state, row) in [
            (AlarmState::Normal, [false, true, false, false, false, false, false]),
            (AlarmState::Unacknowledged, [true, false, false, false, false, false, true]),
            (AlarmState::Acknowledged, [true, true, false, false, false, false, true]),
            (AlarmState::Returned, [false, false, false, false, false, false, true]),
            (AlarmState::OutOfService, [false, true, false, true, false, true, false]),
            (AlarmState::Shelved, [false, true, false, false, true, true, true]),
            (AlarmState::Suppressed, [false, true, true, false, false, true, false]),
        ] {
            let condition = condition(state, 1);
            let current = condition.field(&[SHELVING, "CurrentState", "Id"]).unwrap();
            let is_shelved = current == Variant::from(NodeId::from(ObjectId::ShelvedStateMachineType_TimedShelved));
            let is = |path: &[&str]| condition.field(path) == Some(Variant::Boolean(true));
            let found = [
                is(&["ActiveState", "Id"]),
                is(&["AckedState", "Id"]),
                is(&["SuppressedState", "Id"]),
                is(&["OutOfServiceState", "Id"]),
                is_shelved,
                is(&["SuppressedOrShelved"]),
                is(&["Retain"]),
            ];
            assert_eq!(found, row, "{state:?}");
        }
    }

    /// The text of the alarm says why it was raised, which is no longer so.
    #[test]
    fn the_message_of_an_alarm_that_is_not_active_does_not_say_why_it_was_raised() {
        for (state, expected) in [
            (AlarmState::Normal, "a/b: the condition is not met"),
            (AlarmState::Returned, "a/b: the condition is not met"),
            (AlarmState::OutOfService, "a/b: out of service"),
            (AlarmState::Suppressed, "a/b: suppressed"),
        ] {
            let raised = Condition { text: "a/b shows 7 mbar".to_owned(), ..(*condition(state, 1)).clone() };
            assert_eq!(raised.field(&["Message"]), Some(Variant::from(LocalizedText::new("", expected))), "{state:?}");
        }
        let raised =
            Condition { text: "a/b shows 7 mbar".to_owned(), ..(*condition(AlarmState::Acknowledged, 1)).clone() };
        assert_eq!(raised.field(&["Message"]), Some(Variant::from(LocalizedText::new("", "a/b shows 7 mbar"))));
    }

    #[test]
    fn an_event_belongs_to_one_occurrence_of_one_alarm() {
        let (first, second) = (condition(AlarmState::Unacknowledged, 1), condition(AlarmState::Unacknowledged, 2));
        assert_eq!(second.occurrence_of(&first.event_id()), Some(1));
        assert_ne!(first.event_id(), second.event_id());
        let other = Condition { alarm: Arc::from("other"), ..(*first).clone() };
        assert_eq!(other.occurrence_of(&first.event_id()), None);
        for octets in [vec![], vec![0; 8], vec![0; 18], vec![0xFF; 5000]] {
            assert_eq!(first.occurrence_of(&ByteString::from(octets)), None);
        }
        assert_eq!(first.occurrence_of(&ByteString::null()), None);
    }

    #[test]
    fn only_alarms_that_differ_are_told_and_removed_ones_are_gone() {
        let (mut modeller, conditions) = (Modeller::default(), conditions());
        let first = modeller.next(with(AlarmState::Normal, 0), Micros(1));
        assert_eq!(conditions.update(2, &first, None).len(), inputs().alarms.len());
        let same = modeller.next(with(AlarmState::Normal, 0), Micros(2));
        assert_eq!(conditions.update(2, &same, Some(&first)), []);
        let raised = modeller.next(with(AlarmState::Unacknowledged, 1), Micros(3));
        let told = conditions.update(2, &raised, Some(&same));
        assert_eq!(told.iter().map(|it| &*it.alarm).collect::<Vec<_>>(), ["a/b"]);
        let node = told.first().unwrap().node.clone();
        assert_eq!(text_of(&node), "alarm/a%2Fb/condition");
        let mut inputs = with(AlarmState::Unacknowledged, 1);
        inputs.alarms.retain(|alarm| alarm.name != "a/b");
        let without = modeller.next(inputs, Micros(4));
        assert_eq!(conditions.update(2, &without, Some(&raised)), []);
        assert!(conditions.find(&node).is_none());
    }

    #[test]
    fn a_subscription_is_refreshed_once_a_second_and_all_together_not_without_end() {
        let (conditions, now) = (conditions(), Instant::now());
        assert!(conditions.may_refresh(1, now));
        assert!(!conditions.may_refresh(1, now + REFRESH_PAUSE / 2));
        assert!(conditions.may_refresh(1, now + REFRESH_PAUSE));
        let granted = (2..100).filter(|id| conditions.may_refresh(*id, now + REFRESH_PAUSE)).count();
        assert_eq!(granted, MAX_REFRESHES - 1);
    }

    #[test]
    fn every_field_of_an_instance_has_a_value() {
        let condition = condition(AlarmState::Normal, 0);
        let nodes = |role: Role| 1 + usize::from(role.second().is_some());
        let expected: usize = of_instance().map(|(_, role, _)| nodes(*role)).sum();
        assert_eq!(condition.values().count(), expected);
    }

    #[test]
    fn the_time_until_an_alarm_is_unshelved_passes() {
        let mut inputs = with(AlarmState::Shelved, 1);
        let alarm = inputs.alarms.iter_mut().find(|alarm| alarm.name == "a/b").unwrap();
        let reason = "the lock is vented".to_owned();
        alarm.shelved = Some(SuppressionView { user: "ada".to_owned(), at_ms: 0, reason, until_ms: Some(90_000) });
        let (mut modeller, conditions) = (Modeller::default(), conditions());
        let shelved = modeller.next(inputs, Micros(1));
        let told = conditions.update(2, &shelved, None);
        let condition = told.iter().find(|it| &*it.alarm == "a/b").unwrap();
        assert_eq!(condition.field(&["ClientUserId"]), Some(Variant::from(UAString::from("ada"))));
        let comment = Variant::from(LocalizedText::new("", "the lock is vented"));
        assert_eq!(condition.field(&["Comment"]), Some(comment));
        for (now, milliseconds) in [(0, 90_000.0), (29_500_000, 61_000.0), (90_000_000, 0.0), (i64::MAX, 0.0)] {
            let node = NodeId::new(2, "alarm/a%2Fb/condition/ShelvingState/UnshelveTime");
            assert_eq!(conditions.countdowns(Micros(now)), [(node, Variant::Double(milliseconds))], "{now}");
        }
        let shelving = NodeId::new(2, "alarm/a%2Fb/condition/ShelvingState");
        assert_eq!(conditions.find(&shelving).as_ref(), Some(condition));
        let unshelved = modeller.next(with(AlarmState::Normal, 1), Micros(2));
        conditions.update(2, &unshelved, Some(&shelved));
        assert_eq!(conditions.countdowns(Micros(0)), []);
    }
}
