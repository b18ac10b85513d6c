//! The nodes of the plan in the address space of the server, and their values.

use crate::alarms;
use crate::plan::{self, DataType, History, Node, NodeKind, Parent, Property, Source};
use crate::types::{Namespaces, ObjectKind, Specification, texts};
use crate::value;
use opcua_server::address_space::{AddressSpace, ObjectBuilder, VariableBuilder};
use opcua_types::{
    DataTypeId, DataValue, EUInformation, ExtensionObject, LocalizedText, NodeId, ObjectId, ObjectTypeId,
    QualifiedName, Range, UAString, VariableTypeId, Variant,
};
use profivac_gateway::command::controlled_gauges;
use profivac_gateway::{Signal, Snapshot, Subject};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

/// The namespace of units (OPC 10000-8).
const UNITS: &str = "http://www.opcfoundation.org/UA/units/un/cefact";

/// A variable of the address space.
#[derive(Debug)]
struct Variable {
    id: NodeId,
    source: Source,
    data_type: DataType,
}

/// A parameter that users write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The gauge.
    pub gauge: Arc<str>,
    /// The parameter: `trip-point.1/high-trip-point`.
    pub target: Arc<str>,
    /// Whether the node is a pressure, a number or a text.
    pub signal: Signal,
}

/// The nodes that the address space has.
#[derive(Debug, Default)]
pub struct Space {
    namespaces: Namespaces,
    /// Whether users who log in may write.
    may_write: bool,
    parameters: HashMap<NodeId, Parameter>,
    nodes: Vec<Node>,
    variables: Vec<Variable>,
}

impl Space {
    /// No nodes yet; they will have these namespaces.
    #[must_use]
    pub fn new(namespaces: Namespaces, may_write: bool) -> Self {
        Self { namespaces, may_write, ..Self::default() }
    }

    /// The parameters that users write, by node.
    #[must_use]
    pub fn parameters(&self) -> HashMap<NodeId, Parameter> {
        self.parameters.clone()
    }

    fn writable(&self, nodes: &[Node], snapshot: &Snapshot) -> HashMap<NodeId, Parameter> {
        let gauges = if self.may_write { controlled_gauges(snapshot) } else { HashSet::new() };
        let parameter = |node: &Node| {
            let NodeKind::Variable { source: Source::Point(index), .. } = &node.kind else { return None };
            let point = snapshot.points.get(*index)?;
            let Subject::Parameter { gauge, target, .. } = &point.subject else { return None };
            let parameter = Parameter { gauge: Arc::clone(gauge), target: Arc::clone(target), signal: point.signal };
            (point.is_writable && gauges.contains(&**gauge)).then(|| (self.id(&node.id), parameter))
        };
        nodes.iter().filter_map(parameter).collect()
    }

    /// Changes the address space so that it has the nodes of these points. Nodes that stay are not touched, so their clients continue.
    pub fn update(&mut self, snapshot: &Snapshot, space: &mut AddressSpace) {
        let new = plan::nodes(&snapshot.points);
        self.parameters = self.writable(&new, snapshot);
        let old: BTreeMap<&str, &Node> = self.nodes.iter().map(|node| (node.id.as_str(), node)).collect();
        let kept: BTreeMap<&str, &Node> = new.iter().map(|node| (node.id.as_str(), node)).collect();
        for node in self.nodes.iter().filter(|old| kept.get(old.id.as_str()).is_none_or(|new| !is_same(old, new))) {
            self.delete(node, space);
        }
        for node in new.iter().filter(|new| old.get(new.id.as_str()).is_none_or(|old| !is_same(old, new))) {
            self.insert(node, space);
        }
        self.variables = new.iter().filter_map(|node| self.variable(node)).collect();
        self.nodes = new;
    }

    /// What the recorder keeps of the nodes that have a history, by the node.
    #[must_use]
    pub fn histories(&self) -> HashMap<NodeId, History> {
        let history = |node: &Node| match &node.kind {
            NodeKind::Variable { history: Some(history), .. } => Some((self.id(&node.id), history.clone())),
            NodeKind::Variable { .. } | NodeKind::Folder | NodeKind::Object(_) => None,
        };
        self.nodes.iter().filter_map(history).collect()
    }

    /// The variables that differ from those of the snapshot before, with their values; all without one.
    pub fn values<'a>(
        &'a self,
        snapshot: &'a Snapshot,
        before: Option<&'a Snapshot>,
    ) -> impl Iterator<Item = (&'a NodeId, DataValue)> {
        let before = before.filter(|before| before.has_points_of(snapshot));
        let differs = move |index: usize| {
            let (Some(new), Some(old)) = (snapshot.values.get(index), before.and_then(|it| it.values.get(index)))
            else {
                return true;
            };
            (new.version, new.at) != (old.version, old.at)
        };
        let variables = self.variables.iter().filter(move |variable| match &variable.source {
            Source::Point(index) | Source::Manufacturer(index) | Source::Model(index) => differs(*index),
            Source::Unknown | Source::Blank | Source::Fixed(_) => before.is_none(),
            Source::Health(points) | Source::DeviceState(points) => points.iter().any(|index| differs(*index)),
        });
        variables.filter_map(|it| Some((&it.id, value::data_value(&it.source, it.data_type, snapshot)?)))
    }

    fn id(&self, id: &str) -> NodeId {
        NodeId::new(self.namespaces.station, id.to_owned())
    }

    fn variable(&self, node: &Node) -> Option<Variable> {
        match &node.kind {
            NodeKind::Variable { source, data_type, .. } => {
                Some(Variable { id: self.id(&node.id), source: source.clone(), data_type: *data_type })
            }
            NodeKind::Folder | NodeKind::Object(_) => None,
        }
    }

    fn delete(&self, node: &Node, space: &mut AddressSpace) {
        if let NodeKind::Variable { properties, .. } = &node.kind {
            for property in properties {
                space.delete(&self.id(&property_id(node, property)), true);
            }
        }
        if node.kind == NodeKind::Object(ObjectKind::Alarm) {
            alarms::delete(&self.id(&node.id), space);
        }
        space.delete(&self.id(&node.id), true);
    }

    fn insert(&self, node: &Node, space: &mut AddressSpace) {
        match &node.kind {
            NodeKind::Folder => self.insert_object(node, ObjectTypeId::FolderType.into(), space),
            NodeKind::Object(kind) => self.insert_object(node, self.namespaces.object_type(*kind), space),
            NodeKind::Variable { data_type, properties, history, .. } => {
                self.insert_variable(node, *data_type, properties, history.is_some(), space);
            }
        }
    }

    fn insert_object(&self, node: &Node, type_id: NodeId, space: &mut AddressSpace) {
        let name = QualifiedName::new(self.namespaces.index(node.named_by), node.name.clone());
        let object = ObjectBuilder::new(&self.id(&node.id), name, node.name.clone()).has_type_definition(type_id);
        let object = match &node.parent {
            Parent::Objects => object.organized_by(ObjectId::ObjectsFolder),
            Parent::Node(parent) | Parent::PropertyOf(parent) => object.component_of(self.id(parent)),
            Parent::DeviceSet(folder) => {
                object.component_of(self.namespaces.device_set()).organized_by(self.id(folder))
            }
        };
        object.insert(space);
        if node.kind == NodeKind::Object(ObjectKind::Alarm) {
            alarms::insert(&self.id(&node.id), space);
        }
    }

    fn insert_variable(
        &self,
        node: &Node,
        data_type: DataType,
        properties: &[Property],
        has_history: bool,
        space: &mut AddressSpace,
    ) {
        let name = QualifiedName::new(self.namespaces.index(node.named_by), node.name.clone());
        let variable = VariableBuilder::new(&self.id(&node.id), name, node.name.clone())
            .description(node.description.clone())
            .data_type(self.data_type_id(data_type))
            .historizing(has_history)
            .has_type_definition(self.variable_type(node, data_type, properties));
        let variable = if has_history { variable.history_readable() } else { variable };
        let is_writable = self.parameters.contains_key(&self.id(&node.id));
        let variable = if is_writable { variable.writable() } else { variable };
        let variable = match &node.parent {
            Parent::Objects => variable.organized_by(ObjectId::ObjectsFolder),
            Parent::Node(parent) | Parent::DeviceSet(parent) => variable.component_of(self.id(parent)),
            Parent::PropertyOf(parent) => variable.property_of(self.id(parent)),
        };
        variable.insert(space);
        self.set_unknown(node, space);
        properties.iter().for_each(|property| self.insert_property(node, property, space));
    }

    /// Until the first values a variable has none.
    fn set_unknown(&self, node: &Node, space: &mut AddressSpace) {
        if let Some(opcua_server::address_space::NodeType::Variable(variable)) = space.find_mut(&self.id(&node.id)) {
            variable.set_data_value(value::unknown());
        }
    }

    fn data_type_id(&self, data_type: DataType) -> NodeId {
        let id = match data_type {
            DataType::Float => DataTypeId::Float,
            DataType::Double => DataTypeId::Double,
            DataType::Int64 => DataTypeId::Int64,
            DataType::UInt32 => DataTypeId::UInt32,
            DataType::Boolean => DataTypeId::Boolean,
            DataType::String => DataTypeId::String,
            DataType::UtcTime => DataTypeId::UtcTime,
            DataType::LocalizedText => DataTypeId::LocalizedText,
            DataType::Int32 => DataTypeId::Int32,
            DataType::Health => return self.namespaces.health_type(),
        };
        id.into()
    }

    /// The type of a variable with these properties, which its type makes mandatory.
    fn variable_type(&self, node: &Node, data_type: DataType, properties: &[Property]) -> NodeId {
        let has = |name: &str| properties.iter().any(|property| property.name() == name);
        if matches!(node.parent, Parent::PropertyOf(_)) {
            return VariableTypeId::PropertyType.into();
        }
        let id = match (has("EngineeringUnits"), has("EURange"), has("EnumStrings")) {
            (true, true, _) if node.named_by == Specification::PaDim => return self.namespaces.pressure_type(),
            (true, true, _) => VariableTypeId::AnalogUnitRangeType,
            (true, false, _) => VariableTypeId::AnalogUnitType,
            (false, _, true) if data_type == DataType::UInt32 => VariableTypeId::MultiStateDiscreteType,
            (false, _, _) => VariableTypeId::BaseDataVariableType,
        };
        id.into()
    }

    fn insert_property(&self, node: &Node, property: &Property, space: &mut AddressSpace) {
        let (value, data_type, rank) = property_value(property);
        let name = property.name();
        VariableBuilder::new(&self.id(&property_id(node, property)), QualifiedName::new(0, name), name)
            .data_type(data_type)
            .value_rank(rank)
            .value(value)
            .has_type_definition(VariableTypeId::PropertyType)
            .property_of(self.id(&node.id))
            .insert(space);
    }
}

/// Whether two nodes look the same to clients: the positions of points may differ.
fn is_same(old: &Node, new: &Node) -> bool {
    let look = |node: &Node| match &node.kind {
        NodeKind::Folder => (0, None),
        NodeKind::Object(_) => (1, None),
        NodeKind::Variable { data_type, properties, history, .. } => {
            (2, Some((*data_type, properties.clone(), history.clone())))
        }
    };
    (&old.parent, &old.name, look(old)) == (&new.parent, &new.name, look(new))
}

fn property_id(node: &Node, property: &Property) -> String {
    format!("{}/{}", node.id, property.name())
}

fn property_value(property: &Property) -> (Variant, DataTypeId, i32) {
    match property {
        Property::EngineeringUnits(unit) => {
            let information = EUInformation {
                namespace_uri: UAString::from(if unit.code.is_empty() { plan::NAMESPACE } else { UNITS }),
                unit_id: unit.id(),
                display_name: LocalizedText::new("", unit.symbol),
                description: LocalizedText::new("", unit.name),
            };
            (Variant::from(ExtensionObject::from_message(information)), DataTypeId::EUInformation, -1)
        }
        Property::Range(_, (low, high)) => {
            let range = Range { low: *low, high: *high };
            (Variant::from(ExtensionObject::from_message(range)), DataTypeId::Range, -1)
        }
        Property::EnumStrings(words) => (texts(words), DataTypeId::LocalizedText, 1),
        Property::Limit(_, limit) => (Variant::Double(*limit), DataTypeId::Double, -1),
    }
}
