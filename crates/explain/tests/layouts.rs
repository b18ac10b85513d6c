//! No octet is lost: 10,000 random telegrams in random text layouts, whole and cut anywhere, in portions of any size.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::decoded;
use profivac_dp::link::Baud;
use profivac_explain::Decoder;
use profivac_explain::frame::{Piece, PieceKind};
use profivac_explain::input::{Capture, Source, SourceKind};
use profivac_sim::Random;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::fmt::Write as _;
use std::io::Read;

const LAYOUTS: u64 = 10_000;

fn telegram(random: &mut Random) -> Vec<u8> {
    let du: Vec<u8> = (0..random.below(40)).map(|_| random.octet()).collect();
    let (da, sa) = (random.octet() & 0x7F, random.octet() & 0x7F);
    let data = DataTelegram { da, sa, dsap: None, ssap: None, fc: random.octet(), du: &du };
    let telegram = match random.below(6) {
        0 => Telegram::ShortAck,
        1 => Telegram::Token { da: da.min(126), sa: sa.min(126) },
        2 => Telegram::Data(DataTelegram { du: &[], ..data }),
        3 => Telegram::Data(DataTelegram { dsap: Some(random.octet()), ssap: Some(62), ..data }),
        // Zeros, of which od and hexdump omit lines.
        4 => Telegram::Data(DataTelegram { du: &[0; 150], ..data }),
        _ => Telegram::Data(data),
    };
    let mut out = [0; MAX_TELEGRAM];
    let length = telegram.emit(&mut out).unwrap();
    out[..length].to_vec()
}

/// A text with octets, and the text of each octet or of each line of a dump.
#[derive(Default)]
struct Layout {
    name: String,
    text: String,
    /// Position in the text, its end, and the octets there.
    places: Vec<(usize, usize, Vec<u8>)>,
}

impl Layout {
    fn octets(&mut self, text: &str, octets: &[u8]) {
        let from = self.text.len();
        self.text += text;
        self.places.push((from, self.text.len(), octets.to_vec()));
    }
}

fn one_of<'a>(random: &mut Random, choices: &[&'a str]) -> &'a str {
    choices[random.below(choices.len() as u64) as usize]
}

fn hex(octet: u8, is_upper: bool) -> String {
    if is_upper { format!("{octet:02X}") } else { format!("{octet:02x}") }
}

fn characters(row: &[u8]) -> String {
    row.iter().map(|octet| if (0x20..0x7F).contains(octet) { char::from(*octet) } else { '.' }).collect()
}

/// Octets with separators between them, in lines or in one line, with or without text around them.
fn plain(random: &mut Random, telegrams: &[Vec<u8>]) -> Layout {
    let is_upper = random.below(2) == 0;
    let (before, after, between) = match random.below(12) {
        0 => ("", "", ""),
        1 => ("", "", ":"),
        2 => ("", "", "-"),
        3 => ("0x", "", ","),
        4 => ("0x", "", ", "),
        5 => ("", "h", " "),
        6 => ("$", "", " "),
        7 => ("\\x", "", ""),
        8 => ("", "", ";"),
        9 => ("", "", ", "),
        10 => ("", "", "  "),
        _ => ("", "", " "),
    };
    let prefix =
        one_of(random, &["", "", "TX ", "RX: ", "12.5 ", "[rx] -> ", "12:00:00.25 PHY-serial: TX   ", "> ", "  "]);
    let suffix = one_of(random, &["", "", " # a comment", " // the end", "  (an answer)", ",", "\r"]);
    let rows: Vec<Vec<u8>> = match random.below(4) {
        0 => telegrams.to_vec(),
        1 => vec![telegrams.concat()],
        2 => telegrams.concat().chunks(16).map(<[u8]>::to_vec).collect(),
        _ => telegrams.concat().chunks(1 + random.below(60) as usize).map(<[u8]>::to_vec).collect(),
    };
    let mut layout =
        Layout { name: format!("{prefix:?} {before:?} {between:?} {after:?} {suffix:?}"), ..Layout::default() };
    for row in rows {
        if random.below(20) == 0 {
            layout.text += one_of(random, &["# 10 02 a comment\n", "// waiting\n", "\n", "no answer yet\n"]);
        }
        layout.text += prefix;
        for (number, octet) in row.iter().enumerate() {
            layout.text += if number == 0 { "" } else { between };
            layout.octets(&format!("{before}{}{after}", hex(*octet, is_upper)), &[*octet]);
        }
        layout.text += suffix;
        layout.text += "\n";
    }
    layout
}

/// The octets of a row in groups of `width`, the last octet of a group first if it `swaps`.
fn words(row: &[u8], swaps: bool, width: usize) -> Vec<String> {
    let groups = row.chunks(width).map(|group| {
        let mut group = group.to_vec();
        if swaps {
            group.resize(width, 0);
            group.reverse();
        }
        group.iter().map(|octet| hex(*octet, false)).collect::<String>()
    });
    groups.collect()
}

/// The programs and options that a dump may come from: 0 to 3 are od, 4 to 6 hexdump, 7 and 8 xxd.
type DumpKind = u64;

fn dump_address(kind: DumpKind, radix: u64, at: usize) -> String {
    match (kind, radix) {
        (0, 0) => format!("{at:06x}"),
        (0, 1) => format!("{at:07}"),
        (0..=3, _) => format!("{at:07o}"),
        (4 | 5, _) => format!("{at:07x}"),
        (6, _) => format!("{at:08x}"),
        _ => format!("{at:08x}:"),
    }
}

fn dump_row(kind: DumpKind, row: &[u8], has_characters: bool) -> String {
    let text = match kind {
        0 => words(row, false, 1).join(" "),
        1 | 4 => words(row, true, 2).join(" "),
        2 => {
            let number = |pair: &[u8]| u16::from_le_bytes([pair[0], pair.get(1).copied().unwrap_or(0)]);
            row.chunks(2).map(|pair| format!("{:06o}", number(pair))).collect::<Vec<_>>().join(" ")
        }
        3 => row.iter().map(|octet| format!("{octet:03o}")).collect::<Vec<_>>().join(" "),
        5 => words(row, true, 4).join(" "),
        6 => row.chunks(8).map(|half| words(half, false, 1).join(" ")).collect::<Vec<_>>().join("  "),
        7 => words(row, false, 2).join(" "),
        _ => words(row, false, 1).join(" "),
    };
    let shown = match kind {
        0 if has_characters => format!("  >{}<", characters(row)),
        6 => format!("  |{}|", characters(row)),
        7 | 8 => format!("  {}", characters(row)),
        _ => String::new(),
    };
    text + &shown
}

/// A dump as od, hexdump and xxd print it.
fn dump(random: &mut Random, octets: &[u8]) -> Layout {
    let kind = random.below(9);
    let columns = if kind >= 7 { 1 + random.below(40) as usize } else { 16 };
    let omits = kind < 7 && random.below(2) == 0;
    let has_characters = random.below(2) == 0;
    let radix = random.below(4);
    let mut layout =
        Layout { name: format!("dump {kind} of {columns}, address {radix}, omits {omits}"), ..Layout::default() };
    let (mut before, mut is_omitting): (Option<&[u8]>, bool) = (None, false);
    for (number, row) in octets.chunks(columns).enumerate() {
        if omits && before == Some(row) {
            let last = layout.places.last_mut().unwrap();
            last.2.extend(row);
            if !is_omitting {
                layout.text += "*\n";
            }
            is_omitting = true;
            layout.places.last_mut().unwrap().1 = layout.text.len();
            continue;
        }
        (before, is_omitting) = (Some(row), false);
        let address = dump_address(kind, radix, number * columns);
        layout.octets(&format!("{address} {}\n", dump_row(kind, row, has_characters)), row);
    }
    if kind < 7 {
        writeln!(layout.text, "{}", dump_address(kind, radix, octets.len())).unwrap();
    }
    layout
}

/// The plain dump of xxd, and an array in C.
fn joined(random: &mut Random, octets: &[u8]) -> Layout {
    let mut layout = Layout { name: "xxd -p or -i".to_owned(), ..Layout::default() };
    let is_array = random.below(2) == 0;
    if is_array {
        layout.text += "unsigned char line[] = {\n";
    }
    for row in octets.chunks(if is_array { 12 } else { 30 }) {
        for octet in row {
            layout.octets(&if is_array { format!(" 0x{octet:02x},") } else { hex(*octet, false) }, &[*octet]);
        }
        layout.text += "\n";
    }
    if is_array {
        layout.text += "};\n";
    }
    layout
}

fn layout(random: &mut Random, telegrams: &[Vec<u8>]) -> Layout {
    let octets = telegrams.concat();
    match random.below(4) {
        0 => dump(random, &octets),
        1 => joined(random, &octets),
        _ => plain(random, telegrams),
    }
}

/// A decoded text.
struct Decoded {
    octets: Vec<u8>,
    left_over: u64,
    telegrams: Vec<Vec<u8>>,
}

/// Decodes a text and checks that its octets are the sum of telegrams, damage and left-over.
fn decoded(text: &str, name: &str) -> Decoded {
    let capture =
        Capture::read(text.as_bytes(), Baud::B500000).unwrap_or_else(|error| panic!("{name}: {error}:\n{text}"));
    assert_eq!(capture.kind, SourceKind::Text, "{name}:\n{text}");
    let (decoder, explained) = decoded::decoded(&capture, Baud::B500000);
    let counts = decoder.explainer().summary().octets;
    assert_eq!(counts.telegrams + counts.doubtful + counts.damaged, capture.octets, "{name}");
    let octets: Vec<u8> = explained.iter().flat_map(|explained| explained.piece.octets.clone()).collect();
    assert_eq!(octets.len() as u64, capture.octets, "{name}");
    let left_over = capture.left_over.iter().map(|left_over| left_over.octets as u64).sum();
    let valid = explained.into_iter().filter(|explained| explained.piece.kind == PieceKind::Valid);
    Decoded { octets, left_over, telegrams: valid.map(|explained| explained.piece.octets).collect() }
}

#[test]
fn every_octet_of_10000_random_layouts_is_decoded() {
    let mut random = Random::new(1);
    let mut found = 0;
    for number in 0..LAYOUTS {
        let telegrams: Vec<Vec<u8>> = (0..3 + random.below(30)).map(|_| telegram(&mut random)).collect();
        let layout = layout(&mut random, &telegrams);
        let name = format!("layout {number}: {}", layout.name);
        let decoded = decoded(&layout.text, &name);
        assert_eq!(decoded.octets, telegrams.concat(), "{name}:\n{}", layout.text);
        assert_eq!(decoded.left_over, 0, "{name}:\n{}", layout.text);
        found += usize::from(decoded.telegrams == telegrams);
    }
    // The others have an SC or a token that fits into a telegram which fits by chance.
    assert!(found as u64 > LAYOUTS - LAYOUTS / 100, "{found}");
}

/// A text that begins and ends anywhere, within an octet, an address or a comment: the octets between are decoded, and what
/// remains of the first and the last line is decoded or left over.
#[test]
fn every_octet_of_10000_layouts_that_are_cut_anywhere_is_decoded_or_left_over() {
    let mut random = Random::new(2);
    for number in 0..LAYOUTS {
        let telegrams: Vec<Vec<u8>> = (0..10 + random.below(30)).map(|_| telegram(&mut random)).collect();
        let layout = layout(&mut random, &telegrams);
        let length = layout.text.len() as u64;
        let (from, to) = (random.below(length / 3) as usize, (length - random.below(length / 3)) as usize);
        let text = &layout.text[from..to];
        let name = format!("layout {number}, {from} to {to}: {}", layout.name);
        let decoded = decoded(text, &name);
        // The number of lines that a dump omits at the end is in the address that was cut off.
        let places = layout.places.iter().filter(|(begin, end, _)| from <= *begin && *end <= to);
        let mut places: Vec<_> = places.collect();
        if layout.text[..to].contains('*') {
            places.pop();
        }
        let count: usize = places.iter().map(|(_, _, octets)| octets.len()).sum();
        assert!(decoded.octets.len() + decoded.left_over as usize >= count, "{name}: {count} of\n{text}");
        // In text of several lines, the first and the last one may be too short to show that they have octets.
        let (first, last) = match (text.find('\n'), text.trim_end().rfind('\n')) {
            (Some(first), Some(last)) if first < last => (from + first, from + last),
            _ => (from + 4, to - 4),
        };
        let inner = places.iter().filter(|(begin, end, _)| first <= *begin && *end <= last + 1);
        let inner: Vec<u8> = inner.flat_map(|(_, _, octets)| octets.iter().copied()).collect();
        let shown = profivac_sim::describe::Hex(&inner).to_string();
        assert!(
            decoded.octets.windows(inner.len().max(1)).any(|part| part == inner) || inner.is_empty(),
            "{name}: {shown} of\n{text}"
        );
    }
}

/// Returns a few octets per read, like a pipe.
struct Pipe<'a> {
    octets: &'a [u8],
    random: Random,
}

impl Read for Pipe<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = 1 + self.random.below(20);
        self.octets.by_ref().take(count).read(buffer)
    }
}

/// The pieces of a file that is read from a pipe, and its kind.
fn piped(file: &[u8], seed: u64) -> (SourceKind, Vec<Piece>) {
    let mut source = Source::open(Pipe { octets: file, random: Random::new(seed) }, Baud::B500000).unwrap();
    let (mut decoder, mut explained, mut has_more) = (Decoder::new(source.clock(), source.times), Vec::new(), true);
    while has_more {
        let mut chunks = Vec::new();
        has_more = source.read(&mut chunks).unwrap();
        chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    }
    decoder.end(&mut explained);
    (source.kind, explained.into_iter().map(|explained| explained.piece).collect())
}

#[test]
fn a_pipe_in_portions_of_any_size_has_the_result_of_a_file() {
    let mut random = Random::new(3);
    for number in 0..500 {
        let telegrams: Vec<Vec<u8>> = (0..3 + random.below(10)).map(|_| telegram(&mut random)).collect();
        let octets = match random.below(3) {
            0 => layout(&mut random, &telegrams).text.into_bytes(),
            // A mark of UTF-8 before octets of a line is three octets of the line.
            1 => [&[0xEF, 0xBB, 0xBF][..], &telegrams.concat()].concat(),
            _ => telegrams.concat(),
        };
        let whole = Capture::read(&octets, Baud::B500000).unwrap();
        let (_, explained) = decoded::decoded(&whole, Baud::B500000);
        let pieces: Vec<Piece> = explained.into_iter().map(|explained| explained.piece).collect();
        assert_eq!(piped(&octets, number), (whole.kind, pieces), "file {number}");
    }
}

/// A packet of any size is split, so that the memory for its pieces is limited.
#[test]
fn a_large_packet_and_a_long_line_become_chunks_of_limited_size() {
    use profivac_sim::trace::{Entry, Trace, pcapng};
    let entry = Entry::new(profivac_dp::link::BitTime(7), [0xE5; 100_000], vec![50_000]);
    let trace = Trace { baud: Baud::B500000, entries: [entry].into() };
    let text = "E5 ".repeat(100_000);
    for file in
        [pcapng::write(&trace, pcapng::USER0), trace.to_string().into_bytes(), text.into_bytes(), vec![0xE5; 100_000]]
    {
        let capture = Capture::read(&file, Baud::B500000).unwrap();
        assert_eq!(capture.octets, 100_000);
        assert!(capture.chunks.iter().all(|chunk| chunk.octets.len() <= 4096), "{:?}", capture.kind);
        let (last, others) = capture.chunks.split_last().unwrap();
        assert!(others.iter().all(|chunk| chunk.is_continued));
        if capture.kind == SourceKind::Pcapng {
            assert!(!last.is_continued);
            assert_eq!(capture.chunks[1].start.unwrap().0, 7 + 4096 * 11);
            assert_eq!(capture.chunks[12].errors, [50_000 - 12 * 4096]);
        }
    }
}
