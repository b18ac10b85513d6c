//! What loggers and logic analysers print: one octet a line, tables, numbers, strings, calls. Random octets with telegrams between them, and
//! samples of the programs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_dp::link::Baud;
use profivac_explain::input::{Capture, Notation, Source, SourceKind};
use profivac_sim::Random;
use profivac_sim::dialogue::hex;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::fmt::Write as _;
use std::io::Read;

/// The streams of each notation of [`text`], which loses no octet.
const STREAMS: u64 = 1_000;

/// The streams of each notation whose text may have octets that are left over; `PROFIVAC_CASES` is another number.
const FEW_STREAMS: u64 = 200;

/// The notations of [`text`].
const KINDS: u64 = 13;

fn telegram(random: &mut Random) -> Vec<u8> {
    let du: Vec<u8> = (0..random.below(12)).map(|_| random.octet()).collect();
    let (da, sa) = (random.octet() & 0x7F, random.octet() & 0x7F);
    let data = DataTelegram { da, sa, dsap: None, ssap: None, fc: random.octet(), du: &du };
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(data).emit(&mut out).unwrap();
    out[..length].to_vec()
}

/// Groups of octets: telegrams with a check octet, SC, tokens and damaged octets; at least one telegram.
fn groups(random: &mut Random) -> Vec<Vec<u8>> {
    let mut groups = vec![telegram(random)];
    for _ in 0..random.below(8) {
        let group = match random.below(6) {
            0 => vec![0xE5],
            1 => vec![0xDC, random.octet() & 0x7F, random.octet() & 0x7F],
            2 => (0..1 + random.below(9)).map(|_| random.octet()).collect(),
            _ => telegram(random),
        };
        let at = random.below(groups.len() as u64 + 1) as usize;
        groups.insert(at, group);
    }
    groups
}

fn list(octets: &[u8], separator: &str) -> String {
    octets.iter().map(u8::to_string).collect::<Vec<_>>().join(separator)
}

/// A string as Python writes it.
fn python(octets: &[u8]) -> String {
    octets.iter().fold(String::new(), |mut text, octet| {
        match octet {
            b'\n' => text += "\\n",
            b'\r' => text += "\\r",
            b'\t' => text += "\\t",
            b'\\' => text += "\\\\",
            b'\'' => text += "\\'",
            0x20..0x7F => text.push(char::from(*octet)),
            _ => write!(text, "\\x{octet:02x}").unwrap(),
        }
        text
    })
}

/// A string as strace writes it: octal without leading zeros, unless a digit follows.
fn octal(octets: &[u8]) -> String {
    let mut text = String::new();
    for (at, octet) in octets.iter().enumerate() {
        let is_digit = octets.get(at + 1).is_some_and(u8::is_ascii_digit);
        match octet {
            b'\n' => text += "\\n",
            b'\r' => text += "\\r",
            b'\t' => text += "\\t",
            11 => text += "\\v",
            12 => text += "\\f",
            b'"' => text += "\\\"",
            b'\\' => text += "\\\\",
            0x20..0x7F => text.push(char::from(*octet)),
            _ if is_digit => write!(text, "\\{octet:03o}").unwrap(),
            _ => write!(text, "\\{octet:o}").unwrap(),
        }
    }
    text
}

fn letters(octet: u8) -> String {
    if octet.is_ascii_graphic() { char::from(octet).to_string() } else { format!("[{octet:02X}]") }
}

/// A text of each octet.
type Single = fn(u8) -> String;

const SINGLE: [(&str, Single); 6] = [
    ("hexadecimal", |octet| format!("{octet:02X}")),
    ("hexadecimal", |octet| format!("0x{octet:02X}")),
    ("decimal", |octet| octet.to_string()),
    ("binary", |octet| format!("{octet:08b}")),
    ("octal", |octet| format!("{octet:03o}")),
    ("characters", letters),
];

/// A text with the groups in notation `number`, and the notation that is found.
fn text(number: u64, random: &mut Random, groups: &[Vec<u8>]) -> (String, Notation) {
    let mut text = String::new();
    let (radix, single) = SINGLE[random.below(SINGLE.len() as u64) as usize];
    let mut seconds = 0.0;
    let mut time = || {
        seconds += 0.000_573;
        seconds
    };
    let octets = groups.concat();
    match number {
        // sigrok-cli, with the bits of each character where its format has two digits.
        0 => {
            let has_bits = radix == "hexadecimal" && random.below(2) == 0;
            for octet in octets {
                if has_bits {
                    text += "uart-1: Start bit\nuart-1: 0\nuart-1: 1\n";
                }
                writeln!(text, "uart-1: {}", single(octet)).unwrap();
                if has_bits {
                    text += "uart-1: Parity bit\nuart-1: Stop bit\n";
                }
            }
            (text, Notation::Single(radix))
        }
        // PulseView, with the samples of the data bits.
        1 => {
            for (at, octet) in octets.iter().enumerate() {
                let direction = if random.below(2) == 0 { "RX" } else { "TX" };
                let from = 1000 + at * 573;
                writeln!(text, "{from}-{} UART: {direction} data: {}", from + 417, single(*octet)).unwrap();
            }
            (text, Notation::Single(radix))
        }
        // Saleae Logic 2.
        2 => {
            text += "name,type,start_time,duration,data,error\n";
            for octet in octets {
                let field = single(octet);
                let field =
                    if field.contains([',', '"']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field };
                writeln!(text, "\"Async Serial\",\"data\",{},0.000572917,{field},", time()).unwrap();
            }
            (text, Notation::Table(radix))
        }
        // A table of a computer with decimal commas.
        3 => {
            text += "Time [ms];Value;Parity Error;Framing Error\r\n";
            for octet in octets {
                let field = single(octet).replace('"', "\"\"\"\"").replace(';', "\";\"");
                writeln!(text, "{};{field};;\r", (time() * 1e3).to_string().replace('.', ",")).unwrap();
            }
            (text, Notation::Table(radix))
        }
        4 => {
            groups.iter().for_each(|group| writeln!(text, "{} TX [{}]", time(), list(group, ", ")).unwrap());
            (text, Notation::Decimal)
        }
        5 => {
            for group in groups {
                writeln!(text, r#"{{"time": {}, "bytes": {}, "data": [{}]}}"#, time(), group.len(), list(group, ","))
                    .unwrap();
            }
            (text, Notation::Decimal)
        }
        // An array of JSON with a number a line.
        6 => (format!("[\n  {}\n]\n", list(&octets, ",\n  ")), Notation::Single("decimal")),
        7 => {
            groups.iter().for_each(|group| writeln!(text, "12:00:00,250 sent b'{}'", python(group)).unwrap());
            (text, Notation::Strings)
        }
        8 => {
            groups.iter().for_each(|group| writeln!(text, "sent \"{}\"", octal(group)).unwrap());
            (text, Notation::Strings)
        }
        // Java prints signed bytes.
        9 => {
            groups.iter().for_each(|group| {
                let bytes: Vec<String> = group.iter().map(|octet| octet.cast_signed().to_string()).collect();
                writeln!(text, "12:00:00.25 TX: [{}]", bytes.join(", ")).unwrap();
            });
            (text, Notation::Decimal)
        }
        10 => (with_letters(&octets, LettersOf::Od), Notation::Letters),
        11 => (with_letters(&octets, LettersOf::Hexdump), Notation::Letters),
        _ => {
            text += "06:48:59.9 openat(AT_FDCWD, \"/dev/ttyUSB0\", O_RDWR|O_NOCTTY) = 3\n";
            for group in groups {
                let (octets, count) = (octal(group), group.len());
                let line = match random.below(3) {
                    0 => format!("06:49:05.1 write(3, \"{octets}\", {count}) = {count}"),
                    1 => format!("06:49:05.1 read(3, \"{octets}\", 255) = {count}"),
                    _ => format!(
                        "[pid 7] read(3, <unfinished ...>\n[pid 7] <... read resumed> \"{octets}\", 255) = {count}"
                    ),
                };
                writeln!(text, "{line}\n06:49:05.2 write(1, \"12 octets\\n\", 10) = 10").unwrap();
            }
            (text, Notation::Calls)
        }
    }
}

/// The number of streams: `usual`, or `PROFIVAC_CASES`.
fn cases(usual: u64) -> u64 {
    std::env::var("PROFIVAC_CASES").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// The notation, the octets and the number of octets that are left over.
fn read(file: &[u8]) -> (Option<Notation>, Vec<u8>, usize) {
    let mut source = Source::open(file, Baud::B19200).unwrap();
    let mut chunks = Vec::new();
    while source.read(&mut chunks).unwrap() {}
    let left_over = source.left_over.iter().map(|text| text.octets).sum();
    (source.notation(), chunks.into_iter().flat_map(|chunk| chunk.octets).collect(), left_over)
}

#[test]
fn every_octet_of_random_streams_is_read_in_each_notation() {
    let (count_of_streams, mut random) = (cases(STREAMS), Random::new(46));
    let mut counts = [0; KINDS as usize];
    for number in 0..count_of_streams {
        let groups = groups(&mut random);
        for (kind, count) in (0..KINDS).zip(&mut counts) {
            let (text, expected) = text(kind, &mut random, &groups);
            let (notation, octets, left_over) = read(text.as_bytes());
            assert_eq!((octets, left_over), (groups.concat(), 0), "stream {number}, {notation:?}:\n{text}");
            // Octets with few digits fit several notations: the octets are the same in each of them.
            *count += u64::from(notation == Some(expected));
        }
    }
    for (kind, count) in counts.iter().enumerate() {
        assert!(*count * 2 >= count_of_streams, "notation {kind} is found {count} times of {count_of_streams}");
    }
}

#[test]
fn rows_between_commas_and_numbers_with_names_lose_no_octet_and_add_none() {
    let request = [0x10, 0x08, 0x02, 0x49, 0x53, 0x16];
    let answer = [0x68, 0x05, 0x05, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16];
    let both = [request.as_slice(), &answer].concat();
    for (text, octets) in [
        ("10 08 02 49 53 16, 68 05 05 68 88 82 6D 3C 3E F1 16\n", both.as_slice()),
        ("time,TX,RX\n0.001, 10 08 02 49 53 16,\n0.003, , 68 05 05 68 88 82 6D 3C 3E F1 16\n", &both),
        ("len:06 10 08 02 49 53 16\n", &request),
        ("RX len:11 68 05 05 68 88 82 6D 3C 3E F1 16\n", &answer),
        ("seq:0001 10 08 02 49 53 16\n", &request),
        ("RX len:11 104 5 5 104 136 130 109 60 62 241 22\n", &answer),
        ("TX:10 08 02 49 53 16\n", &request),
    ] {
        let (notation, read, left_over) = read(text.as_bytes());
        assert_eq!((read.as_slice(), left_over), (octets, 0), "{notation:?}: {text}");
    }
}

/// The last octet of a row and the first ones of the next one may be a telegram by chance.
#[test]
fn a_reading_with_the_telegram_in_one_row_is_preferred() {
    let text = "12:00:00.1,Tx,4,83 ED 0E 10\n12:00:01.1,Rx,6,10 60 03 52 B5 16\n";
    let (_, octets, left_over) = read(text.as_bytes());
    assert_eq!((octets, left_over), (hex("83 ED 0E 10 10 60 03 52 B5 16"), 0), "{text}");
}

/// The first lines of a table have a telegram of six octets by chance: `10 04 04 10 18 16` in the first two digits of decimal numbers.
#[test]
fn a_telegram_by_chance_among_many_other_octets_does_not_show_the_notation() {
    let octets = hex("68 04 04 68 12 10 FE A6 C6 16 68 05 05 68 3C 4D 82 13 EB 09 16");
    let rows: String = octets.iter().map(|octet| format!("0.0,'{octet}' (0x{octet:02X}),,\n")).collect();
    let text = String::from("Time [s],Value,Parity Error,Framing Error\n") + &rows;
    assert_eq!(read(text.as_bytes()), (Some(Notation::Table("hexadecimal")), octets, 0), "{text}");
}

/// The characters of `2A 2F` are the end of a comment in C.
#[test]
fn the_end_of_a_comment_among_its_characters_does_not_end_it() {
    let request = "0x10, 0x08, 0x02, 0x49, 0x53, 0x16 /* a comment */\n";
    let text = format!(
        "{request}0x68, 0x06, 0x06, 0x68, 0x7d, 0x45, 0x4e, 0x2e, 0x2a, 0x2f, 0x97, 0x16 /* h..h}}EN.*/.. */\n"
    );
    let expected = hex("10 08 02 49 53 16 68 06 06 68 7D 45 4E 2E 2A 2F 97 16");
    assert_eq!(read(text.as_bytes()), (Some(Notation::Hexadecimal), expected, 0), "{text}");
    let between = "/* TX */ 0x10, 0x08, 0x02, 0x49, 0x53, 0x16 /* end */\n";
    assert_eq!(read(between.as_bytes()).1, hex("10 08 02 49 53 16"), "{between}");
}

/// Two numbers that could be seconds since 1970: the second one has the octets.
#[test]
fn joined_octets_behind_a_time_are_no_time() {
    let text = "{\"ts\": 1764417605, \"hex\": \"100802495316\"}\n{\"ts\": 1764417606, \"hex\": \"1453592557\"}\n";
    let (_, octets, left_over) = read(text.as_bytes());
    assert_eq!((octets, left_over), (hex("10 08 02 49 53 16 14 53 59 25 57"), 0), "{text}");
}

/// Returns few octets for each read.
struct Pipe<'a>(&'a [u8], Random);

impl Read for Pipe<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = 1 + self.1.below(20);
        Read::by_ref(&mut self.0).take(count).read(buffer)
    }
}

#[test]
fn a_pipe_in_small_portions_has_the_octets_of_a_file_in_each_notation() {
    let mut random = Random::new(47);
    for number in 0..200 {
        let groups = groups(&mut random);
        let (text, _) = text(number % KINDS, &mut random, &groups);
        let mut source = Source::open(Pipe(text.as_bytes(), Random::new(number)), Baud::B19200).unwrap();
        let mut chunks = Vec::new();
        while source.read(&mut chunks).unwrap() {}
        let whole = Capture::read(text.as_bytes(), Baud::B19200).unwrap();
        assert_eq!((&source.left_over, chunks), (&whole.left_over, whole.chunks), "{text}");
    }
}

/// The seconds of the first chunks.
fn seconds(file: &str) -> Vec<f64> {
    let chunks = Capture::read(file.as_bytes(), Baud::B19200).unwrap().chunks;
    chunks.iter().filter_map(|chunk| chunk.start).map(|start| start.0 as f64 / 12e6).collect()
}

fn lines(octets: &str, line: impl Fn(usize, u8) -> String) -> String {
    hex(octets).into_iter().enumerate().map(|(at, octet)| line(at, octet) + "\n").collect()
}

const REQUEST: &str = "10 08 02 49 53 16";

#[test]
fn an_octet_has_the_time_of_its_line() {
    // 1 MHz at 19200 bit/s: 416 samples for eight bits, and the start bit begins 52 samples before them.
    let samples =
        lines(REQUEST, |at, octet| format!("{}-{} uart-1: {octet:02X}", 2136 + at * 573, 2136 + at * 573 + 418));
    let table = String::from("Time [ms];Value\n") + &lines(REQUEST, |at, octet| format!("{},5;0x{octet:02X}", 2 + at));
    let words = lines(REQUEST, |at, octet| format!("12:00:0{at}.5 port 3: {octet}"));
    let units = lines(REQUEST, |at, octet| format!("{}.5 ms port 3: {octet}", at + 2));
    for (text, first, second) in [
        (samples, 0.002_084, 0.002_657),
        (table, 0.002_5, 0.003_5),
        (words, 43200.5, 43201.5),
        (units, 0.002_5, 0.003_5),
    ] {
        let times = seconds(&text);
        let is_near = |time: f64, expected: f64| (time - expected).abs() < 60e-6;
        assert!(times.len() == 6 && is_near(times[0], first) && is_near(times[1], second), "{times:?}\n{text}");
    }
}

#[test]
fn an_error_behind_an_octet_and_in_its_column_marks_it() {
    let mut behind = lines(REQUEST, |_, octet| format!("uart-1: {octet:02x}"));
    behind = behind.replace("uart-1: 02\n", "uart-1: 02\nuart-1: Frame error\n") + &behind;
    let table = String::from("Time [s],Value,Parity Error,Framing Error\n")
        + &lines(REQUEST, |at, octet| format!("0.{at},0x{octet:02X},{},", if at == 2 { "Error" } else { "" }))
        + &lines(REQUEST, |at, octet| format!("1.{at},0x{octet:02X},,"));
    for text in [behind, table] {
        let errors: Vec<bool> = Capture::read(text.as_bytes(), Baud::B19200)
            .unwrap()
            .chunks
            .iter()
            .map(|chunk| !chunk.errors.is_empty())
            .collect();
        assert_eq!(errors.iter().position(|has_error| *has_error), Some(2), "{text}");
        assert_eq!(errors.iter().filter(|has_error| **has_error).count(), 1, "{text}");
    }
}

/// Octets behind other words are no octets of the line, and none is lost.
#[test]
fn octets_behind_other_words_are_left_over() {
    let text =
        lines(REQUEST, |_, octet| format!("uart-1: RX data: {octet:02X}\nspi-1: MOSI data: {octet:02X}00\nspi-1: 77"));
    let (notation, octets, left_over) = read(text.as_bytes());
    assert_eq!((notation, octets, left_over), (Some(Notation::Single("hexadecimal")), hex(REQUEST), 6));
}

#[test]
fn numbers_of_three_digits_are_decimal_without_a_telegram() {
    for text in ["TX [16, 8, 2, 73, 84, 22]\nRX [229, 104, 136]\n", "RX 104 5 5 104 136 130 109 60 62 242 22\n"] {
        assert_eq!(read(text.as_bytes()).0, Some(Notation::Decimal), "{text}");
    }
    for text in ["10 08 02 49 54 16\n", "TX 10 08 02 49 54 16 (100)\n", "E5 100 200 30 40\n"] {
        assert_eq!(read(text.as_bytes()).0, Some(Notation::Hexadecimal), "{text}");
    }
}

/// Calls of other files are none of the line; what strace does not print is left over.
#[test]
fn the_calls_of_strace_have_the_octets_of_the_line_alone() {
    let text = "\
openat(AT_FDCWD, \"/etc/ld.so.cache\", O_RDONLY|O_CLOEXEC) = 3\n\
read(3, \"\\177ELF\\2\\1\\1\\3\"..., 832) = 832\n\
openat(AT_FDCWD, \"/dev/ttyUSB0\", O_RDWR) = 4\n\
write(4, \"\\20\\10\\2IS\\26\", 6) = 6\n\
read(4, 0x7ffe, 255) = -1 EAGAIN (Resource temporarily unavailable)\n\
read(4</dev/ttyUSB0>, \"\\345\", 255) = 1\n\
read(4, \"h\\5\\5h\"..., 255) = 11\n\
write(1, \"12 13 14\\n\", 9) = 9\n";
    let (notation, octets, left_over) = read(text.as_bytes());
    assert_eq!((notation, octets, left_over), (Some(Notation::Calls), hex("10 08 02 49 53 16 E5 68 05 05 68"), 7));
}

/// A clock, a date, a decimal comma, a unit of time and the counters of socat.
#[test]
fn a_number_that_is_no_octet_is_none() {
    for (front, seconds) in [
        ("12.5 us TX ", 12.5e-6),
        ("12.5us TX ", 12.5e-6),
        ("1250 us TX ", 1250e-6),
        ("12,5 ms TX ", 12.5e-3),
        ("12.50 ms:\n", 12.5e-3),
        ("12 ms:\n", 12e-3),
        ("12:00:00,250 RX ", 43200.25),
        ("2026-11-29 12:00:00 RX ", 43200.0),
        ("2026-11-29 12:00:00,250 INFO RX ", 43200.25),
        ("Nov 29 12:00:00 host RX ", 43200.0),
        ("29.11.26 12:00:00 RX ", 43200.0),
        ("0,002500;RX;", 0.0025),
        ("2,5\tRX\t", 2.5),
        ("> 2026/11/29 12:00:00.000250  length=11 from=12 to=22\n ", 43_200.000_25),
        ("> 2026/11/29 12:00:00.000250000  length=11 from=12 to=22\n ", 43_200.25),
        ("2026-11-29 12:00:00.000250:\n", 43_200.000_25),
    ] {
        for octets in [REQUEST, "E5"] {
            let text = format!("{front}{REQUEST}\n{front}{octets}\n");
            let capture = Capture::read(text.as_bytes(), Baud::B19200).unwrap();
            let read: Vec<Vec<u8>> = capture.chunks.iter().map(|chunk| chunk.octets.clone()).collect();
            assert_eq!((read, capture.left_over), (vec![hex(REQUEST), hex(octets)], vec![]), "{text}");
            for chunk in capture.chunks {
                let start = chunk.start.unwrap().0 as f64 / 12e6;
                assert!((start - seconds).abs() < 1e-6, "{start} in {text}");
            }
        }
    }
}

/// A unit behind a number makes it a time; behind octets, or behind another time, it is no time of theirs.
#[test]
fn a_number_with_a_unit_is_a_time_in_each_notation() {
    for (line, expected) in [
        ("5 ms 16 8 2 73 83 22", 0.005),
        ("TX 16 8 2 73 83 22", 0.0),
        ("1250 us TX [16, 8, 2, 73, 83, 22]", 0.001_25),
        ("12:00:00.25 2.5 ms TX [16, 8, 2, 73, 83, 22]", 43_200.25),
        ("2.5 ms TX b'\\x10\\x08\\x02IS\\x16'", 0.002_5),
    ] {
        let text = format!("{line}\n{line} (12 ms)\n");
        let (notation, octets, left_over) = read(text.as_bytes());
        assert_eq!((octets, left_over), ([hex(REQUEST), hex(REQUEST)].concat(), 0), "{notation:?}: {text}");
        let found = seconds(&text);
        assert!(found.iter().all(|time| (time - expected).abs() < 1e-6), "{found:?} in {text}");
    }
}

/// The descriptor of a file that was closed becomes a socket; addresses of sockets are no octets of the line.
#[test]
fn calls_of_a_socket_have_its_octets_and_not_its_address() {
    let text = "\
openat(AT_FDCWD, \"/etc/hosts\", O_RDONLY) = 3\n\
close(3) = 0\n\
socket(AF_INET, SOCK_DGRAM, IPPROTO_IP) = 3\n\
sendto(3, \"\\20\\10\\2IS\\26\", 6, 0, {sa_family=AF_INET, sin_port=htons(502), sin_addr=inet_addr(\"10.0.0.1\")}, 16) = 6\n\
recvfrom(3, \"h\\5\\5h\"..., 300, 0, {sa_family=AF_INET, sin_port=htons(502), sin_addr=inet_addr(\"10.0.0.1\")}, [16]) = 11\n\
recvmsg(3, {msg_name={sa_family=AF_UNIX, sun_path=\"/run/bus\"}, msg_namelen=16, msg_iov=[{iov_base=\"\\345\", iov_len=300}], msg_flags=0}, 0) = 1\n";
    let (notation, octets, left_over) = read(text.as_bytes());
    assert_eq!((notation, octets, left_over), (Some(Notation::Calls), hex("10 08 02 49 53 16 68 05 05 68 E5"), 7));
}

#[test]
fn a_table_with_a_column_for_each_direction_has_the_octets_of_both() {
    let both = hex("10 08 02 49 53 16 10 02 08 08 12 16 10 08 02 49 53 16 10 02 08 08 12 16");
    let mut text = "Time [s],TX,RX\n".to_owned();
    for (at, octet) in both.iter().enumerate() {
        let (sent, received) = if at / 6 % 2 == 0 {
            (format!("0x{octet:02X}"), String::new())
        } else {
            (String::new(), format!("0x{octet:02X}"))
        };
        writeln!(text, "0.{at:03},{sent},{received}").unwrap();
    }
    let (notation, octets, left_over) = read(text.as_bytes());
    assert_eq!((notation, octets, left_over), (Some(Notation::Table("hexadecimal")), both, 0));
}

/// A number in front of the octets is no octet if its rule holds in every line; one that breaks the rule later is left over.
#[test]
fn a_counter_and_a_length_in_front_of_octets_are_none() {
    let row = "16 8 2 73 83 22";
    let lines = |line: &dyn Fn(usize) -> String| (1..=3).map(|at| line(at) + "\n").collect::<String>();
    let rows = [REQUEST; 3].join(" ");
    for (text, octets, left_over) in [
        (lines(&|at| format!("{at}\t{row}")), rows.clone(), 0),
        (lines(&|at| format!("{at} 6 {row}")), rows.clone(), 0),
        (lines(&|at| format!("{at} 6 {REQUEST}")), rows.clone(), 0),
        (lines(&|at| format!("{}, 06, {REQUEST}", at + 8)), rows.clone(), 0),
        ("Opening COM3 at 19200\n".to_owned() + &lines(&|at| format!("{} 6 {row}", at + 16)), rows.clone(), 0),
        // The first lines show the columns. The fourth line is missing, and the last one was cut off.
        (
            lines(&|at| format!("{at} 6 {REQUEST}")) + "5 6 " + REQUEST + "\n6 6 10 08\n",
            rows + " " + REQUEST + " 10 08",
            2,
        ),
    ] {
        let (notation, read, found) = read(text.as_bytes());
        assert_eq!((read, found), (hex(&octets), left_over), "{notation:?}:\n{text}");
    }
}

/// One line does not show that its first number is no octet.
#[test]
fn a_number_in_front_of_one_line_is_an_octet() {
    let (_, octets, left_over) = read(format!("17 {REQUEST}\n").as_bytes());
    assert_eq!((octets, left_over), (hex(&format!("17 {REQUEST}")), 0));
}

/// A long telegram goes on in a second line, which has no number. Where the numbers have no marks, the line is indented.
#[test]
fn a_line_that_continues_the_line_before_has_no_number() {
    let (first, second) = ("68 0E 0E 68 02 05 08 00 00 00 00", "80 00 02 38 51 B7 17 E8 16");
    let octets = [REQUEST, REQUEST, REQUEST, first, second].join(" ");
    for (before, after, indentation) in
        [("", ":", "    "), ("", ":", ""), ("#", "", ""), ("  ", "", "     "), ("", "\t", "\t\t")]
    {
        let front = |at: usize| format!("{before}{at}{after}");
        let mut text: String = (17..20).map(|at| front(at) + " " + REQUEST + "\n").collect();
        text += &format!("{} {first}\n{indentation}{second}\n", front(20));
        let (_, read, left_over) = read(text.as_bytes());
        assert_eq!((read, left_over), (hex(&octets), 0), "{text}");
    }
}

/// A pipe that stays open: behind its text the reader would wait.
struct OpenPipe<'a>(&'a [u8]);

impl Read for OpenPipe<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self.0.read(buffer)? {
            0 => Err(std::io::ErrorKind::WouldBlock.into()),
            count => Ok(count),
        }
    }
}

/// Numbers that may be columns hold back no telegram until the pipe ends.
#[test]
fn an_open_pipe_shows_its_telegrams_although_a_number_may_be_a_column() {
    for (text, octets) in [
        // Tokens have no check octet.
        ("1 DC 02 02\n2 DC 02 02\n3 DC 02 02\n".to_owned(), ["DC 02 02"; 3].join(" ")),
        // The first line with octets is one after which the notation is searched rarely.
        (format!("{}17 {REQUEST}\n18 E5\n19 {REQUEST}\n", "idle\n".repeat(7)), format!("{REQUEST} E5 {REQUEST}")),
        // No second line says whether the first one has a column.
        (format!("1 {REQUEST}\n{}", "idle\n".repeat(8)), REQUEST.to_owned()),
    ] {
        let mut source = Source::open_as(OpenPipe(text.as_bytes()), Baud::B19200, SourceKind::Text).unwrap();
        let mut chunks = Vec::new();
        while matches!(source.read(&mut chunks), Ok(true)) {}
        let read: Vec<u8> = chunks.into_iter().flat_map(|chunk| chunk.octets).collect();
        assert_eq!(read, hex(&octets), "{text}");
    }
}

/// Requests, a diagnosis with FF, SC, a token, inputs with a float, and octets that are letters, a line end and separators.
fn telegrams() -> Vec<Vec<u8>> {
    let answer = "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 08 E6 80 16";
    let inputs = "68 0E 0E 68 02 05 08 00 00 00 00 80 00 02 38 51 B7 17 E8 16";
    let letters = "68 0C 0C 68 05 02 5D 41 42 20 0D 0A 22 2C 5C 31 F9 16";
    let all =
        ["10 08 02 49 53 16", "68 05 05 68 88 82 6D 3C 3E F1 16", answer, "E5", "DC 02 02", inputs, "E5", letters];
    all.map(hex).to_vec()
}

fn with(octets: &[u8], separator: &str, text: impl Fn(u8) -> String) -> String {
    octets.iter().map(|octet| text(*octet)).collect::<Vec<_>>().join(separator)
}

fn spaced(octets: &[u8]) -> String {
    with(octets, " ", |octet| format!("{octet:02X}"))
}

const fn direction(number: usize) -> &'static str {
    if number.is_multiple_of(2) { "Tx" } else { "Rx" }
}

/// The octets as a program shows them beside their digits.
fn shown(octets: &[u8]) -> String {
    with(octets, "", |octet| if (0x20..0x7F).contains(&octet) { char::from(octet).to_string() } else { ".".to_owned() })
}

/// The line of a telegram with this number.
type Line = fn(usize, &[u8]) -> String;

/// Notations of programs, languages and logs: times, lengths, numbers of lines and addresses are beside the octets.
const NOTATIONS: [(&str, Line); 34] = [
    ("Docklight", |at, it| format!("29.11.2026 12:00:0{at}.123 [{}] - {} ", direction(at), spaced(it))),
    ("HHD", |at, it| format!("[29/11/2026 12:00:0{at}] Read data (COM3)\n    {:<60}  {}", spaced(it), shown(it))),
    ("Eltima", |at, it| {
        format!("[29/11/2026 12:00:0{at}] {at} IRP_MJ_WRITE COM3 Length: {:04} Data: {}", it.len(), spaced(it))
    }),
    ("Portmon", |at, it| {
        format!("{at}\t0.0000{at}123\tmaster.exe\tIRP_MJ_WRITE\tSerial0\tSUCCESS\tLength {}: {}", it.len(), spaced(it))
    }),
    ("Modbus Poll", |at, it| format!("{at:06}-{}:{}", direction(at), spaced(it))),
    ("Modbus Slave", |at, it| format!("{}:{at:06}-{}", direction(at), spaced(it))),
    ("a colon without a space", |at, it| format!("{}:{}", ["Master", "Slave"][at % 2], spaced(it))),
    ("a colon and joined digits", |at, it| format!("{}:{}", direction(at), spaced(it).replace(' ', ""))),
    ("RealTerm with seconds since 1970", |at, it| format!("{} {}", 1_764_417_600 + 7 * at, spaced(it))),
    ("Arduino with milliseconds", |at, it| format!("{} {}", 123_456 + 10 * at, spaced(it))),
    ("C arrays of Wireshark", |at, it| {
        let octets = with(it, ", ", |octet| format!("0x{octet:02x}"));
        format!(
            "/* Frame ({} bytes) */\nunsigned char pkt{at}[{}] = {{\n{octets} /* {} */\n}};",
            it.len(),
            it.len(),
            shown(it)
        )
    }),
    ("xxd -i", |_, it| {
        let octets = with(it, ", ", |octet| format!("0x{octet:02x}"));
        format!("unsigned char line[] = {{\n  {octets}\n}};\nunsigned int line_len = {};", it.len())
    }),
    ("ESP-IDF", |at, it| format!("I (987654) uart: 0x3ffb42{:02x}   {}  |{}|", 16 * at, spaced(it), shown(it))),
    ("kernel", |at, it| format!("[   12.34567{at}] ttyS: {}", spaced(it))),
    ("table with a length", |at, it| format!("12:00:0{at}.1,{},{},{}", direction(at), it.len(), spaced(it))),
    ("table with a number", |at, it| format!("{},{}", at + 9, spaced(it))),
    ("table with a number and joined digits", |at, it| format!("{},{}", at + 9, spaced(it).replace(' ', ""))),
    ("decimal comma", |at, it| format!("0,{:06} {}", 2500 + at, spaced(it))),
    ("thousandths and decimal octets", |at, it| format!("12:00:0{at},123 {}", list(it, " "))),
    ("decimal columns", |at, it| format!("0,{:04};{};{}", 25 + at, direction(at), list(it, ";"))),
    ("clock behind a direction", |at, it| format!("{} 12:00:0{at} {}", direction(at), spaced(it))),
    ("date behind a direction", |at, it| format!("{} 29.11.26 {}", direction(at), spaced(it))),
    ("syslog", |at, it| format!("Nov 29 12:00:0{at} host line: {}", list(it, " "))),
    ("Java", |at, it| format!("{} [{}]", direction(at), with(it, ", ", |octet| octet.cast_signed().to_string()))),
    ("Erlang", |at, it| format!("{} <<{}>>", direction(at), list(it, ","))),
    ("Go", |at, it| format!("{} [{}]", direction(at), list(it, " "))),
    ("IEC 61131-3", |_, it| with(it, ", ", |octet| format!("16#{octet:02X}"))),
    ("Visual Basic", |_, it| with(it, " ", |octet| format!("&H{octet:02X}"))),
    ("JSON with seconds since 1970", |at, it| {
        format!(
            r#"{{"ts": {}, "dir": "{}", "hex": "{}"}}"#,
            1_764_417_600 + at,
            direction(at),
            spaced(it).replace(' ', "")
        )
    }),
    ("JSON with a number", |at, it| {
        format!(r#"{{"id": {}, "dir": "{}", "data": [{}]}}"#, at + 9, direction(at), list(it, ", "))
    }),
    ("binary digits", |at, it| format!("{} {}", direction(at), with(it, " ", |octet| format!("{octet:08b}")))),
    ("a colon and decimal octets", |at, it| format!("{}:{}", direction(at), list(it, " "))),
    ("interceptty", |at, it| {
        with(it, "\n", |octet| format!("{}\t0x{octet:02x} ({})", [">", "<"][at % 2], shown(&[octet])))
    }),
    ("Saleae Logic 1", |at, it| {
        let octets = with(it, "\n", |octet| format!("0.{at},'{octet}' (0x{octet:02X}),,"));
        if at == 0 { format!("Time [s],Value,Parity Error,Framing Error\n{octets}") } else { octets }
    }),
];

/// What is beside the octets is neither an octet nor left over, and no octet is taken for it.
#[test]
fn every_octet_and_nothing_else_is_read_in_notations_that_no_list_names() {
    let telegrams = telegrams();
    for (name, line) in NOTATIONS {
        for end in ["\n", "\r\n"] {
            let lines = telegrams.iter().enumerate().map(|(at, telegram)| line(at, telegram));
            let text: String = lines.map(|line| line.replace('\n', end) + end).collect();
            let (notation, octets, left_over) = read(text.as_bytes());
            assert_eq!((octets, left_over), (telegrams.concat(), 0), "{name}, {notation:?}:\n{text}");
        }
    }
}

/// What cannot be read is left over, with its line.
#[test]
fn an_octet_that_no_notation_reads_is_left_over() {
    for (text, count) in [
        // A number in a line of words is no octet behind a direction.
        ("TX 16 8 2 73 83 22\nReconnect attempt 2\nRX 229\n", 2),
        // A value of a table that is none in its notation.
        ("Time [s],Value\n0.1,0x10\n0.2,0x08\n0.3,0x02\n0.4,0x49\n0.5,0x53\n0.6,0x16\n0.7,0xZZ\n", 1),
        ("RX 229\nTX 16 8 2 73 83 22\n", 1),
    ] {
        let (notation, octets, left_over) = read(text.as_bytes());
        assert_eq!(left_over, count, "{notation:?}, {octets:02X?}:\n{text}");
    }
}

/// The work for a text grows with its number of lines, and not faster: otherwise this test does not end.
#[test]
fn many_lines_are_read() {
    let lines = 200_000;
    let text = "12:00:00,250 RX 10 08 02 49 53 16\r\n".repeat(lines);
    let (notation, octets, left_over) = read(text.as_bytes());
    assert_eq!((notation, octets.len(), left_over), (Some(Notation::Hexadecimal), 6 * lines, 0));
}

/// Columns in front of octets, with the number of the line and the number of octets.
type Front = fn(u64, usize) -> Vec<String>;

const FRONTS: [Front; 14] = [
    |line, _| vec![line.to_string()],
    |_, count| vec![count.to_string()],
    |line, count| vec![line.to_string(), count.to_string()],
    |line, count| vec![count.to_string(), line.to_string()],
    |line, count| vec![format!("{line:03}"), format!("{count:03}")],
    |line, count| vec![format!("{line:04}"), "TX".to_owned(), count.to_string()],
    |line, count| vec![line.to_string(), format!("{}.250", line / 3), count.to_string()],
    |line, count| vec![format!("{}.5", 12 * line), "us".to_owned(), count.to_string()],
    |line, _| vec![format!("{},250", line / 3), line.to_string()],
    |line, _| vec!["RX".to_owned(), line.to_string()],
    |line, _| vec![line.to_string(), "RX".to_owned()],
    |line, _| vec![format!("{line}:")],
    |line, _| vec![format!("[{line}]")],
    |line, count| vec![format!("#{line}"), format!("12:00:{:02}", line % 60), count.to_string()],
];

/// Lines with columns in front of octets in hexadecimal or decimal.
fn columns(random: &mut Random, groups: &[Vec<u8>], front: Front) -> String {
    let separator = [" ", "\t", ";", "; "][random.below(4) as usize];
    let first = [0, 1, 17, 99, 250, 997][random.below(6) as usize];
    let octets: fn(&[u8]) -> String = match random.below(4) {
        0 => |it| list(it, " "),
        1 => |it| with(it, ", ", |octet| format!("0x{octet:02x}")),
        _ => spaced,
    };
    let line = |(at, group): (u64, &Vec<u8>)| {
        [front(first + at, group.len()), vec![octets(group)]].concat().join(separator) + "\n"
    };
    (0..).zip(groups).map(line).collect()
}

/// Three groups at least: a line alone does not show its columns.
fn several_groups(random: &mut Random) -> Vec<Vec<u8>> {
    loop {
        let groups = groups(random);
        if groups.len() >= 3 {
            return groups;
        }
    }
}

/// Whether each octet is read or left over, and no other is read; or whether the reader asks for the notation.
fn is_accounted_for(text: &str, expected: &[u8]) -> bool {
    let mut source = Source::open(text.as_bytes(), Baud::B19200).unwrap();
    let mut chunks = Vec::new();
    loop {
        match source.read(&mut chunks) {
            Ok(true) => {}
            Ok(false) => break,
            Err(_) => return true,
        }
    }
    let read: Vec<u8> = chunks.into_iter().flat_map(|chunk| chunk.octets).collect();
    let left_over: usize = source.left_over.iter().map(|text| text.octets).sum();
    let mut rest = expected.iter();
    let is_part = read.iter().all(|octet| rest.any(|next| next == octet));
    !source.is_notation_shown() || (is_part && read.len() + left_over >= expected.len())
}

/// The programs that print letters in place of octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LettersOf {
    /// `od -c` of the GNU coreutils.
    Od,
    /// `hexdump -c` of util-linux.
    Hexdump,
}

/// Octets as `od -c` and `hexdump -c` print them: letters, escapes and octal numbers, `*` in place of lines like the one before.
fn with_letters(octets: &[u8], program: LettersOf) -> String {
    let letter = |octet: u8| match octet {
        0 => "\\0".to_owned(),
        7 => "\\a".to_owned(),
        8 => "\\b".to_owned(),
        b'\t' => "\\t".to_owned(),
        b'\n' => "\\n".to_owned(),
        11 => "\\v".to_owned(),
        12 => "\\f".to_owned(),
        b'\r' => "\\r".to_owned(),
        0x20..0x7F => char::from(octet).to_string(),
        _ => format!("{octet:03o}"),
    };
    let address = |at: usize| match program {
        LettersOf::Od => format!("{at:07o}"),
        LettersOf::Hexdump => format!("{at:07x}"),
    };
    let (mut text, mut before, mut is_omitting) = (String::new(), None, false);
    for (row, number) in octets.chunks(16).zip(0_usize..) {
        if before == Some(row) {
            text += if is_omitting { "" } else { "*\n" };
            is_omitting = true;
            continue;
        }
        (before, is_omitting) = (Some(row), false);
        let letters: String = row.iter().map(|octet| format!(" {:>3}", letter(*octet))).collect();
        text += &address(16 * number);
        text += &match program {
            LettersOf::Od => letters + "\n",
            // It fills its last line with spaces.
            LettersOf::Hexdump => format!("{letters:64}\n"),
        };
    }
    text + &address(octets.len()) + "\n"
}

#[test]
fn a_dump_with_letters_is_read_whatever_its_addresses() {
    let octets = [0x68, 0x05, 0x05, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16, 0x20, 0x0D, 0x0A, 0x5C, 0x2A, 0xE5];
    let od = "0000000   h 005 005   h 210 202   m   <   > 361 026      \\r  \\n   \\   *\n";
    for (text, left_over) in [
        (format!("{od}0000020 345\n0000021\n"), 0),
        (format!("$ od -c line\n{od}0000020 345\n0000021\n$\n"), 0),
        // od -A x and od -A d.
        (format!("{}000010 345\n000011\n", &od[1..]), 0),
        (format!("{od}0000016 345\n0000017\n"), 0),
        // Without the last line.
        (format!("{od}0000020 345\n"), 0),
    ] {
        assert_eq!(read(text.as_bytes()), (Some(Notation::Letters), octets.to_vec(), left_over), "{text}");
    }
}

/// `hexdump -c` prints letters of UTF-8, and `**` for their further octets.
#[test]
fn a_letter_of_several_octets_has_a_cell_for_each() {
    let cells = " 020  \\b 002   I   S 026   \u{e9}  ** 026";
    let text = format!("0000000{cells:64}\n0000009\n");
    let octets = [0x10, 0x08, 0x02, 0x49, 0x53, 0x16, 0xC3, 0xA9, 0x16];
    assert_eq!(read(text.as_bytes()), (Some(Notation::Letters), octets.to_vec(), 0), "{text}");
}

/// An octal number has leading zeros, a decimal one of `od -t u1` has none.
#[test]
fn digits_are_the_letters_of_a_dump_with_octal_numbers() {
    let text = "0000000 020   6 034 243 365 026 303 322 336 264 330 345\n0000014\n";
    let octets = hex("10 36 1C A3 F5 16 C3 D2 DE B4 D8 E5");
    assert_eq!(read(text.as_bytes()), (Some(Notation::Letters), octets, 0), "{text}");
}

#[test]
fn the_lines_that_a_dump_with_letters_omits_are_read() {
    for program in [LettersOf::Od, LettersOf::Hexdump] {
        let octets = [vec![0x10, 0x08, 0x02, 0x49, 0x53, 0x16], vec![0; 150], vec![0xE5; 70], vec![0x16]].concat();
        let text = with_letters(&octets, program);
        assert!(text.contains("*\n"), "{text}");
        assert_eq!(read(text.as_bytes()), (Some(Notation::Letters), octets, 0), "{program:?}:\n{text}");
    }
}

/// Numbers in columns of four and octal octets have no letters: they keep their notation.
#[test]
fn numbers_in_columns_are_no_letters() {
    let decimal = "0000000  16   8   2  73  83  22 104   5   5 104 136 130 109  60  62 241\n0000016  22\n0000017\n";
    let octal = "0000000 020 010 002 111 123 026 150 005 005 150 210 202 155 074 076 361\n0000020 026\n0000021\n";
    let octets = hex("10 08 02 49 53 16 68 05 05 68 88 82 6D 3C 3E F1 16");
    for text in [decimal, octal] {
        let (notation, read, left_over) = read(text.as_bytes());
        assert_eq!((read, left_over), (octets.clone(), 0), "{notation:?}:\n{text}");
        assert_ne!(notation, Some(Notation::Letters), "{text}");
    }
}

/// Octets as cat -v prints them: a line end stands for itself, and `^` for itself and for a control character.
fn caret(octets: &[u8]) -> String {
    let letter = |octet: u8| match octet {
        0..0x20 => format!("^{}", char::from(octet + 64)),
        0x7F => "^?".to_owned(),
        _ => char::from(octet).to_string(),
    };
    let shown = |octet: &u8| match octet {
        b'\n' | b'\t' => char::from(*octet).to_string(),
        0x80.. => format!("M-{}", letter(octet & 0x7F)),
        _ => letter(*octet),
    };
    octets.iter().map(shown).collect::<String>() + "\n"
}

/// Some octets of these texts may be left over; each one that is read is right, or the reader asks for the notation.
#[test]
fn no_octet_of_random_streams_becomes_another_one() {
    let mut random = Random::new(48);
    for number in 0..cases(FEW_STREAMS) {
        let groups = several_groups(&mut random);
        let octets = groups.concat();
        let programs = NOTATIONS.into_iter().map(|(name, line)| {
            let lines = groups.iter().enumerate().map(|(at, group)| line(at, group) + "\n");
            (name.to_owned(), lines.collect::<String>())
        });
        let fronts = FRONTS.into_iter().enumerate();
        let columns: Vec<(String, String)> =
            fronts.map(|(at, front)| (format!("columns {at}"), columns(&mut random, &groups, front))).collect();
        let letters = ("cat -v".to_owned(), caret(&octets));
        for (name, text) in programs.chain(columns).chain([letters]) {
            assert!(is_accounted_for(&text, &octets), "stream {number}, {name}:\n{text}");
        }
    }
}
