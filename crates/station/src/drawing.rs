//! The user's own drawing of the plant: an SVG whose elements name gauges, volumes, valves and pumps.
//!
//! An element names a thing with its `id` or its label in Inkscape: `gauge:chamber`, `volume:chamber`, `valve:slide`, `pump:turbo`. In an
//! `id`, which has no spaces, `_` may stand for each of them. The dashboard gets the drawing with `data-gauge`, `data-volume` and
//! `data-part`, and with nothing that a browser runs or fetches.

use profivac_client::suggestion::closest;
use roxmltree::{Attribute, Document, Node, ParsingOptions};
use std::fmt::Write as _;

/// The most elements and texts. chosen: a drawing of a large plant has some thousand.
const MAX_NODES: u32 = 50_000;

/// The deepest element. chosen: editors nest some layers and groups.
const MAX_DEPTH: usize = 100;

const SVG: &str = "http://www.w3.org/2000/svg";
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
const XLINK: &str = "http://www.w3.org/1999/xlink";

/// The elements that only draw. Others are left out with what is in them.
const ELEMENTS: [&str; 24] = [
    "svg",
    "g",
    "defs",
    "symbol",
    "use",
    "path",
    "rect",
    "circle",
    "ellipse",
    "line",
    "polyline",
    "polygon",
    "text",
    "tspan",
    "title",
    "desc",
    "linearGradient",
    "radialGradient",
    "stop",
    "clipPath",
    "mask",
    "pattern",
    "marker",
    "style",
];

/// What an element may name, and the attribute that the dashboard finds it by.
const KINDS: [(&str, &str); 4] =
    [("gauge", "data-gauge"), ("volume", "data-volume"), ("valve", "data-part"), ("pump", "data-part")];

/// The names of a station.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Gauges, and `name.N` for channel N of a controller.
    pub gauges: Vec<String>,
    /// Volumes.
    pub volumes: Vec<String>,
    /// Valves.
    pub valves: Vec<String>,
    /// Pumps.
    pub pumps: Vec<String>,
}

impl Names {
    fn of(&self, kind: &str) -> &[String] {
        match kind {
            "gauge" => &self.gauges,
            "volume" => &self.volumes,
            "valve" => &self.valves,
            _ => &self.pumps,
        }
    }

    /// The known name that an element means. A channel counts if its controller is known.
    fn find(&self, kind: &str, name: &str) -> Option<String> {
        let is_known = |name: &str| self.of(kind).iter().any(|known| known == name);
        let channel = name.rsplit_once('.').filter(|(_, channel)| kind == "gauge" && channel.parse::<u8>().is_ok());
        (is_known(name) || channel.is_some_and(|(controller, _)| is_known(controller))).then(|| name.to_owned())
    }
}

/// Why a drawing cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DrawingProblem {
    /// It is no XML, or has a document type.
    #[error("expected an SVG without a document type: {0}")]
    Xml(String),
    /// Its outermost element is another one.
    #[error("expected an SVG, found an XML file with the element {0}")]
    NotSvg(String),
    /// It has no size.
    #[error("expected viewBox on the element svg, found none: without it the drawing does not fit into the page")]
    NoViewBox,
    /// Its elements are nested too deeply.
    #[error("expected elements nested up to {MAX_DEPTH} times, found more: remove groups")]
    TooDeep,
    /// An element names nothing that the file of the station has.
    #[error("{line}:{column}: the file of the station has no {kind} {name:?}{}", suggestion.as_ref().map(|it| format!("; did you mean {it:?}?")).unwrap_or_default())]
    Unknown {
        /// The line of the element, from 1.
        line: u32,
        /// Its column, from 1.
        column: u32,
        /// `gauge`, `volume`, `valve` or `pump`.
        kind: &'static str,
        /// The name.
        name: String,
        /// A name that is nearly the same.
        suggestion: Option<String>,
    },
    /// No element names anything.
    #[error(
        "expected an element with an id such as \"gauge:chamber\" or \"volume:chamber\", found none: nothing would be live"
    )]
    NothingNamed,
}

/// The drawing as the dashboard gets it.
///
/// # Errors
/// [`DrawingProblem`] says what to change.
pub fn checked(text: &str, names: &Names) -> Result<String, DrawingProblem> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document =
        Document::parse_with_options(text, options).map_err(|error| DrawingProblem::Xml(error.to_string()))?;
    let root = document.root_element();
    if !is_svg(root) || root.tag_name().name() != "svg" {
        return Err(DrawingProblem::NotSvg(root.tag_name().name().to_owned()));
    }
    if root.attribute("viewBox").is_none() {
        return Err(DrawingProblem::NoViewBox);
    }
    let mut writer = Writer { names, out: String::new(), has_named: false };
    writer.element(root, MAX_DEPTH)?;
    if writer.has_named { Ok(writer.out) } else { Err(DrawingProblem::NothingNamed) }
}

fn is_svg(element: Node<'_, '_>) -> bool {
    element.tag_name().namespace() == Some(SVG)
}

struct Writer<'a> {
    names: &'a Names,
    out: String,
    has_named: bool,
}

impl Writer<'_> {
    /// Writes an element and what is in it; `depth` levels are left.
    fn element(&mut self, element: Node<'_, '_>, depth: usize) -> Result<(), DrawingProblem> {
        let name = element.tag_name().name();
        if !is_svg(element) || !ELEMENTS.contains(&name) {
            return Ok(());
        }
        let depth = depth.checked_sub(1).ok_or(DrawingProblem::TooDeep)?;
        self.push(format_args!("<{name}"));
        if element.parent_element().is_none() {
            self.push(format_args!(" xmlns=\"{SVG}\""));
        }
        for attribute in element.attributes() {
            if let Some(key) = permitted(&attribute) {
                self.push(format_args!(" {key}=\"{}\"", escaped(attribute.value())));
            }
        }
        self.name(element)?;
        self.out.push('>');
        for child in element.children() {
            match child.text().filter(|_| child.is_text()) {
                Some(text) if name != "style" || is_local(text) => self.push(format_args!("{}", escaped(text))),
                Some(_) => {}
                None if child.is_element() => self.element(child, depth)?,
                None => {}
            }
        }
        self.push(format_args!("</{name}>"));
        Ok(())
    }

    /// Writes what the element names.
    fn name(&mut self, element: Node<'_, '_>) -> Result<(), DrawingProblem> {
        let label = element.attribute((INKSCAPE, "label"));
        for (text, is_id) in [(label, false), (element.attribute("id"), true)] {
            let Some((kind, name)) = text.and_then(|text| text.split_once(':')) else { continue };
            let Some((kind, attribute)) = KINDS.into_iter().find(|(known, _)| *known == kind) else { continue };
            let spaced = name.replace('_', " ");
            let found = self.names.find(kind, name).or_else(|| self.names.find(kind, &spaced).filter(|_| is_id));
            let Some(found) = found else {
                let position = element.document().text_pos_at(element.range().start);
                let known = self.names.of(kind).iter().map(String::as_str);
                let suggestion = closest(name, known).map(str::to_owned);
                let (line, column) = (position.row, position.col);
                return Err(DrawingProblem::Unknown { line, column, kind, name: name.to_owned(), suggestion });
            };
            self.push(format_args!(" {attribute}=\"{}\"", escaped(&found)));
            self.has_named = true;
            return Ok(());
        }
        Ok(())
    }

    fn push(&mut self, text: std::fmt::Arguments<'_>) {
        // A text takes everything.
        let _written = self.out.write_fmt(text);
    }
}

/// The key of an attribute that only draws; none for one that names code, another file or an editor.
fn permitted<'a>(attribute: &Attribute<'a, '_>) -> Option<&'a str> {
    let (key, value) = (attribute.name(), attribute.value());
    if key == "href" {
        let is_link = matches!(attribute.namespace(), None | Some(XLINK));
        return (is_link && value.starts_with('#')).then_some(key);
    }
    let is_key = !key.to_ascii_lowercase().starts_with("on") && !key.starts_with("data-");
    (attribute.namespace().is_none() && is_key && is_local(value)).then_some(key)
}

/// Whether styles name nothing outside the drawing. An escape of CSS could hide a word, so a style has none.
fn is_local(style: &str) -> bool {
    let style = style.to_ascii_lowercase();
    let mut urls = style.split("url(").skip(1);
    !style.contains("@import")
        && !style.contains('\\')
        && !style.contains("image(")
        && !style.contains("image-set(")
        && !style.contains("src(")
        && urls.all(|rest| rest.trim_start_matches([' ', '"', '\'']).starts_with('#'))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Names {
        let list = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        Names {
            gauges: list(&["chamber", "fore line", "tpg", "a_b"]),
            volumes: list(&["target chamber"]),
            valves: list(&["slide"]),
            pumps: list(&["turbo"]),
        }
    }

    fn svg(inside: &str) -> Result<String, DrawingProblem> {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<svg xmlns=\"{SVG}\" xmlns:xlink=\"{XLINK}\" xmlns:inkscape=\"{INKSCAPE}\" viewBox=\"0 0 9 9\">{inside}</svg>"
        );
        checked(&text, &names())
    }

    fn inside(drawing: &str) -> &str {
        let start = drawing.find("9 9\">").map_or(0, |start| start + 5);
        drawing.get(start..drawing.len() - "</svg>".len()).unwrap_or_default()
    }

    #[test]
    fn elements_name_things_by_id_and_by_label() {
        for (given, expected) in [
            ("<text id=\"gauge:chamber\"/>", "<text id=\"gauge:chamber\" data-gauge=\"chamber\"></text>"),
            ("<g id=\"gauge:fore_line\"/>", "<g id=\"gauge:fore_line\" data-gauge=\"fore line\"></g>"),
            ("<g id=\"gauge:a_b\"/>", "<g id=\"gauge:a_b\" data-gauge=\"a_b\"></g>"),
            ("<g id=\"gauge:tpg.2\"/>", "<g id=\"gauge:tpg.2\" data-gauge=\"tpg.2\"></g>"),
            (
                "<g id=\"g1\" inkscape:label=\"volume:target chamber\"/>",
                "<g id=\"g1\" data-volume=\"target chamber\"></g>",
            ),
            ("<g id=\"valve:slide\"/>", "<g id=\"valve:slide\" data-part=\"slide\"></g>"),
            ("<g id=\"pump:turbo\"/>", "<g id=\"pump:turbo\" data-part=\"turbo\"></g>"),
        ] {
            assert_eq!(inside(&svg(given).unwrap()), expected);
        }
    }

    #[test]
    fn nothing_that_runs_or_is_fetched_stays() {
        let named = "<g id=\"pump:turbo\"/>";
        for hostile in [
            "<script>alert(1)</script>",
            "<SCRIPT>alert(1)</SCRIPT>",
            "<x:script xmlns:x=\"http://www.w3.org/1999/xhtml\">alert(1)</x:script>",
            "<foreignObject><g/></foreignObject>",
            "<image href=\"https://other.example/a.png\"/>",
            "<a href=\"javascript:alert(1)\"><g/></a>",
            "<animate onbegin=\"alert(1)\"/>",
            "<!-- comment --><?pi data?>",
        ] {
            assert_eq!(
                inside(&svg(&format!("{hostile}{named}")).unwrap()),
                "<g id=\"pump:turbo\" data-part=\"turbo\"></g>",
                "{hostile}"
            );
        }
        for attribute in [
            "onload=\"alert(1)\"",
            "ONLOAD=\"alert(1)\"",
            "href=\"https://other.example\"",
            "xlink:href=\"data:text/html,x\"",
            "style=\"fill:url(https://other.example/a)\"",
            "style=\"fill:u\\72l(https://other.example/a)\"",
            "fill=\"url( 'https://other.example/a')\"",
            "data-gauge=\"chamber\"",
            "xml:base=\"https://other.example\"",
            "inkscape:label=\"layer\"",
        ] {
            let drawn = svg(&format!("<rect {attribute}/>{named}")).unwrap();
            assert!(inside(&drawn).starts_with("<rect></rect>"), "{drawn}");
        }
        let styles = svg(&format!("<style>@import 'x';</style><style>.a {{ fill: url(#g) }}</style>{named}")).unwrap();
        assert!(inside(&styles).starts_with("<style></style><style>.a { fill: url(#g) }</style>"), "{styles}");
    }

    #[test]
    fn what_draws_stays() {
        let drawing = "<defs><path id=\"p\" d=\"M0 0\"></path></defs><use href=\"#p\" style=\"fill:url(#g)\"></use><text id=\"gauge:tpg.1\" \
            data-gauge=\"tpg.1\">a &lt; b &amp; c</text>";
        let given = drawing.replace(" data-gauge=\"tpg.1\"", "");
        assert_eq!(inside(&svg(&given).unwrap()), drawing);
    }

    #[test]
    fn a_drawing_that_cannot_be_used_says_why() {
        let unknown = svg("\n  <g id=\"gauge:chambr\"/>").unwrap_err().to_string();
        assert_eq!(unknown, "3:3: the file of the station has no gauge \"chambr\"; did you mean \"chamber\"?");
        assert_eq!(svg("<g id=\"layer:1\"/>"), Err(DrawingProblem::NothingNamed));
        assert_eq!(
            svg(&format!("{}{}", "<g>".repeat(MAX_DEPTH), "</g>".repeat(MAX_DEPTH))),
            Err(DrawingProblem::TooDeep)
        );
        for (text, expected) in [
            ("", "expected an SVG without a document type: "),
            ("<svg", "expected an SVG without a document type: "),
            ("<!DOCTYPE svg [<!ENTITY a \"b\">]><svg/>", "expected an SVG without a document type: "),
            ("<svg/>", "expected an SVG, found an XML file with the element svg"),
            (
                "<html xmlns=\"http://www.w3.org/1999/xhtml\"/>",
                "expected an SVG, found an XML file with the element html",
            ),
            ("<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "expected viewBox"),
        ] {
            let error = checked(text, &names()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
