//! The instance of a condition in the address space.

use super::fields::{self, FIELDS, Field, Role, SHELVING, TYPES, below};
use super::method::{Method, MethodArgument};
use opcua_server::address_space::{
    AddressSpace, DefaultTypeTree, MethodBuilder, ObjectBuilder, ReferenceDirection, VariableBuilder,
};
use opcua_types::{
    Argument, LocalizedText, NodeClass, NodeId, ObjectTypeId, QualifiedName, ReferenceTypeId, VariableTypeId,
};

/// Makes the fields of conditions known to the check of event filters, which looks for a field in the very type that a client names,
/// and not in its parents; and which leaves out unknown fields, so that all later ones would move. The empty path is `ConditionId`.
pub fn register(tree: &mut DefaultTypeTree) {
    for kind in TYPES {
        let kind = NodeId::from(kind);
        tree.add_type_property(&kind, &kind, &[], NodeClass::Object);
        for (path, role, _) in FIELDS {
            let path: Vec<_> = path.split('/').map(|part| QualifiedName::new(0, part)).collect();
            tree.add_type_property(&kind, &kind, &path.iter().collect::<Vec<_>>(), NodeClass::Variable);
            if let Some((second, _)) = role.second() {
                let second = QualifiedName::new(0, second);
                let path: Vec<_> = path.iter().chain([&second]).collect();
                tree.add_type_property(&kind, &kind, &path, NodeClass::Variable);
            }
        }
    }
}

/// Inserts the condition of the alarm at `source`.
pub fn insert(source: &NodeId, space: &mut AddressSpace) {
    let own = below(source, "condition");
    ObjectBuilder::new(&own, QualifiedName::new(own.namespace, "Condition"), "Condition")
        .has_type_definition(ObjectTypeId::AlarmConditionType)
        .component_of(source.clone())
        .reference(source.clone(), ReferenceTypeId::HasCondition, ReferenceDirection::Inverse)
        .insert(space);
    ObjectBuilder::new(&below(&own, SHELVING), QualifiedName::new(0, SHELVING), SHELVING)
        .has_type_definition(ObjectTypeId::ShelvedStateMachineType)
        .component_of(own.clone())
        .insert(space);
    fields::of_instance().for_each(|field| insert_field(&own, *field, space));
    for (method, path) in Method::ON_INSTANCE {
        insert_method(&own, method, path, space);
    }
}

/// The node that holds what is at a path, and the last part of the path.
fn parent_of<'a>(own: &NodeId, path: &'a str) -> (NodeId, &'a str) {
    path.rsplit_once('/').map_or_else(|| (own.clone(), path), |(parent, name)| (below(own, parent), name))
}

fn insert_field(own: &NodeId, (path, role, data_type): Field, space: &mut AddressSpace) {
    let (id, (parent, name)) = (below(own, path), parent_of(own, path));
    let field = VariableBuilder::new(&id, QualifiedName::new(0, name), name).data_type(data_type);
    let field = match role {
        Role::Property => field.has_type_definition(VariableTypeId::PropertyType).property_of(parent),
        Role::TwoState => field.has_type_definition(VariableTypeId::TwoStateVariableType).component_of(parent),
        Role::Current => field.has_type_definition(VariableTypeId::FiniteStateVariableType).component_of(parent),
        Role::Timed => field.has_type_definition(VariableTypeId::ConditionVariableType).component_of(parent),
    };
    field.insert(space);
    if let Some((second, data_type)) = role.second() {
        VariableBuilder::new(&below(&id, second), QualifiedName::new(0, second), second)
            .data_type(data_type)
            .has_type_definition(VariableTypeId::PropertyType)
            .property_of(id)
            .insert(space);
    }
}

fn insert_method(own: &NodeId, method: Method, path: &str, space: &mut AddressSpace) {
    let (id, (parent, name)) = (below(own, path), parent_of(own, path));
    let is_executable = method != Method::OneShotShelve;
    let builder = MethodBuilder::new(&id, QualifiedName::new(0, name), name)
        .executable(is_executable)
        .user_executable(is_executable)
        .component_of(parent);
    if method.arguments().is_empty() {
        builder.insert(space);
        return;
    }
    let argument = |(name, data_type, description): &MethodArgument| Argument {
        name: (*name).into(),
        data_type: (*data_type).into(),
        value_rank: -1,
        array_dimensions: None,
        description: LocalizedText::new("", description),
    };
    let arguments: Vec<_> = method.arguments().iter().map(argument).collect();
    builder.input_args(space, &below(&id, "InputArguments"), &arguments).insert(space);
}

/// Deletes the condition of the alarm at `source`.
pub fn delete(source: &NodeId, space: &mut AddressSpace) {
    let own = below(source, "condition");
    for (path, role, _) in fields::of_instance() {
        if let Some((second, _)) = role.second() {
            space.delete(&below(&own, &format!("{path}/{second}")), true);
        }
        space.delete(&below(&own, path), true);
    }
    for (_, path) in Method::ON_INSTANCE {
        space.delete(&below(&own, &format!("{path}/InputArguments")), true);
        space.delete(&below(&own, path), true);
    }
    space.delete(&below(&own, SHELVING), true);
    space.delete(&own, true);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The paths of the nodes below a condition. Clients store them, so a line of the file never changes or goes.
    #[test]
    fn the_nodes_of_a_condition_never_change() {
        let mut paths: Vec<String> = Vec::new();
        for (path, role, _) in fields::of_instance() {
            paths.push((*path).to_owned());
            paths.extend(role.second().map(|(second, _)| format!("{path}/{second}")));
        }
        for (method, path) in Method::ON_INSTANCE {
            paths.push(path.to_owned());
            paths.extend((!method.arguments().is_empty()).then(|| format!("{path}/InputArguments")));
        }
        paths.push(SHELVING.to_owned());
        paths.sort_unstable();
        assert_eq!(paths, include_str!("../../tests/golden/condition.txt").lines().collect::<Vec<_>>());
    }

    #[test]
    fn what_is_inserted_is_deleted_whole() {
        let mut space = AddressSpace::new();
        space.add_namespace("urn:test", 2);
        let source = NodeId::new(2, "alarm/x");
        insert(&source, &mut space);
        let own = below(&source, "condition");
        let mut nodes: BTreeSet<_> = fields::of_instance().map(|(path, ..)| (*path).to_owned()).collect();
        nodes.extend(Method::ON_INSTANCE.map(|(_, path)| path.to_owned()));
        nodes.extend(
            ["Acknowledge/InputArguments", "ShelvingState/TimedShelve/InputArguments", SHELVING].map(str::to_owned),
        );
        for path in &nodes {
            assert!(space.node_exists(&below(&own, path)), "{path}");
        }
        delete(&source, &mut space);
        for path in &nodes {
            assert!(!space.node_exists(&below(&own, path)), "{path}");
        }
        assert!(!space.node_exists(&own));
    }
}
