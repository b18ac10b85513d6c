//! Octets to text and back.
//!
//! GSD files are ASCII by the specification, profibus-wire 7; real files are in the code page of the computer that wrote them. An editor
//! that saves a file as "Unicode" makes UTF-16 of it.

use std::borrow::Cow;

/// The code page of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// No octet above 127.
    Ascii,
    /// UTF-8 without a mark.
    Utf8,
    /// UTF-8 with a byte order mark.
    Utf8Bom,
    /// UTF-16 without a mark, the least significant octet of a character first.
    Utf16Le,
    /// UTF-16 with a byte order mark, the least significant octet first.
    Utf16LeBom,
    /// UTF-16 without a mark, the most significant octet first.
    Utf16Be,
    /// UTF-16 with a byte order mark, the most significant octet first.
    Utf16BeBom,
    /// Windows, western Europe.
    Cp1252,
    /// DOS, western Europe.
    Cp850,
    /// DOS, United States.
    Cp437,
}

// chosen: tables instead of a crate. encoding_rs has neither code page of DOS, and three strings need no dependency.
const CP1252_FROM_80: &str = "€\u{81}‚ƒ„…†‡ˆ‰Š‹Œ\u{8d}Ž\u{8f}\u{90}‘’“”•–—˜™š›œ\u{9d}žŸ";
const CP850: &str = "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜø£Ø×ƒ\
    áíóúñÑªº¿®¬½¼¡«»░▒▓│┤ÁÂÀ©╣║╗╝¢¥┐\
    └┴┬├─┼ãÃ╚╔╩╦╠═╬¤ðÐÊËÈıÍÎÏ┘┌█▄¦Ì▀\
    ÓßÔÒõÕµþÞÚÛÙýÝ¯´\u{ad}±‗¾¶§÷¸°¨·¹³²■\u{a0}";
const CP437: &str = "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒ\
    áíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐\
    └┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀\
    αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{a0}";

const BOM: &[u8] = b"\xEF\xBB\xBF";

/// How a file in UTF-16 is written.
struct Wide {
    mark: &'static [u8],
    is_little_endian: bool,
}

impl Wide {
    fn units<'a>(&self, octets: &'a [u8]) -> impl Iterator<Item = u16> + use<'a> {
        let unit = if self.is_little_endian { u16::from_le_bytes } else { u16::from_be_bytes };
        octets.as_chunks::<2>().0.iter().map(move |pair| unit(*pair))
    }

    /// Whether the octets are text in this code, which becomes the same octets again. A file without a mark begins with an ASCII character:
    /// one of its first two octets is 0.
    fn is_code_of(&self, octets: &[u8]) -> bool {
        let Some(text) = octets.strip_prefix(self.mark) else { return false };
        let starts = !self.mark.is_empty() || self.units(text).next().is_some_and(|unit| (1..0x80).contains(&unit));
        starts && text.len().is_multiple_of(2) && char::decode_utf16(self.units(text)).all(|one| one.is_ok())
    }

    fn decode(&self, octets: &[u8]) -> String {
        let text = octets.strip_prefix(self.mark).unwrap_or(octets);
        char::decode_utf16(self.units(text)).map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    }

    fn encode(&self, text: &str) -> Vec<u8> {
        let octets = if self.is_little_endian { u16::to_le_bytes } else { u16::to_be_bytes };
        self.mark.iter().copied().chain(text.encode_utf16().flat_map(octets)).collect()
    }
}

impl Encoding {
    /// The codes of UTF-16. Those with a mark come first, because it would be a character otherwise.
    const WIDE: [Encoding; 4] = [Encoding::Utf16LeBom, Encoding::Utf16BeBom, Encoding::Utf16Le, Encoding::Utf16Be];

    fn wide(self) -> Option<Wide> {
        let (mark, is_little_endian): (&[u8], bool) = match self {
            Encoding::Utf16Le => (b"", true),
            Encoding::Utf16LeBom => (b"\xFF\xFE", true),
            Encoding::Utf16Be => (b"", false),
            Encoding::Utf16BeBom => (b"\xFE\xFF", false),
            _ => return None,
        };
        Some(Wide { mark, is_little_endian })
    }

    /// Whether a character takes two octets or four.
    #[must_use]
    pub fn is_utf16(self) -> bool {
        self.wide().is_some()
    }

    /// The name as a user knows it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Encoding::Ascii => "ASCII",
            Encoding::Utf8 => "UTF-8",
            Encoding::Utf8Bom => "UTF-8 with byte order mark",
            Encoding::Utf16Le => "UTF-16LE",
            Encoding::Utf16LeBom => "UTF-16LE with byte order mark",
            Encoding::Utf16Be => "UTF-16BE",
            Encoding::Utf16BeBom => "UTF-16BE with byte order mark",
            Encoding::Cp1252 => "cp1252",
            Encoding::Cp850 => "cp850",
            Encoding::Cp437 => "cp437",
        }
    }

    /// The code page of these octets.
    ///
    /// Text that is valid UTF-16 and begins with a byte order mark or an ASCII character is UTF-16. Other text that is valid UTF-8 is UTF-8.
    /// Otherwise each code page is judged by the characters that it makes of the octets: letters of
    /// western languages count for it, lines of boxes and capitals inside a word against it. chosen: cp1252 if two are equal.
    #[must_use]
    pub fn detect(octets: &[u8]) -> Encoding {
        let is_code = |one: &Encoding| one.wide().is_some_and(|wide| wide.is_code_of(octets));
        if let Some(wide) = Self::WIDE.into_iter().find(is_code) {
            return wide;
        }
        match std::str::from_utf8(octets) {
            Ok(_) if octets.starts_with(BOM) => Encoding::Utf8Bom,
            Ok(_) if octets.is_ascii() => Encoding::Ascii,
            Ok(_) => Encoding::Utf8,
            Err(_) => Self::judged(octets),
        }
    }

    fn judged(octets: &[u8]) -> Encoding {
        let mut best = (Encoding::Cp1252, Encoding::Cp1252.score(octets));
        for page in [Encoding::Cp850, Encoding::Cp437] {
            let score = page.score(octets);
            if score > best.1 {
                best = (page, score);
            }
        }
        best.0
    }

    fn score(self, octets: &[u8]) -> i64 {
        let table = self.table();
        let neighbour = |at: Option<usize>| at.and_then(|at| octets.get(at)).copied().unwrap_or(b' ');
        let high = octets.iter().enumerate().filter(|(_, octet)| !octet.is_ascii());
        high.map(|(at, octet)| {
            judge(character(&table, *octet), neighbour(at.checked_sub(1)), neighbour(at.checked_add(1)))
        })
        .sum()
    }

    /// The characters of the octets from 0x80 on.
    fn table(self) -> Vec<char> {
        match self {
            Encoding::Cp850 => CP850.chars().collect(),
            Encoding::Cp437 => CP437.chars().collect(),
            _ => CP1252_FROM_80.chars().chain('\u{a0}'..='\u{ff}').collect(),
        }
    }

    /// The text of the octets, without a byte order mark. [`Encoding::encode`] makes the same octets of it.
    #[must_use]
    pub fn decode(self, octets: &[u8]) -> String {
        match self {
            Encoding::Ascii | Encoding::Utf8 | Encoding::Utf8Bom => {
                String::from_utf8_lossy(octets.strip_prefix(BOM).unwrap_or(octets)).into_owned()
            }
            _ => match self.wide() {
                Some(wide) => wide.decode(octets),
                None => {
                    let table = self.table();
                    octets.iter().map(|octet| character(&table, *octet)).collect()
                }
            },
        }
    }

    /// The octets of a text, or the first character that the code page lacks.
    ///
    /// # Errors
    ///
    /// A character that the code page lacks.
    pub fn encode(self, text: &str) -> Result<Vec<u8>, char> {
        match self {
            Encoding::Ascii => {
                text.chars().find(|one| !one.is_ascii()).map_or_else(|| Ok(text.as_bytes().to_vec()), Err)
            }
            Encoding::Utf8 => Ok(text.as_bytes().to_vec()),
            Encoding::Utf8Bom => Ok([BOM, text.as_bytes()].concat()),
            _ => match self.wide() {
                Some(wide) => Ok(wide.encode(text)),
                None => self.encode_by_table(text),
            },
        }
    }

    fn encode_by_table(self, text: &str) -> Result<Vec<u8>, char> {
        let octets = (0x80_u8..=0xFF).zip(self.table()).map(|(octet, character)| (character, octet));
        let octets: std::collections::HashMap<char, u8> = octets.collect();
        let octet = |one: char| if one.is_ascii() { u8::try_from(one).ok() } else { octets.get(&one).copied() };
        text.chars().map(|one| octet(one).ok_or(one)).collect()
    }
}

impl std::fmt::Display for Encoding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

fn character(table: &[char], octet: u8) -> char {
    octet.checked_sub(0x80).and_then(|at| table.get(usize::from(at))).copied().unwrap_or(char::from(octet))
}

/// How well a character fits between its neighbours.
fn judge(character: char, before: u8, after: u8) -> i64 {
    const LETTERS: &str = "äöüßéèêëàâáçñíìîïóòôúùûåæøãõ";
    const SIGNS: &str = "’–„“”°µ²³±®©«»´§\u{a0}";
    let starts_a_word = !before.is_ascii_alphanumeric() && after.is_ascii_alphabetic();
    let is_capital = character.to_lowercase().next().is_some_and(|small| small != character && LETTERS.contains(small));
    match character {
        // 500 µs and 20 °C in one code page are letters in the other.
        'µ' if !before.is_ascii_alphabetic() && b"smAVFHW".contains(&after) => 4,
        '°' if before.is_ascii_digit() || b"CF".contains(&after) => 4,
        _ if LETTERS.contains(character) && before.is_ascii_digit() => -2,
        _ if LETTERS.contains(character) => 3,
        _ if is_capital && (starts_a_word || before.is_ascii_uppercase()) => 2,
        _ if is_capital => -2,
        '’' if before.is_ascii_alphabetic() && after.is_ascii_alphabetic() => 4,
        _ if SIGNS.contains(character) => 1,
        '\u{80}'..='\u{9f}' | '\u{2500}'..='\u{25ff}' => -3,
        _ => -1,
    }
}

/// The octets of a text in its own code page, or as UTF-8 if that page lacks a character.
pub(crate) fn octets_of(encoding: Encoding, text: &str) -> Cow<'_, [u8]> {
    encoding.encode(text).map_or_else(|_| Cow::Borrowed(text.as_bytes()), Cow::Owned)
}
