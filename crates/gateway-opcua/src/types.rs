//! The types of DI (OPC 10000-100) and PA-DIM (OPC 30081) that the nodes of the station have.
//!
//! The two specifications are not loaded whole: these are the types that are used, with the identifiers and the mandatory members that
//! the specifications give them. The namespaces are marked as subsets.

use opcua_server::address_space::{
    AddressSpace, DataTypeBuilder, ObjectBuilder, ObjectTypeBuilder, ReferenceDirection, VariableBuilder,
    VariableTypeBuilder,
};
use opcua_types::{
    DataTypeId, LocalizedText, NodeId, ObjectId, ObjectTypeId, QualifiedName, ReferenceTypeId, VariableTypeId, Variant,
    VariantScalarTypeId,
};

/// The namespace of DI.
pub const DI: &str = "http://opcfoundation.org/UA/DI/";

/// The namespace of PA-DIM.
pub const PA_DIM: &str = "http://opcfoundation.org/UA/PADIM/";

/// The words of `DeviceHealthEnumeration`, by number.
pub const HEALTH: [&str; 5] = ["NORMAL", "FAILURE", "CHECK_FUNCTION", "OFF_SPEC", "MAINTENANCE_REQUIRED"];

/// The specification that gives a node its name or its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Specification {
    /// The station itself.
    Station,
    /// DI.
    Di,
    /// PA-DIM.
    PaDim,
}

/// The indexes of the namespaces in this server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Namespaces {
    /// Of the station.
    pub station: u16,
    /// Of DI.
    pub di: u16,
    /// Of PA-DIM.
    pub pa_dim: u16,
}

impl Namespaces {
    /// The index of a specification.
    #[must_use]
    pub const fn index(self, specification: Specification) -> u16 {
        match specification {
            Specification::Station => self.station,
            Specification::Di => self.di,
            Specification::PaDim => self.pa_dim,
        }
    }

    const fn di_node(self, number: u32) -> NodeId {
        NodeId { namespace: self.di, identifier: opcua_types::Identifier::Numeric(number) }
    }

    const fn pa_dim_node(self, number: u32) -> NodeId {
        NodeId { namespace: self.pa_dim, identifier: opcua_types::Identifier::Numeric(number) }
    }

    /// `DeviceSet` of DI, which is below `Objects` in every server of devices.
    #[must_use]
    pub const fn device_set(self) -> NodeId {
        self.di_node(5001)
    }

    /// The data type of `DeviceHealth`.
    #[must_use]
    pub const fn health_type(self) -> NodeId {
        self.di_node(6244)
    }

    /// The type of the value of a pressure.
    #[must_use]
    pub const fn pressure_type(self) -> NodeId {
        self.pa_dim_node(1121)
    }

    /// The type of an object.
    #[must_use]
    pub fn object_type(self, kind: ObjectKind) -> NodeId {
        match kind {
            ObjectKind::Plain | ObjectKind::Alarm => ObjectTypeId::BaseObjectType.into(),
            ObjectKind::Device => self.di_node(1002),
            ObjectKind::Group => self.di_node(1005),
            ObjectKind::Signals => self.pa_dim_node(1021),
            ObjectKind::Signal => self.pa_dim_node(1022),
        }
    }
}

/// What an object is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectKind {
    /// `BaseObjectType`.
    Plain,
    /// `DeviceType` of DI.
    Device,
    /// `FunctionalGroupType` of DI.
    Group,
    /// `SignalSetType` of PA-DIM.
    Signals,
    /// `AnalogSignalType` of PA-DIM.
    Signal,
    /// An alarm, which has a condition; of `BaseObjectType`.
    Alarm,
}

/// A mandatory property of `DeviceType`, with the number of its declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NameplateRow {
    /// The browse name.
    pub name: &'static str,
    /// The number of the declaration in DI.
    number: u32,
    /// The type of its value.
    data_type: DataTypeId,
}

/// The nameplate of a device (DI, `DeviceType`).
pub const NAMEPLATE: [NameplateRow; 8] = [
    NameplateRow { name: "SerialNumber", number: 6001, data_type: DataTypeId::String },
    NameplateRow { name: "RevisionCounter", number: 6002, data_type: DataTypeId::Int32 },
    NameplateRow { name: "Manufacturer", number: 6003, data_type: DataTypeId::LocalizedText },
    NameplateRow { name: "Model", number: 6004, data_type: DataTypeId::LocalizedText },
    NameplateRow { name: "DeviceManual", number: 6005, data_type: DataTypeId::String },
    NameplateRow { name: "DeviceRevision", number: 6006, data_type: DataTypeId::String },
    NameplateRow { name: "SoftwareRevision", number: 6007, data_type: DataTypeId::String },
    NameplateRow { name: "HardwareRevision", number: 6008, data_type: DataTypeId::String },
];

/// An object type: its number, name, the number of its parent in the same specification, and whether it is abstract.
type TypeRow = (u32, &'static str, Option<u32>, bool);

const DI_TYPES: [TypeRow; 4] = [
    (1001, "TopologyElementType", None, true),
    (15063, "ComponentType", Some(1001), true),
    (1002, "DeviceType", Some(15063), true),
    (1005, "FunctionalGroupType", None, false),
];

const PA_DIM_TYPES: [TypeRow; 3] = [
    (1021, "SignalSetType", None, false),
    (1008, "SignalType", None, false),
    (1022, "AnalogSignalType", Some(1008), false),
];

/// Inserts the types and `DeviceSet`.
pub fn insert(namespaces: Namespaces, space: &mut AddressSpace) {
    for row in DI_TYPES {
        insert_type(row, namespaces.di, space);
    }
    for row in PA_DIM_TYPES {
        insert_type(row, namespaces.pa_dim, space);
    }
    insert_health_type(namespaces, space);
    insert_signal_types(namespaces, space);
    for row in NAMEPLATE {
        let value = if row.data_type == DataTypeId::Int32 { Variant::Int32(-1) } else { Variant::Empty };
        declare(&namespaces.di_node(row.number), QualifiedName::new(namespaces.di, row.name))
            .data_type(row.data_type)
            .value(value)
            .has_type_definition(VariableTypeId::PropertyType)
            .property_of(namespaces.object_type(ObjectKind::Device))
            .insert(space);
    }
    ObjectBuilder::new(&namespaces.device_set(), QualifiedName::new(namespaces.di, "DeviceSet"), "DeviceSet")
        .has_type_definition(ObjectTypeId::BaseObjectType)
        .organized_by(ObjectId::ObjectsFolder)
        .insert(space);
}

fn insert_type((number, name, parent, is_abstract): TypeRow, namespace: u16, space: &mut AddressSpace) {
    let parent = parent.map_or_else(|| ObjectTypeId::BaseObjectType.into(), |number| NodeId::new(namespace, number));
    ObjectTypeBuilder::new(&NodeId::new(namespace, number), QualifiedName::new(namespace, name), name)
        .is_abstract(is_abstract)
        .subtype_of(parent)
        .insert(space);
}

/// The declaration of a mandatory member of a type.
fn declare(id: &NodeId, name: QualifiedName) -> VariableBuilder {
    let display = name.name.to_string();
    VariableBuilder::new(id, name, display).reference(
        ObjectId::ModellingRule_Mandatory,
        ReferenceTypeId::HasModellingRule,
        ReferenceDirection::Forward,
    )
}

fn insert_health_type(namespaces: Namespaces, space: &mut AddressSpace) {
    let id = namespaces.health_type();
    let name = "DeviceHealthEnumeration";
    DataTypeBuilder::new(&id, QualifiedName::new(namespaces.di, name), name)
        .subtype_of(DataTypeId::Enumeration)
        .insert(space);
    VariableBuilder::new(&namespaces.di_node(6450), QualifiedName::new(0, "EnumStrings"), "EnumStrings")
        .data_type(DataTypeId::LocalizedText)
        .value_rank(1)
        .value(texts(&HEALTH))
        .has_type_definition(VariableTypeId::PropertyType)
        .property_of(id)
        .insert(space);
}

/// `AnalogSignalVariableType`, `PressureMeasurementVariableType`, and the members of the types of signals.
fn insert_signal_types(namespaces: Namespaces, space: &mut AddressSpace) {
    let analog = namespaces.pa_dim_node(1111);
    let rows = [
        (analog.clone(), "AnalogSignalVariableType", VariableTypeId::AnalogUnitRangeType.into(), DataTypeId::Number),
        (namespaces.pressure_type(), "PressureMeasurementVariableType", analog.clone(), DataTypeId::Float),
    ];
    for (id, name, parent, data_type) in rows {
        VariableTypeBuilder::new(&id, QualifiedName::new(namespaces.pa_dim, name), name)
            .data_type(data_type)
            .value_rank(-2)
            .subtype_of(parent)
            .insert(space);
    }
    declare(&namespaces.pa_dim_node(1027), QualifiedName::new(namespaces.pa_dim, "AnalogSignal"))
        .data_type(DataTypeId::Number)
        .has_type_definition(analog)
        .component_of(namespaces.object_type(ObjectKind::Signal))
        .insert(space);
    declare(&namespaces.pa_dim_node(1035), QualifiedName::new(namespaces.pa_dim, "SignalTag"))
        .data_type(DataTypeId::String)
        .has_type_definition(VariableTypeId::PropertyType)
        .property_of(namespaces.pa_dim_node(1008))
        .insert(space);
}

/// Words as an array of texts.
#[must_use]
pub fn texts(words: &[&str]) -> Variant {
    let words: Vec<Variant> = words.iter().map(|word| Variant::from(LocalizedText::new("", word))).collect();
    // All words have the type of the array.
    opcua_types::Array::new(VariantScalarTypeId::LocalizedText, words)
        .map_or(Variant::Empty, |array| Variant::Array(Box::new(array)))
}
