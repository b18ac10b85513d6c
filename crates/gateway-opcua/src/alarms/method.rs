//! The methods of a condition.

use super::fields::SHELVING;
use opcua_types::{DataTypeId, MethodId, NodeId};

/// A method of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Acknowledges the alarm.
    Acknowledge,
    /// Adds a comment, which the station does not keep.
    AddComment,
    /// Conditions are always enabled.
    Enable,
    /// A client disables no alarm.
    Disable,
    /// Shelves the alarm for a time.
    TimedShelve,
    /// The same with the reason.
    TimedShelve2,
    /// The type demands it, and the station has no shelving without an end.
    OneShotShelve,
    /// Unshelves the alarm.
    Unshelve,
    /// Sends the conditions that stand to one subscription.
    Refresh,
    /// The same to one monitored item.
    Refresh2,
}

/// An argument of a method: its name, its type and a description.
pub type MethodArgument = (&'static str, DataTypeId, &'static str);

const EVENT: MethodArgument = ("EventId", DataTypeId::ByteString, "The event that the user has seen");
const COMMENT: MethodArgument = ("Comment", DataTypeId::LocalizedText, "Not kept by the station");
const REASON: MethodArgument = ("Comment", DataTypeId::LocalizedText, "The reason");
const TIME: MethodArgument =
    ("ShelvingTime", DataTypeId::Duration, "The time in milliseconds, from a minute to MaxTimeShelved");
const SUBSCRIPTION: MethodArgument = ("SubscriptionId", DataTypeId::UInt32, "The subscription");
const ITEM: MethodArgument = ("MonitoredItemId", DataTypeId::UInt32, "The item of events");

impl Method {
    /// The methods that an instance has, with the path of each.
    pub(super) const ON_INSTANCE: [(Self, &'static str); 8] = [
        (Self::Acknowledge, "Acknowledge"),
        (Self::AddComment, "AddComment"),
        (Self::Enable, "Enable"),
        (Self::Disable, "Disable"),
        (Self::TimedShelve, "ShelvingState/TimedShelve"),
        (Self::TimedShelve2, "ShelvingState/TimedShelve2"),
        (Self::OneShotShelve, "ShelvingState/OneShotShelve"),
        (Self::Unshelve, "ShelvingState/Unshelve"),
    ];

    /// The method with this identifier of OPC UA. Clients call it with a condition, or its state of shelving, as the object.
    #[must_use]
    pub fn of_type(id: &NodeId) -> Option<Self> {
        Some(match id.as_method_id().ok()? {
            MethodId::AcknowledgeableConditionType_Acknowledge => Self::Acknowledge,
            MethodId::ConditionType_AddComment => Self::AddComment,
            MethodId::ConditionType_Enable => Self::Enable,
            MethodId::ConditionType_Disable => Self::Disable,
            MethodId::ConditionType_ConditionRefresh => Self::Refresh,
            MethodId::ConditionType_ConditionRefresh2 => Self::Refresh2,
            MethodId::ShelvedStateMachineType_TimedShelve | MethodId::AlarmConditionType_ShelvingState_TimedShelve => {
                Self::TimedShelve
            }
            MethodId::ShelvedStateMachineType_TimedShelve2
            | MethodId::AlarmConditionType_ShelvingState_TimedShelve2 => Self::TimedShelve2,
            MethodId::ShelvedStateMachineType_OneShotShelve
            | MethodId::AlarmConditionType_ShelvingState_OneShotShelve => Self::OneShotShelve,
            MethodId::ShelvedStateMachineType_Unshelve | MethodId::AlarmConditionType_ShelvingState_Unshelve => {
                Self::Unshelve
            }
            _ => return None,
        })
    }

    /// The method of an instance with this node.
    pub(super) fn of_instance(id: &NodeId) -> Option<Self> {
        let opcua_types::Identifier::String(text) = &id.identifier else { return None };
        let (object, name) = text.as_ref().rsplit_once('/')?;
        let is_shelving = object.rsplit_once('/').is_some_and(|(_, object)| object == SHELVING);
        let path = if is_shelving { format!("{SHELVING}/{name}") } else { name.to_owned() };
        Self::ON_INSTANCE.iter().find(|(_, own)| *own == path).map(|(method, _)| *method)
    }

    /// Its arguments.
    pub(super) const fn arguments(self) -> &'static [MethodArgument] {
        match self {
            Self::Acknowledge => &[EVENT, COMMENT],
            Self::AddComment => &[EVENT, COMMENT],
            Self::Enable | Self::Disable | Self::OneShotShelve | Self::Unshelve => &[],
            Self::TimedShelve => &[TIME],
            Self::TimedShelve2 => &[TIME, REASON],
            Self::Refresh => &[SUBSCRIPTION],
            Self::Refresh2 => &[SUBSCRIPTION, ITEM],
        }
    }
}
