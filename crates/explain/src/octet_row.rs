//! Reads octets from the text that programs print: hexadecimal in many notations, with times, arrows and words around it.
//!
//! | Text | Example |
//! |---|---|
//! | plain | `68 05 05 68 88 82 6D 3C 3E F1 16`, also with single digits, commas, `0x`, `h`, `\x` |
//! | joined | `680505688882`, `68:05:05:68`, `68-05-05-68` |
//! | dumps | `xxd`, `hexdump -C`, `hexdump` (words of 16 bits, low octet first), `od -A x -t x1` |
//! | logs | `PHY-serial: TX   10 08 02 49 53 16`, `12:00:00.5 2 -> 8 ; SRD ; 68 05 ...` |
//!
//! The longest row of octets in a line counts; if the line has columns, only the column with the longest row. An unreadable
//! word between octets (`??`, `0G`, `08!`) is an octet with an error. A line may have no octets.

use profivac_wire::Telegram;

/// Octets of one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OctetRow {
    /// The time before them in seconds, if the line has one.
    pub seconds: Option<f64>,
    /// The octets.
    pub octets: Vec<u8>,
    /// Positions of the octets that are unreadable or marked with `!`, counted from 0.
    pub errors: Vec<usize>,
}

/// A word of a line.
#[derive(Clone, Debug, PartialEq)]
enum Word {
    Octets(Vec<u8>),
    /// One digit: an octet without its leading zero, or a number.
    Digit(u8),
    /// An octet that is unreadable or marked with `!`.
    Unreadable(u8),
    Time(f64),
    Other,
}

/// Reads octets line by line, and keeps the offset of a dump.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    /// The offset of the next line of a dump.
    offset: usize,
}

/// The least number of octets in a line with other words: `cafe` and `be` are words.
const MIN_OCTETS: usize = 3;

impl Reader {
    /// The octets of a line, if it has any.
    pub fn line(&mut self, line: &str) -> Option<OctetRow> {
        let line = line.trim();
        if line.starts_with('#') || line.starts_with("//") {
            return None;
        }
        if let Some(octets) = self.dump_line(line) {
            self.offset = self.offset.saturating_add(octets.len());
            return Some(OctetRow { octets, ..OctetRow::default() }).filter(|row| !row.octets.is_empty());
        }
        let columns = line.split(['|', ';', '\t']).map(words);
        let seconds =
            columns.clone().flatten().find_map(|word| if let Word::Time(time) = word { Some(time) } else { None });
        // The last of the rows with the same length: numbers are in front.
        let best = columns.filter_map(|words| longest_row(&words)).max_by_key(|row| row.octets.len())?;
        Some(OctetRow { seconds, ..best })
    }

    /// The octets of a line of a dump: the expected offset, octets, and maybe characters.
    fn dump_line(&mut self, line: &str) -> Option<Vec<u8>> {
        let (first, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        let digits = first.strip_suffix(':').unwrap_or(first);
        let colon = digits.len() < first.len();
        let offset = usize::from_str_radix(digits, 16).ok().filter(|_| (6..=8).contains(&digits.len()))?;
        if offset != 0 && offset != self.offset {
            return None;
        }
        // Characters are between bars (hexdump -C) or after two spaces (xxd).
        let rest = rest.trim_start();
        let end = if colon { rest.find("  ") } else { rest.find('|') };
        let groups = rest.get(..end.unwrap_or(rest.len()))?;
        let swapped = !colon && groups.split_whitespace().all(|group| group.len() == 4);
        let mut octets = Vec::new();
        for group in groups.split_whitespace() {
            let mut pair = digit_pairs(group)?;
            if swapped {
                pair.reverse();
            }
            octets.extend(pair);
        }
        if offset == 0 {
            self.offset = 0;
        }
        // A line with an offset only ends a dump; as the first line it would be octets of zero.
        (!octets.is_empty() || offset == self.offset).then_some(octets)
    }
}

fn words(column: &str) -> Vec<Word> {
    let separates = |letter: char| letter.is_whitespace() || ",[](){}<>\"'=".contains(letter);
    let words = column.split(separates).filter(|word| !word.is_empty());
    words.enumerate().map(|(place, word)| classified(word, place)).collect()
}

fn classified(word: &str, place: usize) -> Word {
    if let Some(time) = time(word, place) {
        return Word::Time(time);
    }
    let (plain, marked) = word.strip_suffix('!').map_or((word, false), |plain| (plain, true));
    match (octets_of(plain), marked) {
        (Some(octets), true) => octets.first().map_or(Word::Other, |octet| Word::Unreadable(*octet)),
        (Some(octets), false) => Word::Octets(octets),
        (None, _) => match plain.as_bytes() {
            [digit] if digit.is_ascii_hexdigit() => u8::from_str_radix(plain, 16).map_or(Word::Other, Word::Digit),
            [_, _]
                if !plain.bytes().all(|letter| letter.is_ascii_alphabetic() && !b"xX".contains(&letter))
                    && !plain.contains(['>', '-'])
                    || plain == "--" =>
            {
                Word::Unreadable(0)
            }
            _ => Word::Other,
        },
    }
}

/// `68`, `0x68`, `68h`, `$68`, `\x68\x05`, `680505`, `68:05:05`, `68-05-05`.
fn octets_of(word: &str) -> Option<Vec<u8>> {
    if word.contains("\\x") {
        return word.split("\\x").filter(|digits| !digits.is_empty()).map(octet).collect();
    }
    let lower = word.to_ascii_lowercase();
    if let Some(digits) = lower.strip_prefix("0x").or_else(|| lower.strip_prefix('$')) {
        let digits = if digits.len() == 1 { format!("0{digits}") } else { digits.to_owned() };
        return digit_pairs(&digits);
    }
    if let Some(digits) = lower.strip_suffix('h').filter(|digits| digits.len() == 2) {
        return digit_pairs(digits);
    }
    for separator in [':', '-', '_', '.'] {
        if lower.contains(separator) {
            return lower.split(separator).map(octet).collect();
        }
    }
    digit_pairs(&lower)
}

fn octet(digits: &str) -> Option<u8> {
    profivac_sim::describe::octet(digits)
}

/// Octets from pairs of digits without separators.
fn digit_pairs(digits: &str) -> Option<Vec<u8>> {
    if digits.is_empty() || !digits.len().is_multiple_of(2) || !digits.is_ascii() {
        return None;
    }
    let pairs = digits.as_bytes().chunks(2).map(|pair| octet(std::str::from_utf8(pair).ok()?));
    pairs.collect()
}

/// A time in seconds: `12.345`, `[12.345]`, `12.345s`, `08:15:00.25`, a first word `08:15:00`; a date with `T` may precede it.
fn time(word: &str, place: usize) -> Option<f64> {
    let clock = word.rsplit_once('T').map_or(word, |(_, clock)| clock).trim_end_matches(['Z', ':']);
    let groups: Vec<&str> = clock.split(':').collect();
    if let [hours, minutes, seconds] = groups[..] {
        let fraction = seconds.contains('.') || (place == 0 && clock.len() == 8);
        let (hours, minutes, seconds): (f64, f64, f64) =
            (hours.parse().ok()?, minutes.parse().ok()?, seconds.parse().ok()?);
        let possible = hours < 24.0 && minutes < 60.0 && seconds < 61.0;
        return (fraction && possible).then_some(hours * 3600.0 + minutes * 60.0 + seconds);
    }
    let number = word.trim_end_matches([':', 's']);
    let (whole, fraction) = number.split_once('.')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_digit());
    (place == 0 && digits(whole) && digits(fraction)).then(|| number.parse().ok())?
}

/// The longest row of octets in a column.
fn longest_row(words: &[Word]) -> Option<OctetRow> {
    let is_octet = |word: &Word| matches!(word, Word::Octets(_) | Word::Digit(_) | Word::Unreadable(_));
    let rows = words.split(|word| !is_octet(word)).map(trimmed);
    let best = rows.max_by_key(|row| octets_in(row))?;
    let mut octet_row = OctetRow::default();
    for word in best {
        match word {
            Word::Octets(octets) => octet_row.octets.extend(octets),
            Word::Digit(octet) => octet_row.octets.push(*octet),
            Word::Unreadable(octet) => {
                octet_row.errors.push(octet_row.octets.len());
                octet_row.octets.push(*octet);
            }
            Word::Time(_) | Word::Other => {}
        }
    }
    let alone = !words.contains(&Word::Other) && !octet_row.octets.is_empty();
    let enough = alone || octet_row.octets.len() >= MIN_OCTETS || octet_row.octets == [0xE5];
    enough.then(|| without_numbers(octet_row, best))
}

/// The row without numbers and unreadable words before its first octet; empty if no word is certainly an octet.
fn trimmed(row: &[Word]) -> &[Word] {
    let is_certain = |word: &Word| matches!(word, Word::Octets(_));
    let may_begin = |word: &Word| is_certain(word) || matches!(word, Word::Unreadable(octet) if *octet != 0);
    match (row.iter().position(may_begin), row.iter().rposition(|word| !matches!(word, Word::Other))) {
        (Some(first), Some(last)) if row.iter().any(is_certain) => row.get(first..=last).unwrap_or_default(),
        _ => &[],
    }
}

fn octets_in(row: &[Word]) -> usize {
    row.iter().map(|word| if let Word::Octets(octets) = word { octets.len() } else { 1 }).sum()
}

/// Removes up to three words before a complete telegram with a check octet, and one after it: they are numbers of lines,
/// stations, channels or octets.
fn without_numbers(octet_row: OctetRow, words: &[Word]) -> OctetRow {
    let single = words.iter().take_while(|word| !matches!(word, Word::Octets(octets) if octets.len() != 1)).count();
    for (skip, after) in (0..=single.min(3)).flat_map(|skip| [(skip, 0), (skip, 1)]) {
        let end = octet_row.octets.len().saturating_sub(after);
        let rest = octet_row.octets.get(skip..end).unwrap_or_default();
        if matches!(Telegram::parse(rest), Ok(Telegram::Data(_))) {
            let errors = octet_row.errors.iter().filter_map(|place| place.checked_sub(skip));
            let errors = errors.filter(|place| *place < rest.len()).collect();
            return OctetRow { octets: rest.to_vec(), errors, ..octet_row };
        }
    }
    octet_row
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_sim::describe::Hex;

    const DIAG: &str = "68 05 05 68 88 82 6D 3C 3E F1 16";

    fn read(text: &str) -> Vec<String> {
        let mut reader = Reader::default();
        text.lines().filter_map(|line| reader.line(line)).map(|row| Hex(&row.octets).to_string()).collect()
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
            "12 68 05 05 68 88 82 6D 3C 3E F1 16",
            "2 -> 8  Slave_Diag req | 68 05 05 68 88 82 6D 3C 3E F1 16",
            "[  3.25] 68 05 05 68 88 82 6D 3C 3E F1 16",
            "00000000: 6805 0568 8882 6d3c 3ef1 16              h..h..m<>..",
            "00000000  68 05 05 68 88 82 6d 3c  3e f1 16                 |h..h..m<>..|",
            "0000000 0568 6805 8288 3c6d f13e 0016",
        ] {
            let octets = read(line);
            // The plain hexdump adds an octet to complete a word.
            assert_eq!(octets.first().map(|text| text.trim_end_matches(" 00")), Some(DIAG), "{line}");
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
    fn an_unreadable_word_between_octets_is_an_octet_with_an_error() {
        let mut reader = Reader::default();
        for (line, errors) in [
            ("68 05 ?? 68 88 82 6D 3C 3E F1 16", vec![2]),
            ("68 05 05! 68 88 82 6D 3C 3E F1 16", vec![2]),
            ("68 0G 05 68 88 xx 6D 3C 3E F1 16", vec![1, 5]),
        ] {
            let row = reader.line(line).unwrap();
            assert_eq!((row.octets.len(), row.errors), (11, errors), "{line}");
        }
    }

    #[test]
    fn the_reader_takes_the_time_before_the_octets() {
        let mut reader = Reader::default();
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
            assert_eq!(reader.line(line).unwrap().seconds, seconds, "{line}");
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
}
