//! `profivac decode` as a program: output, errors and exit codes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};

/// The log of a master: words, times, an answer in two pieces with a pause, damaged octets, an octet that cannot be parsed.
const LOG: &str = "\
Starting master 2 ...
12.000 PHY-serial: TX   68 05 05 68 85 82 6D 3C 3E EE 16
12.005 PHY-serial: RX (fragment)   68 0B 0B 68 82 85
12.016 PHY-serial: RX   08 3E 3C 02 05 00 FF 08 E6 7D 16
12.020 PHY-serial: TX   68 11 11 68 85 82 5D 3D 3E 88 02 05 0B 08 E6 00 80 00 00 05 1C 08 16
12.030 PHY-serial: RX   E5
12.040 PHY-serial: TX   68 0B 0B 68 85 82 7D 3E 3E 44 86 05 05 0A 08 E6 16
12.050 PHY-serial: RX   E5
12.060 PHY-serial: TX   68 05 05 68 85 82 5D 3C 3E DE 16
12.070 PHY-serial: RX   68 0B 0B 68 82 85 ?? 3E 3C 06 05 00 FF 08 E6 81 16
12.080 PHY-serial: TX   68 05 05 68 85 82 5D 3C 3E DE 16
12.090 PHY-serial: RX   68 0B 0B 68 82 85 08 3E 3C 06 05 00 FF 08 E6 81 16
";

const EXPLANATION: &str = "   12.005000 s    5  is present: bcg450 (ident 08E6), has no owner, waits for parameters, not ready
   12.030000 s    5  master 2 sets its parameters: lock, watchdog 100 ms, min T_SDR 11, ident 08E6, groups 00, user 80 00 00 05 1C (unit mbar)
   12.050000 s    5  master 2 asks for the configuration 44 86 05 05 0A 08: 0 octets out, 7 in
   12.070000 s       damaged, 17 octets: character error in octet 7: 68 0B 0B 68 82 85 00 3E 3C 06 05 00 FF 08 E6 81 16
   12.080000 s    5  master 2 repeats Slave_Diag: the answer is damaged
   12.090000 s    5  Chk_Cfg refused: the bcg450 offers 44 86 05 05 05 08 and 7 others, the master asked for 44 86 05 05 0A 08; octet 5 is 0A and should be 05

9 telegrams, 1 damaged piece (10.0 %)
126 octets: 109 in telegrams, 17 damaged, 0 left over
ADDR  DEVICE        SENT  REQUESTS  REPEATED  UNANSWERED  EXCHANGES
   2  master           5
   5  bcg450           4         5         1           1          0
";

/// A TPG with one module 93: its diagnosis, Chk_Cfg, and an exchange with the mantissa 830 and the exponent -5.
const MANTISSA: &str = "\
68 05 05 68 89 82 6D 3C 3E F2 16\n\
68 0B 0B 68 82 89 08 3E 3C 00 0C 00 02 05 D9 79 16\n\
68 09 09 68 89 82 5D 3E 3E 97 A7 93 A0 55 16\n\
E5\n\
68 0C 0C 68 09 02 7D 00 00 00 00 00 00 00 00 00 88 16\n\
68 0F 0F 68 02 09 08 00 00 00 00 00 00 00 00 03 3E FB 00 4F 16\n";

/// The last message of a program.
fn last_line(text: &str) -> &str {
    text.split_inclusive('\n').next_back().unwrap_or_default()
}

fn decode(folder: &Folder, name: &str, content: &[u8], options: &[&str]) -> (Option<i32>, String, String) {
    let path = folder.name(name);
    std::fs::write(&path, content).unwrap();
    let output = run(&[&["decode", &path], options].concat());
    let text = |octets: Vec<u8>| String::from_utf8(octets).unwrap().replace(&path, name);
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_log_is_explained() {
    let folder = Folder::new();
    let (code, text, notice) = decode(&folder, "log", LOG.as_bytes(), &[]);
    assert_eq!(text, EXPLANATION);
    let expected = "\
profivac: log: read as text with octets in hexadecimal (--input octets: as the octets of a line)
profivac: log: 1 line without octets, the first is line 1: 'Starting master 2 ...'
profivac: log: 11 lines with words beside octets, the first is line 2: 'PHY-serial: TX'
";
    assert_eq!((code, notice.as_str()), (Some(0), expected));
}

#[test]
fn raw_shows_every_telegram_with_its_meaning() {
    let folder = Folder::new();
    let log = "TX 68 05 05 68 05 02 7D AA 55 83 16\nRX E5 00\nTX DC 02 02";
    let (code, text, _) = decode(&folder, "log", log.as_bytes(), &["--raw"]);
    let expected = "            #1         2 -> 5    Data_Exchange    FCB 1  AA 55 | 68 05 05 68 05 02 7D AA 55 83 16
            #2                   SC (doubtful) | E5
            #2    5  exchanges data with master 2, 2 octets out, 0 in; its start-up was not received
            #3       damaged | 00
            #3       damaged, 1 octet: no telegram begins with 00: 00
            #4         2 -> 2    Token | DC 02 02
            #4       master 2 is alone in the token ring
";
    assert_eq!((code, text.split_once("\n\n").unwrap().0), (Some(0), expected.trim_end()));
}

#[test]
fn json_has_a_line_for_every_sentence_and_a_summary() {
    let folder = Folder::new();
    let (code, text, _) = decode(&folder, "log", LOG.as_bytes(), &["--json"]);
    let rows: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((code, rows.len()), (Some(0), 7));
    let refused = &rows[5];
    assert_eq!((refused["kind"].as_str(), refused["station"].as_u64()), (Some("refused"), Some(5)));
    assert_eq!((refused["time_s"].as_f64(), refused["number"].as_u64()), (Some(12.09), Some(10)));
    let summary = &rows[6];
    assert_eq!((summary["kind"].as_str(), summary["telegrams"].as_u64()), (Some("summary"), Some(9)));
    assert_eq!(summary["slaves"][0]["device"], "bcg450");
}

/// A log becomes a capture of either link type, and the capture has the same explanation.
#[test]
fn a_capture_file_has_the_same_explanation() {
    let folder = Folder::new();
    for link_type in ["user0", "profibus-dl", "147", "257"] {
        let capture = folder.name("capture.pcapng");
        let (code, ..) = decode(&folder, "log", LOG.as_bytes(), &["--out", &capture, "--link-type", link_type]);
        assert_eq!(code, Some(0));
        let file = std::fs::read(&capture).unwrap();
        let number = u16::from_le_bytes([file[36], file[37]]);
        assert_eq!(number, if matches!(link_type, "user0" | "147") { 147 } else { 257 });
        assert_eq!(decode(&folder, "again", &file, &[]), (Some(0), EXPLANATION.to_owned(), String::new()));
    }
}

#[test]
fn a_truncated_capture_is_explained_up_to_its_end_with_exit_code_2() {
    let folder = Folder::new();
    let capture = folder.name("capture.pcapng");
    decode(&folder, "log", LOG.as_bytes(), &["--out", &capture]);
    let file = std::fs::read(&capture).unwrap();
    let (code, text, complaint) = decode(&folder, "cut", &file[..file.len() - 3], &[]);
    assert!(text.contains("8 telegrams, 1 damaged piece (11.1 %)"), "{text}");
    let offset = file.len() - 52;
    let expected = format!(
        "profivac: cut: the file ends within the block at octet {offset}: it was cut off, or is still being written; the \
         output above explains everything before this position\n"
    );
    assert_eq!((code, complaint), (Some(2), expected));
}

#[test]
fn a_file_that_cannot_be_decoded_is_named_with_exit_code_2() {
    let folder = Folder::new();
    for (content, message) in [
        (&b""[..], "profivac: file: expected telegrams, found an empty file\n"),
        (
            b"\nno octets here\n",
            "profivac: file: line 2: expected octets in hexadecimal, as in '68 05 05 68 88 82 6D 3C 3E F1 16', found 'no octets here'; \
             --input hex, decimal, strings, strace or octets says how to read it\n",
        ),
        (
            b"# 500 kbit/s\n10 | E5\nsoon | E5\n",
            "profivac: file: line 3: expected a bit time, found 'soon'; the output above explains everything before this position\n",
        ),
        (b"# 500 kbit/s\nsoon | E5\n", "profivac: file: line 2: expected a bit time, found 'soon'\n"),
        (
            b"68 05 05 68 88 82 6D 3C 3E F2 16\n",
            "profivac: file: expected telegrams, none of 11 octets belongs to a valid one: record at the rate of the bus with 8 data bits, \
             even parity, 1 stop bit, not inverted; exchange the wires A and B, connect the grounds, check the termination at both \
             ends; docs/adapters.md has the pins\n",
        ),
        (
            &[0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0],
            "profivac: file: the file ends within the block at octet 0: it was cut off, or is still being written\n",
        ),
        (
            &[0x0A, 0x0D, 0x0D, 0x0A, 28, 0, 0, 0, 0x4D, 0x3C, 0x2B, 0x1A, 1, 0, 0, 0],
            "profivac: file: expected a pcapng file, found no section header\n",
        ),
    ] {
        let (code, _, complaint) = decode(&folder, "file", content, &[]);
        assert_eq!((code, last_line(&complaint)), (Some(2), message));
    }
    let output = run(&["decode", &folder.name("missing")]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8(output.stderr).unwrap().ends_with("cannot be read: No such file or directory (os error 2)\n")
    );
}

#[test]
fn wrong_options_have_exit_code_2() {
    let folder = Folder::new();
    for options in [&["--link-type", "user0"][..], &["--out", "x", "--link-type", "ethernet"], &["--baud", "19201"]] {
        let (code, text, complaint) = decode(&folder, "log", LOG.as_bytes(), options);
        assert_eq!((code, text.as_str()), (Some(2), ""), "{options:?}");
        assert!(complaint.starts_with("error: "), "{complaint}");
    }
    let nowhere = folder.name("missing/x.pcapng");
    let (code, _, complaint) = decode(&folder, "log", LOG.as_bytes(), &["--out", &nowhere]);
    assert_eq!(code, Some(2));
    assert!(complaint.contains("cannot be written"), "{complaint}");
}

/// A log that another program is still writing.
#[test]
fn input_from_a_pipe_is_explained_at_once() {
    let mut program = Program::start(&["decode"]);
    // Each line is explained when the next one arrives, because a telegram may continue in the next line.
    for request in ["TX 68 05 05 68 85 82 6D 3C 3E EE 16", "RX 68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16"] {
        program.say(request);
    }
    assert!(program.line().ends_with("is present: bcg450 (ident 08E6), has no owner, waits for parameters, not ready"));
    program.end_of_file();
    assert_eq!(program.exit_code(), 0);
}

/// Every octet of lines that were not made for a reader.
#[test]
fn no_octet_of_a_text_is_lost() {
    let folder = Folder::new();
    for (text, octets, telegrams) in [
        ("68 08 08 68 88 81 5d 3e 3e 00 10 10 02 16 e5\n", 15, 2),
        ("dc 02 02 10 05 02 49 50 16\n", 9, 2),
        ("10 0b 04 5d\n6c 16 68 07 07 68 04 0b 08 00 03 00 00 1a 16 10\n0f 04 5d 70 16\n", 25, 3),
    ] {
        let (code, output, _) = decode(&folder, "file", text.as_bytes(), &["--json"]);
        let row: serde_json::Value = serde_json::from_str(output.lines().next_back().unwrap()).unwrap();
        assert_eq!((code, row["telegrams"].as_u64()), (Some(0), Some(telegrams)), "{text}");
        let expected = serde_json::json!({
            "input": octets, "telegrams": octets, "doubtful": 0, "damaged": 0, "left_over": 0
        });
        assert_eq!((row["input"].as_str(), &row["octets"]), (Some("text"), &expected), "{text}");
    }
}

/// A line of 64 KiB and more is read in parts: a leading word or an odd digit costs one octet at most.
#[test]
fn a_long_line_of_digits_loses_no_telegram() {
    let folder = Folder::new();
    let digits = "1008015D6616".repeat(6000);
    for (text, left_over) in
        [(digits.clone() + "1", 1), ("1".to_owned() + &digits, 1), ("RX: ".to_owned() + &digits, 0)]
    {
        let (code, output, _) = decode(&folder, "file", text.as_bytes(), &["--json"]);
        let row: serde_json::Value = serde_json::from_str(output.lines().next_back().unwrap()).unwrap();
        assert_eq!((code, row["telegrams"].as_u64()), (Some(0), Some(6000)));
        assert_eq!((row["damaged"].as_u64(), row["octets"]["left_over"].as_u64()), (Some(0), Some(left_over)));
    }
}

#[test]
fn what_is_left_over_has_the_number_of_its_line() {
    let folder = Folder::new();
    let log = "Slave 88 sends 10 02 08 00 0A 16\nDC 02 02 (3 of 17)\n";
    let (code, output, notices) = decode(&folder, "log", log.as_bytes(), &["--raw"]);
    assert_eq!(code, Some(0));
    assert!(output.contains("        line 1       left over: 88\n        line 2       left over: 17\n"), "{output}");
    assert!(output.contains("\n11 octets: 9 in telegrams, 0 damaged, 2 left over\n"), "{output}");
    let expected = "profivac: log: 2 octets left over in 2 lines, the first is line 1: '88'; --raw shows all\n";
    assert_eq!(last_line(&notices), expected);
    let (_, output, _) = decode(&folder, "log", log.as_bytes(), &["--raw", "--json"]);
    assert!(output.contains(r#"{"kind":"left-over","line":1,"text":"88","octets":1}"#), "{output}");
}

/// Octets that are letters as well, and a byte order mark that is none: the same result from a file and from a pipe in portions.
#[test]
fn the_octets_of_a_line_are_not_taken_for_text() {
    let folder = Folder::new();
    let octets = [0x10, 8, 2, 0x49, 0x53, 0x16, 0x10, 9, 2, 0x49, 0x54, 0x16];
    let marked = [&[0xEF, 0xBB, 0xBF][..], &octets].concat();
    let note = "profivac: file: read as the octets of a line (--input text: as text)\n";
    for (file, damaged) in [(&octets[..], 0), (&marked, 3)] {
        let (code, output, notice) = decode(&folder, "file", file, &["--json"]);
        let row: serde_json::Value = serde_json::from_str(output.lines().next_back().unwrap()).unwrap();
        assert_eq!((code, notice.as_str(), row["telegrams"].as_u64()), (Some(0), note, Some(2)));
        assert_eq!(row["octets"]["damaged"].as_u64(), Some(damaged));
    }
    let letters = b"hex 10 08 02 49 53 16\n";
    let (code, ..) = decode(&folder, "file", letters, &["--input", "octets"]);
    assert_eq!(code, Some(2), "no telegram among the letters");
    assert_eq!(decode(&folder, "file", letters, &["--input", "text"]).0, Some(0));
}

#[test]
fn a_station_that_only_answers_is_called_slave() {
    let folder = Folder::new();
    let (_, output, _) = decode(&folder, "log", b"68 05 05 68 04 27 08 00 00 33 16\n", &[]);
    assert!(output.ends_with("\n  39  slave            1\n"), "{output}");
}

/// The dumps of the programs that are on every computer.
#[test]
fn every_octet_of_a_dump_of_od_is_decoded() {
    let folder = Folder::new();
    let mut octets = [&[0xE5, 0xDC, 2, 2][..], &[0x10, 8, 2, 0x49, 0x53, 0x16].repeat(40), &[0; 100]].concat();
    octets.push(0x68);
    let path = folder.name("octets");
    std::fs::write(&path, &octets).unwrap();
    for options in
        ["", "-x", "-b", "-t x1", "-A x -t x1z", "-A d -t x1", "-A n -v -t x1", "-v -t x4", "-t x8", "-w5 -t x1"]
    {
        let dump = std::process::Command::new("od").args(options.split_whitespace()).arg(&path).output().unwrap();
        assert!(dump.status.success(), "od {options}");
        let (code, output, _) = decode(&folder, "dump", &dump.stdout, &["--json"]);
        let row: serde_json::Value = serde_json::from_str(output.lines().next_back().unwrap()).unwrap();
        let counts = serde_json::json!({
            "input": octets.len(), "telegrams": 244, "doubtful": 0, "damaged": 101, "left_over": 0
        });
        assert_eq!((code, &row["octets"]), (Some(0), &counts), "od {options}");
    }
    let dump = std::process::Command::new("od").args(["-A", "n", "-t", "x1", &path]).output().unwrap();
    let (_, _, notices) = decode(&folder, "dump", &dump.stdout, &[]);
    assert!(last_line(&notices).contains("'*'; --raw shows all; * stands for lines that the dump omits"), "{notices}");
}

/// The manual does not define the format of a mantissa, and every text with one says so.
#[test]
fn the_mantissa_of_a_tpg_is_a_number_whose_format_is_assumed() {
    let folder = Folder::new();
    let (code, text, notice) = decode(&folder, "tpg", MANTISSA.as_bytes(), &[]);
    assert_eq!(code, Some(0), "{notice}");
    let expected = "channel 1 8.30e-3 (unit unknown) (the format of the mantissa is assumed)";
    assert!(text.contains(expected), "{text}");
}

/// The rows of the table in docs/decode.md: each file is what the tool has printed, and all have the same five telegrams.
#[test]
fn what_each_tool_prints_has_every_telegram() {
    let folder = Folder::new();
    for (name, notation, times) in [
        ("sigrok-cli.txt", "one octet a line in hexadecimal", false),
        ("sigrok-cli-samples.txt", "one octet a line in hexadecimal", true),
        ("sigrok-cli-ascii.txt", "one octet a line in characters", false),
        ("pulseview.txt", "one octet a line in hexadecimal", true),
        ("logic2-hex.csv", "a table with one octet a line in hexadecimal", true),
        ("logic2-decimal.csv", "a table with one octet a line in decimal", true),
        ("logic2-binary.csv", "a table with one octet a line in binary", true),
        ("logic2-ascii.csv", "a table with one octet a line in characters", true),
        ("dsview.csv", "a table with one octet a line in characters", true),
        ("socat-x.txt", "octets in hexadecimal", true),
        ("socat-v-x.txt", "octets in hexadecimal", true),
        ("jpnevulator.txt", "octets in hexadecimal", true),
        ("jpnevulator-ascii.txt", "octets in hexadecimal", false),
        ("strace.txt", "octets in the calls that strace prints", true),
        ("strace-x.txt", "octets in the calls that strace prints", false),
        ("python-bytes.txt", "octets in strings with escapes", true),
        ("python-list.txt", "octets in decimal", false),
        ("json.txt", "octets in decimal", false),
        ("tshark-x.txt", "octets in hexadecimal", false),
        ("tshark-fields.txt", "octets in hexadecimal", true),
        ("od-c.txt", "letters and octal numbers, as od -c and hexdump -c print them", false),
        ("hexdump-c.txt", "letters and octal numbers, as od -c and hexdump -c print them", false),
    ] {
        let file = std::fs::read(std::path::Path::new("tests/data/recordings").join(name)).unwrap();
        let (code, output, notices) = decode(&folder, name, &file, &["--json", "--raw"]);
        let rows: Vec<serde_json::Value> = output.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let octets = serde_json::json!({ "input": 27, "telegrams": 27, "doubtful": 0, "damaged": 0, "left_over": 0 });
        let summary = rows.last().unwrap();
        assert_eq!(
            (code, &summary["octets"], &summary["telegrams"]),
            (Some(0), &octets, &serde_json::json!(5)),
            "{name}: {output}"
        );
        assert!(notices.contains(&format!("read as text with {notation} (")), "{name}: {notices}");
        assert_eq!(rows[0]["time_s"].is_number(), times, "{name}: {output}");
    }
}

#[test]
fn a_recording_without_a_telegram_has_exit_code_2_and_one_with_few_a_warning() {
    let folder = Folder::new();
    let damaged = "68 05 05 68 88 82 6D 3C 3E F2 16\n";
    let advice = "8 data bits, even parity, 1 stop bit, not inverted; exchange the wires A and B";
    let (code, _, notices) = decode(&folder, "file", damaged.repeat(3).as_bytes(), &[]);
    assert_eq!((code, last_line(&notices).contains(advice)), (Some(2), true), "{notices}");
    let (code, _, notices) = decode(&folder, "file", (damaged.repeat(3) + "10 08 02 49 53 16\n").as_bytes(), &[]);
    let sentence = format!("33 octets of 39 belong to no telegram: record at the rate of the bus with {advice}");
    assert_eq!((code, last_line(&notices).contains(&sentence)), (Some(0), true), "{notices}");
    let (code, _, notices) =
        decode(&folder, "file", (damaged.to_owned() + &"10 08 02 49 53 16\n".repeat(3)).as_bytes(), &[]);
    assert_eq!((code, notices.contains(advice)), (Some(0), false), "{notices}");
}

/// The same frames on the same wires.
#[test]
fn a_recording_of_another_protocol_is_named() {
    let folder = Folder::new();
    for (text, name, code) in [
        // SND_NKE, its acknowledgement, REQ_UD2, RSP_UD of a meter (EN 13757-2).
        ("10 40 05 45 16\nE5\n10 5B 05 60 16\n68 06 06 68 08 05 72 01 02 03 85 16\n", "M-Bus or IEC 60870-5-101: ", 0),
        ("68 03 03 68 53 05 51 A9 16\nE5\n10 7B 05 80 16\n68 04 04 68 08 05 72 99 18 16\n", "M-Bus: ", 0),
        // Request of class 2 to the link address 0A00, and single-point information.
        ("10 5B 0A 65 16\n68 08 08 68 08 0A 01 01 03 0A 01 01 23 16\n", "IEC 60870-5-101: ", 0),
        ("10 40 05 45 16\n10 5B 05 60 16\n", "M-Bus or IEC 60870-5-101: ", 2),
    ] {
        let (found, _, notices) = decode(&folder, "file", text.as_bytes(), &[]);
        let sentence = format!("could also be {name}");
        assert!(found == Some(code) && notices.contains(&sentence), "{found:?} {notices}");
    }
    for text in
        [LOG, MANTISSA, "10 08 02 49 53 16\n10 09 02 49 54 16\n", "DC 02 02\n", "68 05 05 68 05 02 7D AA 55 83 16\n"]
    {
        let (_, _, notices) = decode(&folder, "file", text.as_bytes(), &[]);
        assert!(!notices.contains("could also be"), "{text}: {notices}");
    }
}

/// The notice comes first, because the sentences explain the frames as PROFIBUS.
#[test]
fn another_protocol_is_named_before_the_first_sentence() {
    let folder = Folder::new();
    let [recording, output] = ["recording", "output"].map(|name| folder.name(name));
    // Ten readings of a meter.
    let dialogue = "10 5B 05 60 16\n68 06 06 68 08 05 72 01 02 03 85 16\n";
    std::fs::write(&recording, format!("10 40 05 45 16\nE5\n{}", dialogue.repeat(10))).unwrap();
    let file = std::fs::File::create(&output).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_profivac"));
    command.args(["decode", "--raw", &recording]).stdout(file.try_clone().unwrap()).stderr(file);
    assert!(command.status().unwrap().success());
    let text = std::fs::read_to_string(&output).unwrap();
    let (named, first) = (text.find("could also be M-Bus"), text.find(" | "));
    assert!(named.is_some() && named < first, "{text}");
}

/// The pipe stays open: eight frames decide, and a dialogue of PROFIBUS behind seven of them does.
#[test]
fn another_protocol_is_named_on_an_open_pipe_behind_eight_frames() {
    const READING: &str = "68 04 04 68 08 05 72 99 18 16";
    let mut program = Program::start(&["decode", "--raw"]);
    (0..8).for_each(|_| program.say(READING));
    program.wait_for_complaint("could also be M-Bus: ");
    assert!(program.line().ends_with(READING));
    program.end_of_file();
    assert_eq!(program.exit_code(), 0);
    let mut program = Program::start(&["decode", "--raw"]);
    (0..7).for_each(|_| program.say(READING));
    program.say("68 05 05 68 85 82 6D 3C 3E EE 16");
    program.say("68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16");
    assert!(program.line().ends_with(READING));
    program.end_of_file();
    assert_eq!(program.exit_code(), 0);
    let notices: String = std::iter::repeat_with(|| program.complaint()).take(3).collect();
    assert!(notices.contains("read as text") && !notices.contains("could also be"), "{notices}");
}

/// A capture file of two interfaces, one of which is Ethernet: its packet is named and not read.
#[test]
fn packets_of_another_link_type_are_skipped_and_counted() {
    let folder = Folder::new();
    let number = u32::to_le_bytes;
    let section = [number(0x0A0D_0D0A), number(28), number(0x1A2B_3C4D), number(1), [0xFF; 4], [0xFF; 4], number(28)];
    let interface = |link_type: u32| [number(1), number(20), number(link_type), [0; 4], number(20)].concat();
    let packet = |interface: u32, octets: [u8; 8], length: u32| {
        let head =
            [number(6), number(40), number(interface), [0; 4], number(1_000_010), number(length), number(length)];
        [&head.concat()[..], &octets, &number(40)].concat()
    };
    let telegram = packet(1, [0x10, 8, 2, 0x49, 0x53, 0x16, 0, 0], 6);
    let file = [section.concat(), interface(1), interface(147), packet(0, [0xFF; 8], 8), telegram].concat();
    let (code, output, notices) = decode(&folder, "file", &file, &["--json", "--raw"]);
    assert_eq!((code, first_time(&output)), (Some(0), Some(1.000_01)), "{output}");
    let sentence = "1 packet skipped: expected link type 257 or 147, the first one has 1";
    assert!(notices.contains(sentence) && output.contains(r#""telegrams":1"#), "{notices}{output}");
    let foreign = [section.concat(), interface(1), packet(0, [0xFF; 8], 8)].concat();
    let (code, _, complaint) = decode(&folder, "file", &foreign, &[]);
    assert!(code == Some(2) && complaint.contains("expected link type 257 or 147, found 1"), "{complaint}");
}

/// A capture of a running plant: the device is given, its start-up was not recorded.
#[test]
fn statistics_show_the_stations_and_the_pressures_of_a_recording() {
    let folder = Folder::new();
    let dialogue = "68 0B 0B 68 05 02 5D 00 00 00 00 00 00 00 00 64 16\n68 12 12 68 02 05 08 00 00 00 00 00 00 00 00 80 00 02 38 51 B7 17 E8 16\n";
    let (code, output, _) =
        decode(&folder, "file", dialogue.repeat(3).as_bytes(), &["--statistics", "--gauge", "bcg450@5"]);
    assert_eq!(code, Some(0), "{output}");
    assert!(output.contains("address  state") && output.contains("bcg450 instance 2: 5e-5 mbar (assumed)"), "{output}");
    let (_, output, _) = decode(&folder, "file", LOG.as_bytes(), &["--statistics", "--json"]);
    let row: serde_json::Value = serde_json::from_str(&output).unwrap();
    assert_eq!((row["telegrams"].as_u64(), row["damaged"].as_u64()), (Some(9), Some(1)));
    let (code, _, complaint) = decode(&folder, "file", LOG.as_bytes(), &["--gauge", "bcg450@5"]);
    assert_eq!((code, complaint.contains("--statistics")), (Some(2), true), "{complaint}");
}

/// The time of the first telegram in JSON.
fn first_time(output: &str) -> Option<f64> {
    serde_json::from_str::<serde_json::Value>(output.lines().next()?).unwrap()["time_s"].as_f64()
}

/// Ten microseconds are less than a bit time at the rate that profivac would assume.
#[test]
fn the_times_of_a_file_without_a_rate_are_not_rounded_to_bit_times() {
    let folder = Folder::new();
    let number = u32::to_le_bytes;
    let telegram = [0x10, 8, 2, 0x49, 0x53, 0x16];
    let header = [number(0xA1B2_C3D4), number(0x0004_0002), [0; 4], [0; 4], number(65_535), number(147)].concat();
    let pcap = [&header[..], &[number(1), number(10), number(6), number(6)].concat(), &telegram].concat();
    // A section, an interface without options, a packet at 1000010 us.
    let section = [number(0x0A0D_0D0A), number(28), number(0x1A2B_3C4D), number(1), [0xFF; 4], [0xFF; 4], number(28)];
    let interface = [number(1), number(20), number(147), [0; 4], number(20)];
    let times = [number(6), number(40), [0; 4], [0; 4], number(1_000_010), number(6), number(6)];
    let packet = [&times.concat()[..], &telegram, &[0, 0], &number(40)].concat();
    let pcapng = [section.concat(), interface.concat(), packet].concat();
    let text = b"1.000010 TX 10 08 02 49 53 16\n".to_vec();
    for file in [pcap, pcapng, text] {
        let again = folder.name("again.pcapng");
        let (code, output, _) = decode(&folder, "file", &file, &["--json", "--raw", "--out", &again]);
        assert_eq!((code, first_time(&output)), (Some(0), Some(1.000_01)), "{output}");
        let copy = std::fs::read(&again).unwrap();
        let (code, output, _) = decode(&folder, "copy", &copy, &["--json", "--raw"]);
        assert_eq!((code, first_time(&output)), (Some(0), Some(1.000_01)), "{output}");
    }
}

/// A recording of SC and tokens alone: nothing shows its notation, and the user states it.
#[test]
fn a_text_whose_notation_no_telegram_shows_asks_for_the_option_that_states_it() {
    let folder = Folder::new();
    for (text, input, octets) in [
        ("TX [220, 2, 2]\nRX [229]\n", "decimal", 4),
        ("TX [9, 2, 2]\nRX [22]\n", "decimal", 4),
        ("write(3, \"\\334\\2\\2\", 3) = 3\nread(3, \"\\345\", 255) = 1\n", "strace", 4),
        ("TX b'\\xdc\\x02\\x02'\nRX b'\\xe5'\n", "strings", 4),
        ("TX E5 E5 E5\n", "hex", 3),
    ] {
        let (_, _, notices) = decode(&folder, "file", text.as_bytes(), &[]);
        assert!(notices.contains("--input hex, decimal, strings, strace or octets says how to read it"), "{notices}");
        let (code, output, notices) = decode(&folder, "file", text.as_bytes(), &["--json", "--input", input]);
        let row: serde_json::Value = serde_json::from_str(output.lines().next_back().unwrap()).unwrap();
        assert_eq!(row["octets"]["input"].as_u64(), Some(octets), "{text}: {output}{notices}");
        assert_eq!(row["octets"]["left_over"].as_u64(), Some(0), "{text}: {output}");
        assert!(!notices.contains("says how to read it") && matches!(code, Some(0 | 2)), "{notices}");
    }
}

/// A classic capture file, and the same one packed.
#[test]
fn a_classic_capture_and_a_packed_one_are_explained() {
    let folder = Folder::new();
    let telegrams = [&[0x10, 8, 2, 0x49, 0x53, 0x16][..], &[0x10, 2, 8, 0, 0x0A, 0x16]];
    let number = |number: u32| number.to_le_bytes();
    let mut file = [number(0xA1B2_C3D4), number(0x0004_0002), [0; 4], [0; 4], number(65_535), number(257)].concat();
    for telegram in telegrams {
        let length = number(telegram.len() as u32);
        file.extend([number(1_700_000_000), number(250_000), length, length].concat());
        file.extend(telegram);
    }
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packer, &file).unwrap();
    let packed = packer.finish().unwrap();
    for file in [&file, &packed] {
        let (code, output, _) = decode(&folder, "file", file, &["--json", "--raw"]);
        let first: serde_json::Value = serde_json::from_str(output.lines().next().unwrap()).unwrap();
        assert_eq!((code, first["time_s"].as_f64()), (Some(0), Some(1_700_000_000.25)), "{output}");
        assert!(output.contains(r#""telegrams":2"#), "{output}");
    }
    let (code, ..) = decode(&folder, "file", &packed[..packed.len() - 9], &[]);
    assert_eq!(code, Some(2), "a packed file that is cut off");
}
