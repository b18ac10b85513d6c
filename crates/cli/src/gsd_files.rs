//! Slaves by their GSD files in the output of the commands that explain traffic, and GSD files where traffic is expected.

use crate::failure::Failure;
use crate::gsd_slaves::GsdOptions;
use profivac_explain::gsd::{Described, Extent, Files, Seen};
use profivac_gsd_slave::has_gsd_ending;
use profivac_wire::prm::SetPrm;
use serde::Serialize;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// The GSD files of `--gsd`, to explain traffic with.
pub fn files(options: &GsdOptions) -> Result<Files, Failure> {
    Ok(Files::new(options.read()?.entries().map(|(_, entry)| Arc::clone(&entry.file))))
}

/// A slave in the words of its GSD file, in the JSON output.
#[derive(Debug, Serialize)]
pub struct SlaveRow {
    address: u8,
    /// Model and vendor of each device that it may be.
    devices: Vec<String>,
    modules: Vec<ModuleRow>,
    /// The user parameters of the last Set_Prm; empty if there was none.
    parameters: String,
    /// What the traffic says otherwise than the file.
    mismatches: Vec<String>,
}

/// A slot in the JSON output.
#[derive(Debug, Serialize)]
pub struct ModuleRow {
    slot: u32,
    /// The modules with the configuration octets of the slot; several can have the same.
    modules: Vec<String>,
    /// The first octet and the number of octets in the inputs.
    inputs: (usize, usize),
    /// The first octet and the number of octets in the outputs.
    outputs: (usize, usize),
}

/// The modules of a slave.
pub fn module_rows(described: &Described) -> Vec<ModuleRow> {
    let place = |range: &Range<usize>| (range.start, range.len());
    let row = |slot: &profivac_explain::gsd::Slot| ModuleRow {
        slot: slot.slot,
        modules: slot.modules.clone(),
        inputs: place(&slot.inputs),
        outputs: place(&slot.outputs),
    };
    described.slots().iter().map(row).collect()
}

impl SlaveRow {
    /// A slave; `None` if no file describes it.
    pub fn of(address: u8, described: &Described, seen: &Seen<'_>) -> Option<Self> {
        described.is_known().then(|| {
            let user = SetPrm::parse(seen.set_prm).map(|prm| prm.user).unwrap_or_default();
            Self {
                address,
                devices: described.names(),
                modules: module_rows(described),
                parameters: described.parameters_text(user, Extent::All),
                mismatches: described.mismatches(seen).into_iter().map(|one| one.found).collect(),
            }
        })
    }

    /// The lines of the text output.
    pub fn lines(&self) -> Vec<String> {
        let Self { address, devices, modules, parameters, mismatches } = self;
        let mut lines = vec![format!("station {address}: {} by the GSD file", devices.join(" or "))];
        let place = |name: &str, (first, count): (usize, usize)| match count {
            0 => String::new(),
            1 => format!(", {name} octet {first}"),
            _ => format!(", {name} octets {first} to {}", first.saturating_add(count).saturating_sub(1)),
        };
        lines.extend(modules.iter().map(|ModuleRow { slot, modules, inputs, outputs }| {
            let (inputs, outputs) = (place("input", *inputs), place("output", *outputs));
            format!("station {address}: slot {slot} {}{inputs}{outputs}", modules.join(" or "))
        }));
        if !parameters.is_empty() {
            lines.push(format!("station {address}: parameters: {parameters}"));
        }
        lines.extend(
            mismatches.iter().map(|mismatch| format!("station {address}: not as the GSD file says: {mismatch}")),
        );
        lines
    }
}

/// The octets that show what a file is.
const HEAD: usize = 4096;

/// The beginning of a stream, as far as one read returns it, and the stream from its beginning.
pub fn peek(mut stream: impl Read) -> io::Result<(Vec<u8>, impl Read)> {
    let mut head = vec![0; HEAD];
    let length = stream.read(&mut head)?;
    head.truncate(length);
    Ok((head.clone(), io::Cursor::new(head).chain(stream)))
}

/// Whether a file with this name and beginning is a GSD file: a line `#Profibus_DP` in any capitals, or the ending of GSD files with a
/// text.
pub fn is_gsd(name: &Path, head: &[u8]) -> bool {
    const HEADER: &[u8] = b"#profibus_dp";
    let starts = |line: &[u8]| line.get(..HEADER.len()).is_some_and(|start| start.eq_ignore_ascii_case(HEADER));
    let mut lines = head.split(|octet| matches!(octet, b'\n' | b'\r')).map(<[u8]>::trim_ascii_start);
    lines.any(starts) || has_gsd_ending(name) && !head.is_empty() && !head.contains(&0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gsd_file_is_known_by_its_header_or_its_ending() {
        let is = |name: &str, head: &[u8]| is_gsd(Path::new(name), head);
        assert!(is("x", b"; comment\r\n #PROFIBUS_DP ; text\r\n"));
        assert!(is("X.GSE", b"Module = \"m\" 0x10"));
        assert!(!is("x.txt", b"68 05 05 68 ; no #Profibus_DP line"));
        assert!(!is("x.gsd", b"\x0A\x0D\x0D\x0A\0\0"), "a capture with this name");
        assert!(!is("x.gsd", b""));
        assert!(!is("x", b"#Profi"));
    }

    #[test]
    fn a_stream_is_read_from_its_beginning_after_a_look_at_it() {
        let (head, mut rest) = peek(&b"octets"[..]).unwrap();
        let mut all = Vec::new();
        rest.read_to_end(&mut all).unwrap();
        assert_eq!((head.as_slice(), all.as_slice()), (&b"octets"[..], &b"octets"[..]));
    }
}
