//! Octets out of what programs print: hexadecimal in any dress, with times, arrows and words around it.
//!
//! | Print | Example |
//! |---|---|
//! | plain | `68 05 05 68 88 82 6D 3C 3E F1 16`, also with single digits, commas, `0x`, `h`, `\x` |
//! | joined | `680505688882`, `68:05:05:68`, `68-05-05-68` |
//! | dumps | `xxd`, `hexdump -C`, `hexdump` (words of the machine, low octet first), `od -A x -t x1` |
//! | logs | `PHY-serial: TX   10 08 02 49 53 16`, `12:00:00.5 2 -> 8 ; SRD ; 68 05 ...` |
//!
//! In each line the longest row of octets counts; of columns the one that has it. What cannot be read between octets
//! (`??`, `0G`, `08!`) is an octet with an error. A line without octets is a remark.

use profivac_wire::Telegram;

/// Octets of one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OctetRow {
    /// The time in front of them in seconds, if there is one.
    pub seconds: Option<f64>,
    /// The octets.
    pub octets: Vec<u8>,
    /// The numbers of those that could not be read or are marked as wrong, counted from 0.
    pub errors: Vec<usize>,
}

/// A word of a line.
#[derive(Clone, Debug, PartialEq)]
enum Word {
    Octets(Vec<u8>),
    /// One digit: an octet printed without its zero, or a number.
    Digit(u8),
    /// An octet that cannot be read, or is marked as wrong.
    Unreadable(u8),
    Time(f64),
    Other,
}

/// Reads line after line; a dump counts its octets.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    /// The offset the next line of a dump has.
    offset: usize,
}

/// Fewer octets than these among other words are words themselves: `cafe`, `be`.
const MIN_OCTETS: usize = 3;

impl Reader {
    /// The octets of a line, if it has any.
    pub fn line(&mut self, line: &str) -> Option<OctetRow> {
        let line = line.trim();
        if line.starts_with('#') || line.starts_with("//") {
            return None;
        }
        if let Some(octets) = self.dumped(line) {
            self.offset = self.offset.saturating_add(octets.len());
            return Some(OctetRow { octets, ..OctetRow::default() }).filter(|printed| !printed.octets.is_empty());
        }
        let columns = line.split(['|', ';', '\t']).map(words);
        let seconds =
            columns.clone().flatten().find_map(|word| if let Word::Time(time) = word { Some(time) } else { None });
        // Of rows that are equally long the last: numbers stand in front.
        let best = columns.filter_map(|words| row(&words)).max_by_key(|printed| printed.octets.len())?;
        Some(OctetRow { seconds, ..best })
    }

    /// A line of a dump: an offset that is right, octets, perhaps characters.
    fn dumped(&mut self, line: &str) -> Option<Vec<u8>> {
        let (first, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        let digits = first.strip_suffix(':').unwrap_or(first);
        let colon = digits.len() < first.len();
        let offset = usize::from_str_radix(digits, 16).ok().filter(|_| (6..=8).contains(&digits.len()))?;
        if offset != 0 && offset != self.offset {
            return None;
        }
        // Characters stand between bars (hexdump -C) or behind two spaces (xxd).
        let rest = rest.trim_start();
        let end = if colon { rest.find("  ") } else { rest.find('|') };
        let groups = rest.get(..end.unwrap_or(rest.len()))?;
        let swapped = !colon && groups.split_whitespace().all(|group| group.len() == 4);
        let mut octets = Vec::new();
        for group in groups.split_whitespace() {
            let mut pair = joined(group)?;
            if swapped {
                pair.reverse();
            }
            octets.extend(pair);
        }
        if offset == 0 {
            self.offset = 0;
        }
        // An offset alone ends a dump; at the beginning it would be a telegram of zeros.
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
        return word.split("\\x").filter(|digits| !digits.is_empty()).map(one).collect();
    }
    let lower = word.to_ascii_lowercase();
    if let Some(digits) = lower.strip_prefix("0x").or_else(|| lower.strip_prefix('$')) {
        let digits = if digits.len() == 1 { format!("0{digits}") } else { digits.to_owned() };
        return joined(&digits);
    }
    if let Some(digits) = lower.strip_suffix('h').filter(|digits| digits.len() == 2) {
        return joined(digits);
    }
    for separator in [':', '-', '_', '.'] {
        if lower.contains(separator) {
            return lower.split(separator).map(one).collect();
        }
    }
    joined(&lower)
}

fn one(digits: &str) -> Option<u8> {
    profivac_sim::describe::octet(digits)
}

/// Pairs of digits without anything between them.
fn joined(digits: &str) -> Option<Vec<u8>> {
    if digits.is_empty() || !digits.len().is_multiple_of(2) || !digits.is_ascii() {
        return None;
    }
    let pairs = digits.as_bytes().chunks(2).map(|pair| one(std::str::from_utf8(pair).ok()?));
    pairs.collect()
}

/// Seconds: `12.345`, `[12.345]`, `12.345s`, `08:15:00.25`, `08:15:00` in front of something else, a date before it.
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

/// The longest row of octets among words.
fn row(words: &[Word]) -> Option<OctetRow> {
    let is_octet = |word: &Word| matches!(word, Word::Octets(_) | Word::Digit(_) | Word::Unreadable(_));
    let rows = words.split(|word| !is_octet(word)).map(trimmed);
    let best = rows.max_by_key(|row| octets_in(row))?;
    let mut printed = OctetRow::default();
    for word in best {
        match word {
            Word::Octets(octets) => printed.octets.extend(octets),
            Word::Digit(octet) => printed.octets.push(*octet),
            Word::Unreadable(octet) => {
                printed.errors.push(printed.octets.len());
                printed.octets.push(*octet);
            }
            Word::Time(_) | Word::Other => {}
        }
    }
    let alone = !words.contains(&Word::Other) && !printed.octets.is_empty();
    let enough = alone || printed.octets.len() >= MIN_OCTETS || printed.octets == [0xE5];
    enough.then(|| without_numbers(printed, best))
}

/// A row begins and ends with something that was read as an octet.
fn trimmed(row: &[Word]) -> &[Word] {
    let sure = |word: &Word| matches!(word, Word::Octets(_));
    let marked = |word: &Word| sure(word) || matches!(word, Word::Unreadable(octet) if *octet != 0);
    match (row.iter().position(marked), row.iter().rposition(|word| !matches!(word, Word::Other))) {
        (Some(first), Some(last)) if row.iter().any(sure) => row.get(first..=last).unwrap_or_default(),
        _ => &[],
    }
}

fn octets_in(row: &[Word]) -> usize {
    row.iter().map(|word| if let Word::Octets(octets) = word { octets.len() } else { 1 }).sum()
}

/// Up to three words before a whole telegram with a check octet and one behind it are numbers: of lines, stations, channels,
/// octets.
fn without_numbers(printed: OctetRow, row: &[Word]) -> OctetRow {
    let single = row.iter().take_while(|word| !matches!(word, Word::Octets(octets) if octets.len() != 1)).count();
    for (skip, behind) in (0..=single.min(3)).flat_map(|skip| [(skip, 0), (skip, 1)]) {
        let end = printed.octets.len().saturating_sub(behind);
        let rest = printed.octets.get(skip..end).unwrap_or_default();
        if matches!(Telegram::parse(rest), Ok(Telegram::Data(_))) {
            let errors = printed.errors.iter().filter_map(|place| place.checked_sub(skip));
            let errors = errors.filter(|place| *place < rest.len()).collect();
            return OctetRow { octets: rest.to_vec(), errors, ..printed };
        }
    }
    printed
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_sim::describe::Hex;

    const DIAG: &str = "68 05 05 68 88 82 6D 3C 3E F1 16";

    fn read(text: &str) -> Vec<String> {
        let mut reader = Reader::default();
        text.lines().filter_map(|line| reader.line(line)).map(|printed| Hex(&printed.octets).to_string()).collect()
    }

    #[test]
    fn a_telegram_is_read_in_every_dress() {
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
            // The plain hexdump fills up to a word.
            assert_eq!(octets.first().map(|text| text.trim_end_matches(" 00")), Some(DIAG), "{line}");
        }
    }

    #[test]
    fn a_dump_of_many_lines_is_one_row_of_octets() {
        let dump = "\
00000000  68 05 05 68 88 82 6d 3c  3e f1 16 e5 10 08 02 49  |h..h..m<>......I|
00000010  53 16                                             |S.|
00000012";
        assert_eq!(read(dump), ["68 05 05 68 88 82 6D 3C 3E F1 16 E5 10 08 02 49", "53 16"]);
        // The same number in front of a line that it does not fit is eight digits of octets.
        assert_eq!(read("68050568 88826D3C 3EF116"), [DIAG]);
    }

    #[test]
    fn what_cannot_be_read_is_an_octet_with_an_error() {
        let mut reader = Reader::default();
        for (line, errors) in [
            ("68 05 ?? 68 88 82 6D 3C 3E F1 16", vec![2]),
            ("68 05 05! 68 88 82 6D 3C 3E F1 16", vec![2]),
            ("68 0G 05 68 88 xx 6D 3C 3E F1 16", vec![1, 5]),
        ] {
            let printed = reader.line(line).unwrap();
            assert_eq!((printed.octets.len(), printed.errors), (11, errors), "{line}");
        }
    }

    #[test]
    fn times_are_taken_from_the_front() {
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
    fn words_are_no_octets() {
        for line in ["", "# 68 05", "be careful", "the cafe added a face", "Slave 8 replied", "// DC 02 02", "7 of 9"] {
            assert_eq!(read(line), [""; 0], "{line}");
        }
        assert_eq!(read("RX: E5"), ["E5"]);
        assert_eq!(read("DC 02"), ["DC 02"]);
    }
}
