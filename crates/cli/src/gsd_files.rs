//! Slaves by their GSD files in the output of the commands that explain traffic, and GSD files where traffic is expected.

use crate::device_files::DeviceFileOptions;
use crate::failure::Failure;
use crate::gsd_slaves::GsdOptions;
use flate2::read::MultiGzDecoder;
use profivac_explain::gsd::{Described, Extent, Files, Seen};
use profivac_gsd::Encoding;
use profivac_gsd_slave::has_gsd_ending;
use profivac_wire::prm::SetPrm;
use serde::Serialize;
use std::borrow::Cow;
use std::io::{self, Cursor, ErrorKind, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// The GSD files of `--gsd` and the devices of `--device-files`, to explain traffic with.
pub fn files(options: &GsdOptions, devices: &DeviceFileOptions) -> Result<Files, Failure> {
    let files = Files::new(options.read()?.entries().map(|(_, entry)| Arc::clone(&entry.file)));
    Ok(files.with_devices(devices.read()?))
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

/// The most octets that show what a file is.
const HEAD: usize = 4096;

/// The first octets of a file of gzip (RFC 1952), with its only method.
const GZIP: [u8; 3] = [0x1F, 0x8B, 8];

/// A stream from its beginning, and its first octets.
pub struct Peeked {
    /// As many as one read returns, and enough to know gzip: a pipe that is slow does not delay its first line.
    pub head: Vec<u8>,
    /// The whole stream.
    pub stream: Box<dyn Read>,
}

impl Peeked {
    /// Looks at the beginning of a stream.
    pub fn of(mut stream: impl Read + 'static) -> io::Result<Self> {
        let (mut head, mut room) = (Vec::new(), [0; HEAD]);
        while head.len() < GZIP.len() {
            match stream.read(&mut room) {
                Ok(0) => break,
                Ok(length) => head.extend(room.iter().take(length)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(Self { head: head.clone(), stream: Box::new(Cursor::new(head).chain(stream)) })
    }

    /// The stream unpacked, if it is one of gzip.
    pub fn unpacked(self) -> io::Result<Self> {
        if self.head.starts_with(&GZIP) { Self::of(MultiGzDecoder::new(self.stream)) } else { Ok(self) }
    }
}

/// Whether a file with this name and beginning is a GSD file: a line `#Profibus_DP` in any capitals, or the ending of GSD files and a
/// statement of one. A capture or a log may have any name.
pub fn is_gsd(name: &Path, head: &[u8]) -> bool {
    const HEADER: &[u8] = b"#profibus_dp";
    let head = narrow(head);
    let starts = |line: &[u8]| line.get(..HEADER.len()).is_some_and(|start| start.eq_ignore_ascii_case(HEADER));
    let mut lines = head.split(|octet| matches!(octet, b'\n' | b'\r')).map(<[u8]>::trim_ascii_start);
    let is_text = |line: &&[u8]| !line.is_empty() && !line.starts_with(b";");
    lines.clone().any(starts) || has_gsd_ending(name) && lines.find(is_text).is_some_and(is_statement)
}

/// The beginning of a file, with one octet for an ASCII character: a GSD file can be UTF-16.
fn narrow(head: &[u8]) -> Cow<'_, [u8]> {
    let whole = head.as_chunks::<2>().0.as_flattened();
    let encoding = Encoding::detect(whole);
    if encoding.is_utf16() { Cow::Owned(encoding.decode(whole).into_bytes()) } else { Cow::Borrowed(head) }
}

/// Whether a line begins with a keyword and `=`, as the statements of GSD files do: `Slave_Family = 0`, `Unit_Diag_Bit(1) = "x"`.
fn is_statement(line: &[u8]) -> bool {
    let Some(keyword) = line.split(|octet| *octet == b'=').next().filter(|keyword| keyword.len() < line.len()) else {
        return false;
    };
    let is_keyword = |octet: &u8| octet.is_ascii_alphanumeric() || b"_.!()-".contains(octet);
    let keyword = keyword.trim_ascii_end();
    !keyword.is_empty() && keyword.iter().all(is_keyword)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_gsd_file_is_known_by_its_header_or_its_ending() {
        let is = |name: &str, head: &[u8]| is_gsd(Path::new(name), head);
        assert!(is("x", b"; comment\r\n #PROFIBUS_DP ; text\r\n"));
        assert!(is("X.GSE", b"Module = \"m\" 0x10"));
        assert!(!is("x.txt", b"68 05 05 68 ; no #Profibus_DP line"));
        assert!(is("x.gsd", b"; station\n\n  9.6_supp = 1"));
        assert!(is("x.gsd", b"Unit_Diag_Bit(1)= \"no air\""));
        assert!(!is("x.gsd", b"\x0A\x0D\x0D\x0A\0\0"), "a capture with this name");
        assert!(!is("x.gsd", b"TX 68 05 05 68 88 82 6D 3C 3E F1 16"), "a log with this name");
        assert!(!is("x.gsd", b"\x10\x05\x02\x49\x50\x16\xE5"), "octets of a line with this name");
        assert!(!is("x.gsd", b""));
        assert!(!is("x", b"#Profi"));
    }

    #[test]
    fn a_gsd_file_in_utf_16_is_known_also_when_its_beginning_is_cut() {
        let wide: Vec<u8> = "; comment\r\n#Profibus_DP\r\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let marked = [b"\xFF\xFE".as_slice(), &wide].concat();
        for head in [wide.as_slice(), &marked, &marked[..marked.len() - 1]] {
            assert!(is_gsd(Path::new("x"), head));
        }
    }

    fn rest(peeked: Peeked) -> (Vec<u8>, Vec<u8>) {
        let Peeked { head, mut stream } = peeked;
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        (head, all)
    }

    #[test]
    fn a_stream_is_read_from_its_beginning_after_a_look_at_it() {
        let (head, all) = rest(Peeked::of(&b"octets"[..]).unwrap());
        assert_eq!((head.as_slice(), all.as_slice()), (&b"octets"[..], &b"octets"[..]));
        let in_parts = b"o".chain(&b"c"[..]).chain(&b"tets"[..]);
        let (head, all) = rest(Peeked::of(in_parts).unwrap());
        assert_eq!((head.as_slice(), all.as_slice()), (&b"octets"[..], &b"octets"[..]));
        assert_eq!(rest(Peeked::of(io::empty()).unwrap()), (Vec::new(), Vec::new()));
    }

    #[test]
    fn the_beginning_of_a_packed_stream_is_that_of_its_contents() {
        let text = [&b"; comment\n"[..], &[b' '; 200], b"\n#Profibus_DP\n"].concat();
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(&text).unwrap();
        let packed = Cursor::new(packed.finish().unwrap());
        let (head, all) = rest(Peeked::of(packed).unwrap().unpacked().unwrap());
        assert_eq!(all, text);
        assert!(is_gsd(Path::new("x"), &head));
    }
}
