//! The fields of a condition: in its events and, but for the last ones, as nodes of its instance.

use opcua_types::{DataTypeId, NodeId, ObjectTypeId};

/// The types of which a condition is an instance, beside the base type of events.
pub const TYPES: [ObjectTypeId; 3] =
    [ObjectTypeId::ConditionType, ObjectTypeId::AcknowledgeableConditionType, ObjectTypeId::AlarmConditionType];

/// The object that holds the state of shelving and its methods.
pub const SHELVING: &str = "ShelvingState";

/// What a field of a condition is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A property.
    Property,
    /// A variable with two states, which has `Id` as a property.
    TwoState,
    /// The present state of a state machine, which has the node of the state as `Id`.
    Current,
    /// A variable with the time since when it holds.
    Timed,
}

impl Role {
    /// The field of a field: what tells the state for programs, or since when it holds.
    pub const fn second(self) -> Option<(&'static str, DataTypeId)> {
        match self {
            Self::Property => None,
            Self::TwoState => Some(("Id", DataTypeId::Boolean)),
            Self::Current => Some(("Id", DataTypeId::NodeId)),
            Self::Timed => Some(("SourceTimestamp", DataTypeId::UtcTime)),
        }
    }
}

/// A field: its path below the condition, its role, and the type of its value.
pub type Field = (&'static str, Role, DataTypeId);

/// The mandatory fields of `AlarmConditionType`, `SuppressedState`, `OutOfServiceState`, and those of shelving.
pub const FIELDS: [Field; 31] = [
    ("EventId", Role::Property, DataTypeId::ByteString),
    ("EventType", Role::Property, DataTypeId::NodeId),
    ("SourceNode", Role::Property, DataTypeId::NodeId),
    ("SourceName", Role::Property, DataTypeId::String),
    ("Time", Role::Property, DataTypeId::UtcTime),
    ("ReceiveTime", Role::Property, DataTypeId::UtcTime),
    ("Message", Role::Property, DataTypeId::LocalizedText),
    ("Severity", Role::Property, DataTypeId::UInt16),
    ("ConditionClassId", Role::Property, DataTypeId::NodeId),
    ("ConditionClassName", Role::Property, DataTypeId::LocalizedText),
    ("ConditionName", Role::Property, DataTypeId::String),
    ("BranchId", Role::Property, DataTypeId::NodeId),
    ("Retain", Role::Property, DataTypeId::Boolean),
    ("EnabledState", Role::TwoState, DataTypeId::LocalizedText),
    ("Quality", Role::Timed, DataTypeId::StatusCode),
    ("LastSeverity", Role::Timed, DataTypeId::UInt16),
    ("Comment", Role::Timed, DataTypeId::LocalizedText),
    ("ClientUserId", Role::Property, DataTypeId::String),
    ("AckedState", Role::TwoState, DataTypeId::LocalizedText),
    ("ActiveState", Role::TwoState, DataTypeId::LocalizedText),
    ("InputNode", Role::Property, DataTypeId::NodeId),
    ("SuppressedState", Role::TwoState, DataTypeId::LocalizedText),
    ("SuppressedOrShelved", Role::Property, DataTypeId::Boolean),
    ("OutOfServiceState", Role::TwoState, DataTypeId::LocalizedText),
    ("ShelvingState/CurrentState", Role::Current, DataTypeId::LocalizedText),
    ("ShelvingState/UnshelveTime", Role::Property, DataTypeId::Duration),
    ("MaxTimeShelved", Role::Property, DataTypeId::Duration),
    // Of events alone; an instance need not have them.
    ("LocalTime", Role::Property, DataTypeId::TimeZoneDataType),
    ("ConditionSubClassId", Role::Property, DataTypeId::NodeId),
    ("ConditionSubClassName", Role::Property, DataTypeId::LocalizedText),
    ("SupportsFilteredRetain", Role::Property, DataTypeId::Boolean),
];

/// The fields that an instance has.
pub fn of_instance() -> impl Iterator<Item = &'static Field> {
    const ON_INSTANCE: usize = 27;
    FIELDS.iter().take(ON_INSTANCE)
}

/// The text of an identifier of the station's namespace.
pub fn text_of(id: &NodeId) -> &str {
    match &id.identifier {
        opcua_types::Identifier::String(text) => text.as_ref(),
        _ => "",
    }
}

/// The node at a path below another one.
pub fn below(node: &NodeId, path: &str) -> NodeId {
    NodeId::new(node.namespace, format!("{}/{path}", text_of(node)))
}
