//! The identifiers of nodes, which never change: a client stores them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_gateway::{Inputs, points};
use profivac_gateway_opcua::plan::{NodeKind, Property, nodes};
use std::collections::BTreeSet;
use std::path::Path;

const PLANT: &str = r#"
[[segment]]
name = "hall/1"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "tpg"
address = 6
device = "tpg300"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
"#;

/// A line for each node: identifier, class, browse name.
fn lines() -> Vec<String> {
    let config = profivac_config::parse(PLANT, Path::new("plant.toml")).unwrap();
    let nodes = nodes(&points(&Inputs::planned(&config)));
    let class = |kind: &NodeKind| match kind {
        NodeKind::Folder => "folder",
        NodeKind::Object(_) => "object",
        NodeKind::Variable { .. } => "variable",
    };
    let mut lines: Vec<_> =
        nodes.iter().map(|node| format!("{} | {} | {}\n", node.id, class(&node.kind), node.name)).collect();
    lines.sort();
    lines
}

/// `PROFIVAC_BLESS=1` adds the lines of new nodes, and loses none.
#[test]
fn identifiers_and_browse_names_never_change() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/nodes.txt");
    let (text, lines) = (std::fs::read_to_string(&file).unwrap_or_default(), lines());
    let own: BTreeSet<&str> = lines.iter().map(|line| line.trim_end()).collect();
    let lost: Vec<_> = text.lines().filter(|line| !own.contains(line)).collect();
    assert!(lost.is_empty(), "clients have stored these nodes, so they stay: {lost:#?}");
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        std::fs::write(&file, lines.concat()).unwrap();
        return;
    }
    assert_eq!(text, lines.concat(), "new nodes: PROFIVAC_BLESS=1 adds them to {}", file.display());
}

#[test]
fn no_two_nodes_have_the_same_identifier() {
    let lines = lines();
    let ids: BTreeSet<_> = lines.iter().filter_map(|line| line.split(" | ").next()).collect();
    assert_eq!(ids.len(), lines.len());
}

/// A valve by its GSD file: its points are variables in `ParameterSet`, in the unit of the station's file.
#[test]
fn the_points_of_a_slave_are_variables_with_their_unit() {
    const GSD: &str = "#Profibus_DP\nVendor_Name = \"Invented\"\nModel_Name = \"Valve\"\nIdent_Number = 0x0FA7\nModule = \"All\" 0x10\n1\nEndModule\n";
    const FILE: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
[[segment.slave]]
name = "gate"
address = 9
gsd = "valve.gsd"
[[segment.slave.point]]
name = "position"
type = "u8"
unit = "mm"
"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("valve.gsd"), GSD).unwrap();
    let config = profivac_config::parse(FILE, &folder.path().join("plant.toml")).unwrap();
    let nodes = nodes(&points(&Inputs::planned(&config)));
    let node = |id: &str| nodes.iter().find(|node| node.id == id).unwrap();
    let NodeKind::Variable { properties, .. } = &node("gauge/gate/parameter/position/parameter-number").kind else {
        panic!("no variable")
    };
    assert!(
        properties.iter().any(|it| matches!(it, Property::EngineeringUnits(unit) if unit.symbol == "mm")),
        "{properties:?}"
    );
    assert!(matches!(node("gauge/gate/parameter/position/parameter-text").kind, NodeKind::Variable { .. }));
}
