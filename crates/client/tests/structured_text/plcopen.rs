//! The function blocks as PLCopen XML, read back by another library: a file has every block, variable and statement of the
//! text. `ci/plcopen_xml.py` holds the files against the schema.

use profivac_client::st::{Dialect, PlcopenTool, plcopen, st};
use profivac_devices::catalog::{MODELS, model_named};
use roxmltree::{Document, Node};

const TOOLS: [PlcopenTool; 2] = [PlcopenTool::Codesys, PlcopenTool::Beremiz];

/// The child element of this name.
fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Node<'a, 'i> {
    node.children().find(|one| one.tag_name().name() == name).unwrap_or_else(|| panic!("no {name} in {node:?}"))
}

/// The elements of this name anywhere below.
fn all<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.descendants().filter(move |one| one.tag_name().name() == name)
}

/// The text of an element with formatted text, whatever its form.
fn formatted<'a>(node: Node<'a, '_>) -> &'a str {
    let text = node.first_element_child().unwrap();
    assert_eq!(text.tag_name().namespace(), Some("http://www.w3.org/1999/xhtml"));
    text.text().unwrap()
}

/// A type, as structured text writes it.
fn data_type(node: Node<'_, '_>) -> String {
    let kind = node.first_element_child().unwrap();
    if kind.tag_name().name() != "array" {
        return kind.tag_name().name().to_owned();
    }
    let range = child(kind, "dimension");
    let [lower, upper] = ["lower", "upper"].map(|bound| range.attribute(bound).unwrap());
    format!("ARRAY[{lower}..{upper}] OF {}", data_type(child(kind, "baseType")))
}

fn variable(node: Node<'_, '_>) -> String {
    let mut text = format!("    {} : {}", node.attribute("name").unwrap(), data_type(child(node, "type")));
    for initial in all(node, "simpleValue") {
        text += &format!(" := {}", initial.attribute("value").unwrap());
    }
    text += ";";
    for comment in all(node, "documentation") {
        text += &format!(" (* {} *)", formatted(comment));
    }
    text
}

/// A block as structured text, without the comment at its head.
fn block(pou: Node<'_, '_>) -> String {
    let mut text = format!("FUNCTION_BLOCK {}\n", pou.attribute("name").unwrap());
    for section in child(pou, "interface").children().filter(Node::is_element) {
        text += match section.tag_name().name() {
            "inputVars" => "VAR_INPUT\n",
            "outputVars" => "VAR_OUTPUT\n",
            "localVars" => "VAR\n",
            "documentation" => continue,
            other => panic!("{other}"),
        };
        for one in section.children().filter(Node::is_element) {
            text += &format!("{}\n", variable(one));
        }
        text += "END_VAR\n";
    }
    text + &format!("\n{}\nEND_FUNCTION_BLOCK\n", formatted(child(child(pou, "body"), "ST")))
}

/// The blocks of a text: name, comment at the head, and the rest.
fn blocks(text: &str) -> Vec<(&str, &str, &str)> {
    let parts = text.split("\nFUNCTION_BLOCK ").skip(1);
    parts
        .map(|part| {
            let (name, rest) = part.split_once('\n').unwrap();
            let (comment, _) = rest.split_once("\nVAR").unwrap();
            (name, comment, &rest[comment.len()..])
        })
        .collect()
}

#[test]
fn a_file_has_every_block_variable_and_statement_of_the_text() {
    for (model, tool) in MODELS.into_iter().flat_map(|model| TOOLS.map(|tool| (model, tool))) {
        let (text, xml) = (st(model, Dialect::Standard), plcopen(model, tool));
        let document = Document::parse(&xml).unwrap();
        let read: Vec<_> = all(document.root_element(), "pou").map(block).collect();
        let written: Vec<_> =
            blocks(&text).into_iter().map(|(name, _, rest)| format!("FUNCTION_BLOCK {name}{rest}")).collect();
        assert!(!written.is_empty() && read == written, "{} for {tool:?}", model.name);
    }
}

#[test]
fn each_block_carries_its_comment_and_the_warning_of_the_file() {
    for (model, tool) in MODELS.into_iter().flat_map(|model| TOOLS.map(|tool| (model, tool))) {
        let (text, xml) = (st(model, Dialect::Standard), plcopen(model, tool));
        let document = Document::parse(&xml).unwrap();
        for (pou, (name, comment, _)) in all(document.root_element(), "pou").zip(blocks(&text)) {
            let owner = match tool {
                PlcopenTool::Codesys => child(pou, "interface"),
                PlcopenTool::Beremiz => pou,
            };
            let description = formatted(child(owner, "documentation"));
            for line in comment.lines().map(|line| line.trim_matches(['(', '*', ')', ' '])) {
                assert!(description.contains(line), "{name}: {line} in {description}");
            }
            assert!(description.contains("Not for safety functions."), "{name}: {description}");
            assert!(!description.contains("(*") && !description.contains("*)"), "{name}: {description}");
        }
    }
}

#[test]
fn a_file_has_the_headers_and_the_types_of_the_schema() {
    let xml =
        plcopen(model_named("bcg450").unwrap(), PlcopenTool::Codesys).replace(env!("CARGO_PKG_VERSION"), "VERSION");
    let head = r#"<?xml version="1.0" encoding="UTF-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201" xmlns:xhtml="http://www.w3.org/1999/xhtml">
  <fileHeader companyName="profivac" productName="profivac" productVersion="VERSION" creationDateTime="2000-01-01T00:00:00"/>
  <contentHeader name="bcg450" modificationDateTime="2000-01-01T00:00:00">
    <coordinateInfo>
      <fbd>
        <scaling x="1" y="1"/>
      </fbd>
      <ld>
        <scaling x="1" y="1"/>
      </ld>
      <sfc>
        <scaling x="1" y="1"/>
      </sfc>
    </coordinateInfo>
  </contentHeader>
  <types>
    <dataTypes/>
    <pous>
      <pou name="PV_BCG450_T"#;
    assert!(xml.starts_with(head), "{xml}");
    let array = r#"
            <variable name="RESPONSE">
              <type>
                <array>
                  <dimension lower="0" upper="7"/>
                  <baseType>
                    <BYTE/>
                  </baseType>
                </array>
              </type>
            </variable>"#;
    assert!(xml.contains(array), "{xml}");
    let initial = r#"
            <variable name="SUBSTITUTE_PA">
              <type>
                <REAL/>
              </type>
              <initialValue>
                <simpleValue value="1.01325E+5"/>
              </initialValue>
            </variable>"#;
    assert!(xml.contains(initial), "{xml}");
    assert!(xml.ends_with("  <instances>\n    <configurations/>\n  </instances>\n</project>"), "{xml}");
}

#[test]
fn beremiz_finds_its_own_form_of_a_text() {
    let xml = plcopen(model_named("bcg450").unwrap(), PlcopenTool::Beremiz);
    assert!(xml.contains("<xhtml:p><![CDATA[") && !xml.contains("<xhtml "), "{xml}");
    // Beremiz inserts the element around each CDATA that does not stand directly in one.
    assert_eq!(xml.matches("<![CDATA[").count(), xml.matches("<xhtml:p><![CDATA[").count());
    assert_eq!(xml.matches("]]>").count(), xml.matches("]]></xhtml:p>").count());
}
