//! Tests of the reader.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use super::dump_lines::MAX_REPEATED;
use super::*;
use profivac_sim::Random;
use profivac_sim::describe::Hex;

const DIAG: &str = "68 05 05 68 88 82 6D 3C 3E F1 16";

fn read(text: &str) -> Vec<String> {
    rows(text).0.iter().map(|row| Hex(&row.octets).to_string()).collect()
}

fn rows(text: &str) -> (Vec<Row>, Vec<LeftOver>, Ignored) {
    let (mut reader, mut found) = (Reader::default(), Found::default());
    text.lines().for_each(|line| reader.read(line, true, &mut found));
    reader.end(&mut found);
    (found.rows.into(), found.left_over, reader.ignored)
}

#[test]
fn the_reader_understands_a_telegram_in_every_notation() {
    for line in [
        "68 05 05 68 88 82 6D 3C 3E F1 16",
        "68 5 5 68 88 82 6d 3c 3e f1 16",
        "0x68, 0x05, 0x05, 0x68, 0x88, 0x82, 0x6d, 0x3c, 0x3e, 0xf1, 0x16,",
        "{0x68,0x5,0x5,0x68,0x88,0x82,0x6d,0x3c,0x3e,0xf1,0x16}",
        "68h 05h 05h 68h 88h 82h 6Dh 3Ch 3Eh F1h 16h",
        "$68 $05 $05 $68 $88 $82 $6D $3C $3E $F1 $16",
        r#"b"\x68\x05\x05\x68\x88\x82\x6d\x3c\x3e\xf1\x16""#,
        "68:05:05:68:88:82:6D:3C:3E:F1:16",
        "68-05-05-68-88-82-6D-3C-3E-F1-16",
        "680505688882 6D3C3EF116",
        "PHY-serial: TX   68 05 05 68 88 82 6D 3C 3E F1 16",
        "RX (fragment)   68 05 05 68 88 82 6D 3C 3E F1 16",
        "-> 68 05 05 68 88 82 6D 3C 3E F1 16 (11 octets)",
        "<< 68 05 05 68 88 82 6D 3C 3E F1 16 ",
        "17;12:00:00.123456;2;8;SRD_HIGH;68 05 05 68 88 82 6D 3C 3E F1 16;Slave_Diag",
        "2 -> 8  Slave_Diag req | 68 05 05 68 88 82 6D 3C 3E F1 16",
        "[  3.25] 68 05 05 68 88 82 6D 3C 3E F1 16",
        "00000000: 6805 0568 8882 6d3c 3ef1 16              h..h..m<>..",
        "00000000  68 05 05 68 88 82 6d 3c  3e f1 16                 |h..h..m<>..|",
        "0000000 0568 6805 8288 3c6d f13e 0016\n000000b",
    ] {
        let octets = read(line);
        assert_eq!(octets.first().map(String::as_str), Some(DIAG), "{line}");
    }
}

#[test]
fn the_reader_removes_the_offsets_of_a_dump() {
    let dump = "\
00000000  68 05 05 68 88 82 6d 3c  3e f1 16 e5 10 08 02 49  |h..h..m<>......I|
00000010  53 16                                             |S.|
00000012";
    assert_eq!(read(dump), ["68 05 05 68 88 82 6D 3C 3E F1 16 E5 10 08 02 49", "53 16"]);
    // Eight digits that are not the expected offset are octets.
    assert_eq!(read("68050568 88826D3C 3EF116"), [DIAG]);
}

#[test]
fn the_lines_that_a_dump_omits_are_limited_and_the_rest_is_left_over() {
    let line = |address: u64| format!("{address:016x}  68 05 05 68 88 82 6D 3C 3E F1 16 00 00 00 00 00\n");
    let repeated = |text: &str| {
        let (rows, left_over, _) = rows(text);
        let lines: Vec<usize> = left_over.iter().map(|left_over| left_over.line).collect();
        (rows.iter().map(|row| row.times * row.octets.len() as u64).sum::<u64>(), lines)
    };
    let text = |gaps: &[u64]| {
        let (mut text, mut address) = (line(0), 0);
        for gap in gaps {
            address += gap + 16;
            text += &format!("*\n{}", line(address));
        }
        text
    };
    let most = MAX_REPEATED;
    assert_eq!(repeated(&text(&[most])), (most + 32, vec![]));
    assert_eq!(repeated(&text(&[most + 16])), (32, vec![2]));
    assert_eq!(repeated(&text(&[0x7FFF_FFFF_FFFF_FFE0])), (32, vec![2]));
    // The limit is one of the whole text.
    assert_eq!(repeated(&text(&[most - 32, 48, 32, 16])), (most + 80, vec![4, 8]));
}

#[test]
fn an_unreadable_word_between_octets_is_an_octet_with_an_error() {
    for (line, errors) in [
        ("68 05 ?? 68 88 82 6D 3C 3E F1 16", vec![2]),
        ("68 05 05! 68 88 82 6D 3C 3E F1 16", vec![2]),
        ("68 0G 05 68 88 xx 6D 3C 3E F1 16", vec![1, 5]),
    ] {
        let row = rows(line).0.remove(0);
        assert_eq!((row.octets.len(), row.errors), (11, errors), "{line}");
    }
}

#[test]
fn the_reader_takes_the_time_before_the_octets() {
    for (line, seconds) in [
        ("12.5 E5", Some(12.5)),
        ("[0.000250] E5", Some(0.000_25)),
        ("0.25s: E5", Some(0.25)),
        ("01:00:01.5 E5", Some(3601.5)),
        ("2026-11-21T00:00:02.25Z E5", Some(2.25)),
        ("08:15:00 10 08 02 49 53 16", Some(29700.0)),
        ("10 08 02 49 53 16", None),
        ("E5", None),
    ] {
        assert_eq!(rows(line).0[0].seconds, seconds, "{line}");
    }
}

/// A comment keeps a line from being read as plain octets.
#[test]
fn plain_octets_are_read_like_octets_among_words() {
    let mut random = Random::new(16);
    for _ in 0..2_000 {
        let (mut plain, mut commented) = (String::new(), String::new());
        for _ in 0..random.below(12) {
            let octets: Vec<String> = (0..random.below(6)).map(|_| format!("{:02x}", random.octet())).collect();
            let space = [" ", " ", " ", "  ", "\t", ""][random.below(6) as usize];
            let line = match random.below(12) {
                0 => format!("{:08x} {}", random.below(64), octets.join(" ")),
                1 => format!("{:04x} {}", random.below(64), octets.join(" ")),
                2 => "*".to_owned(),
                3 => format!("rx {}", octets.join(" ")),
                _ => octets.join(space),
            };
            let is_plain = plain_octets(&line).is_some();
            plain += &format!("{line}\n");
            commented += &if is_plain { format!("{line} //\n") } else { format!("{line}\n") };
        }
        let ((rows_plain, left_plain, _), (rows_commented, left_commented, _)) = (rows(&plain), rows(&commented));
        assert_eq!((rows_plain, left_plain), (rows_commented, left_commented), "{plain}");
    }
}

#[test]
fn a_line_of_plain_octets_has_nothing_but_octets() {
    assert_eq!(plain_octets("68 e5 0F"), Some(vec![0x68, 0xE5, 0x0F]));
    assert_eq!(plain_octets("e5 "), Some(vec![0xE5]));
    for line in ["", " e5", "e5  ", "e5 1", "e51", "e5e5", "e5 e5x", "e5\te5", "e5!", "0x e5", "e5 +1", "é5"] {
        assert_eq!(plain_octets(line), None, "{line}");
    }
}

/// Reading ends in hours if the work for a word grows with the words before or behind it.
#[test]
fn the_work_for_a_line_grows_with_its_length() {
    let octets = "e5 ".repeat(200_000);
    let times = "08:15:00.25 ".repeat(200_000);
    let blanks = "20  ".repeat(200_000);
    for (line, count) in [
        (format!("{octets}{}", " ".repeat(500_000)), 200_000),
        (format!("{times}{octets}"), 200_000),
        (blanks, 200_000),
        (format!("{}{}x", "20 ".repeat(200_000), " ".repeat(500_000)), 200_000),
    ] {
        let (rows, ..) = rows(&line);
        assert_eq!(rows.iter().map(|row| row.octets.len()).sum::<usize>(), count);
    }
}

#[test]
fn the_reader_takes_no_octets_from_words() {
    for line in ["", "# 68 05", "be careful", "the cafe added a face", "Slave 8 replied", "// DC 02 02", "7 of 9"] {
        assert_eq!(read(line), [""; 0], "{line}");
    }
    assert_eq!(read("RX: E5"), ["E5"]);
    assert_eq!(read("DC 02"), ["DC 02"]);
}
