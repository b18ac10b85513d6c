//! The function blocks as PLCopen XML (TC6, version 2.01), made from their text: no variable is declared twice.

use super::{Dialect, st};
use profivac_devices::model::Model;
use quick_xml::Writer;
use quick_xml::events::{BytesCData, BytesDecl, BytesText, Event};
use std::io;

/// The tools that read a file. Both kinds of file follow the schema; they differ in the elements around texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlcopenTool {
    /// CODESYS, TwinCAT and others: a text is in `xhtml`, the description of a block belongs to its interface.
    Codesys,
    /// Beremiz and the OpenPLC Editor: they read only `xhtml:p` with CDATA, and find the description of a block behind its body.
    Beremiz,
}

/// The function blocks of a device in one file of PLCopen XML.
///
/// ```
/// use profivac_client::st::{PlcopenTool, plcopen};
/// use profivac_devices::catalog::model_named;
///
/// let xml = plcopen(model_named("bcg450").ok_or("no such model")?, PlcopenTool::Codesys);
/// assert!(xml.contains("<pou name=\"PV_BCG450_T7\" pouType=\"functionBlock\">"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn plcopen(model: &Model, tool: PlcopenTool) -> String {
    let text = st(model, Dialect::Standard);
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let project = Project { name: model.name, text: &text, tool };
    // Writing to a vector cannot fail.
    let _ = project.write(&mut xml);
    String::from_utf8_lossy(&xml.into_inner()).into_owned()
}

const NAMESPACE: &str = "http://www.plcopen.org/xml/tc6_0201";
const XHTML: &str = "http://www.w3.org/1999/xhtml";

/// The schema demands a time. chosen: always the same, so that a version of profivac always writes the same file.
const TIME: &str = "2000-01-01T00:00:00";

/// The elementary types that the schema has an element for, without strings.
const ELEMENTARY: [&str; 19] = [
    "BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "REAL",
    "LREAL", "TIME", "DATE", "DT", "TOD",
];

type Xml = Writer<Vec<u8>>;

struct Project<'a> {
    name: &'a str,
    text: &'a str,
    tool: PlcopenTool,
}

impl Project<'_> {
    fn write(&self, xml: &mut Xml) -> io::Result<()> {
        xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        let namespaces = [("xmlns", NAMESPACE), ("xmlns:xhtml", XHTML)];
        xml.create_element("project").with_attributes(namespaces).write_inner_content(|xml| {
            self.headers(xml)?;
            xml.create_element("types").write_inner_content(|xml| {
                xml.create_element("dataTypes").write_empty()?;
                xml.create_element("pous").write_inner_content(|xml| self.blocks(xml))?;
                Ok(())
            })?;
            xml.create_element("instances").write_inner_content(|xml| {
                xml.create_element("configurations").write_empty()?;
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    }

    fn headers(&self, xml: &mut Xml) -> io::Result<()> {
        xml.create_element("fileHeader")
            .with_attributes([
                ("companyName", "profivac"),
                ("productName", "profivac"),
                ("productVersion", env!("CARGO_PKG_VERSION")),
                ("creationDateTime", TIME),
            ])
            .write_empty()?;
        xml.create_element("contentHeader")
            .with_attributes([("name", self.name), ("modificationDateTime", TIME)])
            .write_inner_content(|xml| {
                xml.create_element("coordinateInfo").write_inner_content(|xml| {
                    for language in ["fbd", "ld", "sfc"] {
                        xml.create_element(language).write_inner_content(|xml| {
                            xml.create_element("scaling").with_attributes([("x", "1"), ("y", "1")]).write_empty()?;
                            Ok(())
                        })?;
                    }
                    Ok(())
                })?;
                Ok(())
            })?;
        Ok(())
    }

    fn blocks(&self, xml: &mut Xml) -> io::Result<()> {
        let mut parts = self.text.split("\nFUNCTION_BLOCK ");
        // An import takes only blocks, so each of them carries what the text says at its head.
        let head = plain(parts.next().unwrap_or_default());
        for block in parts.filter_map(Block::read) {
            let description = format!("{}\n{head}", plain(block.comment));
            let attributes = [("name", block.name), ("pouType", "functionBlock")];
            xml.create_element("pou").with_attributes(attributes).write_inner_content(|xml| {
                xml.create_element("interface").write_inner_content(|xml| {
                    for section in block.sections() {
                        self.section(xml, &section)?;
                    }
                    match self.tool {
                        PlcopenTool::Codesys => self.formatted(xml, "documentation", &description),
                        PlcopenTool::Beremiz => Ok(()),
                    }
                })?;
                xml.create_element("body").write_inner_content(|xml| self.formatted(xml, "ST", block.statements))?;
                match self.tool {
                    PlcopenTool::Codesys => Ok(()),
                    PlcopenTool::Beremiz => self.formatted(xml, "documentation", &description),
                }
            })?;
        }
        Ok(())
    }

    fn section(&self, xml: &mut Xml, section: &Section) -> io::Result<()> {
        let retention = section.qualifiers().map(|qualifier| (qualifier, "true"));
        xml.create_element(section.element()).with_attributes(retention).write_inner_content(|xml| {
            for variable in section.lines.lines().filter_map(Variable::read) {
                self.variable(xml, &variable)?;
            }
            Ok(())
        })?;
        Ok(())
    }

    fn variable(&self, xml: &mut Xml, variable: &Variable) -> io::Result<()> {
        xml.create_element("variable").with_attribute(("name", variable.name)).write_inner_content(|xml| {
            xml.create_element("type").write_inner_content(|xml| data_type(xml, variable.kind))?;
            if let Some(initial) = variable.initial {
                xml.create_element("initialValue").write_inner_content(|xml| {
                    xml.create_element("simpleValue").with_attribute(("value", initial)).write_empty()?;
                    Ok(())
                })?;
            }
            match variable.comment {
                "" => Ok(()),
                comment => self.formatted(xml, "documentation", &plain(comment)),
            }
        })?;
        Ok(())
    }

    /// An element with formatted text, in the form that the tool reads.
    fn formatted(&self, xml: &mut Xml, element: &str, text: &str) -> io::Result<()> {
        xml.create_element(element).write_inner_content(|xml| {
            match self.tool {
                PlcopenTool::Codesys => {
                    xml.create_element("xhtml")
                        .with_attribute(("xmlns", XHTML))
                        .write_text_content(BytesText::new(text))?;
                }
                PlcopenTool::Beremiz => {
                    // The end of CDATA: a blank between two tokens changes neither statements nor comments.
                    let text = text.replace("]]>", "]] >");
                    xml.create_element("xhtml:p").write_cdata_content(BytesCData::new(text))?;
                }
            }
            Ok(())
        })?;
        Ok(())
    }
}

/// The type of a variable: an elementary type, an array, or the name of another type.
fn data_type(xml: &mut Xml, kind: &str) -> io::Result<()> {
    if let Some((ranges, base)) = kind.strip_prefix("ARRAY[").and_then(|rest| rest.split_once("] OF ")) {
        xml.create_element("array").write_inner_content(|xml| {
            for (lower, upper) in ranges.split(',').filter_map(|range| range.split_once("..")) {
                let bounds = [("lower", lower.trim()), ("upper", upper.trim())];
                xml.create_element("dimension").with_attributes(bounds).write_empty()?;
            }
            xml.create_element("baseType").write_inner_content(|xml| data_type(xml, base.trim()))?;
            Ok(())
        })?;
    } else if ELEMENTARY.contains(&kind) {
        xml.create_element(kind).write_empty()?;
    } else {
        xml.create_element("derived").with_attribute(("name", kind)).write_empty()?;
    }
    Ok(())
}

/// A block in the text, cut into its parts.
struct Block<'a> {
    name: &'a str,
    comment: &'a str,
    /// The sections of variables, each from what follows `VAR`.
    declaration: &'a str,
    statements: &'a str,
}

impl<'a> Block<'a> {
    /// Reads a block from its name on.
    fn read(text: &'a str) -> Option<Self> {
        let (text, _) = text.split_once("\nEND_FUNCTION_BLOCK")?;
        let (name, text) = text.split_once('\n')?;
        let (comment, text) = text.split_once("\nVAR")?;
        let (declaration, statements) = text.rsplit_once("END_VAR\n")?;
        Some(Self { name, comment, declaration, statements: statements.trim_matches('\n') })
    }

    fn sections(&self) -> impl Iterator<Item = Section<'a>> {
        let parts = self.declaration.split("\nVAR").filter_map(|part| part.split_once('\n'));
        parts.map(|(kind, lines)| Section { kind, lines })
    }
}

/// A list of variables: `_INPUT` of `VAR_INPUT`, with qualifiers if it has some, and its lines.
struct Section<'a> {
    kind: &'a str,
    lines: &'a str,
}

impl Section<'_> {
    fn element(&self) -> &'static str {
        match self.kind.split(' ').next() {
            Some("_INPUT") => "inputVars",
            Some("_OUTPUT") => "outputVars",
            Some("_IN_OUT") => "inOutVars",
            Some("_TEMP") => "tempVars",
            _ => "localVars",
        }
    }

    /// The attributes of `CONSTANT` and `RETAIN`.
    fn qualifiers(&self) -> impl Iterator<Item = &'static str> {
        self.kind.split(' ').filter_map(|word| match word {
            "CONSTANT" => Some("constant"),
            "RETAIN" => Some("retain"),
            _ => None,
        })
    }
}

/// `NAME : KIND := INITIAL; (* COMMENT *)`
struct Variable<'a> {
    name: &'a str,
    kind: &'a str,
    initial: Option<&'a str>,
    comment: &'a str,
}

impl<'a> Variable<'a> {
    fn read(line: &'a str) -> Option<Self> {
        let (declared, comment) = line.split_once(';')?;
        let (name, kind) = declared.split_once(':')?;
        let (kind, initial) = match kind.split_once(":=") {
            Some((kind, initial)) => (kind, Some(initial.trim())),
            None => (kind, None),
        };
        Some(Self { name: name.trim(), kind: kind.trim(), initial, comment: comment.trim() })
    }
}

/// A comment without its marks and the indentation of its further lines.
fn plain(comment: &str) -> String {
    let inner = comment.trim().trim_start_matches("(*").trim_end_matches("*)").trim();
    let lines: Vec<_> = inner.lines().map(|line| line.strip_prefix("   ").unwrap_or(line)).collect();
    lines.join("\n")
}
