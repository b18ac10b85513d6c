//! One octet in the notations that loggers write for one octet.

/// Notation of a column of octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Radix {
    /// Two hexadecimal digits, or one or two behind `0x`.
    Hexadecimal,
    /// One or two hexadecimal digits, without leading zeros.
    Unpadded,
    /// A number from 0 to 255.
    Decimal,
    /// Eight binary digits, also behind `0b`.
    Binary,
    /// Three octal digits.
    Octal,
    /// A letter, or a number in brackets, quotes or behind a backslash where no letter can be printed.
    Characters,
}

impl Radix {
    /// All notations. Of two that fit equally well, the first one counts.
    pub(super) const ALL: [Self; 6] =
        [Self::Hexadecimal, Self::Decimal, Self::Binary, Self::Octal, Self::Characters, Self::Unpadded];

    /// The words for a message.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Hexadecimal | Self::Unpadded => "hexadecimal",
            Self::Decimal => "decimal",
            Self::Binary => "binary",
            Self::Octal => "octal",
            Self::Characters => "characters",
        }
    }

    /// The octet of a text.
    pub(super) fn octet(self, text: &str) -> Option<u8> {
        // The character or the number, and behind it the octet, as Saleae Logic 1 writes it: `'16' (0x10)`.
        let behind = text.rsplit_once(" (0x").and_then(|(_, rest)| rest.strip_suffix(')'));
        let text = behind.filter(|_| self == Self::Hexadecimal).unwrap_or(text);
        let number = |digits: &str, radix: u32| {
            let is_number = !digits.is_empty() && digits.chars().all(|letter| letter.is_digit(radix));
            u8::from_str_radix(digits, radix).ok().filter(|_| is_number)
        };
        let prefixed = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
        match (self, prefixed) {
            (Self::Characters, _) => character(text),
            (Self::Hexadecimal | Self::Unpadded, Some(digits)) => number(digits, 16).filter(|_| digits.len() <= 2),
            (_, Some(_)) => None,
            (Self::Hexadecimal, None) => {
                let digits = text.strip_suffix(['h', 'H']).unwrap_or(text);
                number(digits, 16).filter(|_| digits.len() == 2)
            }
            (Self::Unpadded, None) => number(text, 16).filter(|_| text.len() <= 2),
            (Self::Decimal, None) => number(text, 10).filter(|_| text.len() <= 3),
            (Self::Binary, None) => {
                let digits: String = text.strip_prefix("0b").unwrap_or(text).split([' ', '_']).collect();
                number(&digits, 2).filter(|_| digits.len() == 8)
            }
            (Self::Octal, None) => number(text, 8).filter(|_| text.len() == 3),
        }
    }
}

/// `A`, `'A'`, `[0A]`, `\x0A`, `'10'`, `\n`, COMMA.
fn character(text: &str) -> Option<u8> {
    let hexadecimal = |digits: &str| u8::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 2);
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) => return u8::try_from(letter).ok().filter(u8::is_ascii),
        (Some('['), Some(_)) => return hexadecimal(text.get(1..)?.strip_suffix(']')?),
        (Some('\\'), Some('x')) => return hexadecimal(text.get(2..)?),
        (Some('\\'), Some(kind)) if text.len() == 2 => return escape(kind),
        _ => {}
    }
    match text {
        "COMMA" => return Some(b','),
        "SPACE" => return Some(b' '),
        _ => {}
    }
    let inner = text.strip_prefix('\'')?.strip_suffix('\'')?;
    let number = || inner.parse::<u8>().ok().filter(|_| inner.bytes().all(|letter| letter.is_ascii_digit()));
    let mut letters = inner.chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) if !letter.is_ascii_digit() => u8::try_from(letter).ok().filter(u8::is_ascii),
        _ => number(),
    }
}

const fn escape(kind: char) -> Option<u8> {
    Some(match kind {
        '0' => 0,
        't' => 9,
        'n' => 10,
        'r' => 13,
        '\\' => b'\\',
        _ => return None,
    })
}
