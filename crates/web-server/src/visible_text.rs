//! Names, reasons and comments that users type: what is shown is what is stored.
//!
//! Characters that are not visible, and those that change the direction of others, let one name look like another. They are refused
//! everywhere by the functions of this module.

use std::ops::RangeInclusive;

/// Characters that a font shows as nothing although Unicode counts them as letters, marks or symbols.
const BLANK: [RangeInclusive<char>; 11] = [
    '\u{34F}'..='\u{34F}',
    '\u{115F}'..='\u{1160}',
    '\u{17B4}'..='\u{17B5}',
    '\u{180B}'..='\u{180F}',
    '\u{2065}'..='\u{2065}',
    '\u{2800}'..='\u{2800}',
    '\u{3164}'..='\u{3164}',
    '\u{FE00}'..='\u{FE0F}',
    '\u{FFA0}'..='\u{FFA0}',
    '\u{1D159}'..='\u{1D159}',
    '\u{E0000}'..='\u{E0FFF}',
];

/// The most characters of a name. chosen: a line of a list shows it whole, and every index of a database holds it.
pub const MAX_NAME: usize = 120;

/// The most characters of a text that an error repeats.
const MAX_SHOWN: usize = 64;

/// The reason why a text is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextProblem {
    /// It is empty, or consists of spaces.
    #[error("expected at least one visible character, found none")]
    Empty,
    /// It begins or ends with a space.
    #[error("expected no space at the beginning and at the end, found {0:?}")]
    Edge(String),
    /// It has a character that is not visible.
    #[error("expected visible characters in one line, found U+{character:04X} in {text:?}", character = u32::from(*.character))]
    Invisible {
        /// The character.
        character: char,
        /// The text.
        text: String,
    },
    /// A name is a path, which a browser or a program could follow.
    #[error("expected a name, found the path {0:?}")]
    Path(String),
}

/// Checks a text of several lines: an instruction.
///
/// # Errors
/// [`TextProblem`] as [`check_line`], for each line that is not empty.
pub fn check_lines(text: &str) -> Result<(), TextProblem> {
    text.lines().filter(|line| !line.trim().is_empty()).try_for_each(|line| check_line(line.trim_matches(' ')))
}

/// Checks a line of text: a name, a reason, a comment.
///
/// # Errors
/// [`TextProblem`] for an empty text, for a space at an end, and for control, format, bidirectional, unassigned and other characters
/// that are not visible.
pub fn check_line(text: &str) -> Result<(), TextProblem> {
    let shown = || text.chars().take(MAX_SHOWN).collect();
    if let Some(character) = text.chars().find(|character| !is_visible(*character)) {
        return Err(TextProblem::Invisible { character, text: shown() });
    }
    match text.trim() {
        "" => Err(TextProblem::Empty),
        trimmed if trimmed != text => Err(TextProblem::Edge(shown())),
        _ => Ok(()),
    }
}

/// Checks a name: a line of text that is no path.
///
/// # Errors
/// [`TextProblem`].
pub fn check_name(name: &str) -> Result<(), TextProblem> {
    check_line(name)?;
    if is_path(name) { Err(TextProblem::Path(name.chars().take(MAX_SHOWN).collect())) } else { Ok(()) }
}

/// Whether a name is absolute, or has a part that is this folder or the one above.
#[must_use]
pub fn is_path(name: &str) -> bool {
    name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| matches!(part, "." | ".."))
}

/// Whether a character is visible: a space, or one that the tables of the standard library print as it is. They exclude the categories
/// Cc, Cf, Cn, Co, Cs, Zl, Zp, and Zs except the space.
fn is_visible(character: char) -> bool {
    // A mark at the beginning of a text would be escaped for another reason.
    let mut pair = [b'x'; 5];
    let (_, rest) = pair.split_at_mut(1);
    let length = character.encode_utf8(rest).len().saturating_add(1);
    let text = pair.get(..length).and_then(|octets| std::str::from_utf8(octets).ok());
    let is_escaped = text.is_none_or(|text| text.escape_debug().skip(1).take(2).eq(['\\', 'u']));
    let is_control = character.is_control();
    !is_control && !is_escaped && !BLANK.iter().any(|range| range.contains(&character))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invisible_and_bidirectional_characters_are_refused() {
        let bidirectional = ('\u{202A}'..='\u{202E}').chain('\u{2066}'..='\u{2069}').chain(['\u{61C}']);
        let invisible = "\u{200B}\u{200C}\u{200D}\u{200E}\u{200F}\u{2060}\u{2064}\u{FEFF}\u{AD}\u{180E}\u{34F}\u{115F}\u{3164}\u{FFA0}\
                         \u{2800}\u{FE0F}\u{E0001}\u{E0041}\u{E0100}\u{1D173}";
        let lines_and_spaces = "\0\t\n\r\u{1b}\u{7f}\u{85}\u{9b}\u{2028}\u{2029}\u{a0}\u{2003}\u{3000}\u{1680}";
        let unassigned_and_private = "\u{378}\u{E000}\u{FFFF}\u{10FFFF}\u{F0000}";
        let all = bidirectional
            .chain(invisible.chars())
            .chain(lines_and_spaces.chars())
            .chain(unassigned_and_private.chars())
            .collect::<Vec<_>>();
        for character in all {
            for text in [format!("a{character}b"), format!("{character}ab"), format!("ab{character}")] {
                let found = check_line(&text);
                assert!(matches!(found, Err(TextProblem::Invisible { .. })), "{text:?}: {found:?}");
            }
        }
        let message = check_line("cham\u{202E}ber").unwrap_err().to_string();
        assert_eq!(message, "expected visible characters in one line, found U+202E in \"cham\\u{202e}ber\"");
    }

    #[test]
    fn visible_text_of_any_language_is_permitted() {
        for text in [
            "a",
            "chamber 1",
            "tpg.2",
            "Kühlfalle",
            "cafe\u{301}",
            "真空計",
            "клапан",
            "שסתום",
            "צמצם",
            "वाल्व",
            "\"'\\<script>alert(1)</script>",
            "10⁻⁹ mbar µ Ω",
            "🔥",
            "a / b",
        ] {
            assert_eq!(check_name(text), Ok(()), "{text}");
        }
    }

    #[test]
    fn an_empty_text_and_spaces_at_an_end_are_refused() {
        assert_eq!((check_line(""), check_line("  ")), (Err(TextProblem::Empty), Err(TextProblem::Empty)));
        for text in [" a", "a "] {
            assert_eq!(check_line(text), Err(TextProblem::Edge(text.to_owned())));
        }
    }

    #[test]
    fn a_path_is_no_name() {
        for path in [".", "..", "../a", "a/..", "./a", "a/./b", "a\\..\\b", "/etc/passwd", "\\\\host"] {
            assert_eq!(check_name(path), Err(TextProblem::Path(path.to_owned())));
            assert_eq!(check_line(path), Ok(()), "a reason may contain a path");
        }
        for name in ["...", "a.b", "a..b", ".a", "a.", "1/2"] {
            assert_eq!(check_name(name), Ok(()), "{name}");
        }
    }
}
