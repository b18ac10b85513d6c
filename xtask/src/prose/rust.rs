//! Rust as comments, strings and identifiers.

use super::Found;
use super::words::{Place, Rules, sentence, sentences};

/// Everything in a Rust file that breaks a rule.
pub fn read(rules: &Rules, source: &str) -> Vec<Found> {
    let mut found = Vec::new();
    let mut comments = Comments::default();
    for Piece { line, kind, text } in pieces(source) {
        match kind {
            Kind::Identifier => found.extend(rules.identifier(text).into_iter().map(|found| (line, found))),
            Kind::String => found.extend(lines(line, text, |text| rules.text(text, Place::Text))),
            Kind::Comment => {
                found.extend(lines(line, text, |text| rules.text(text, Place::Prose)));
                comments.add(line, text, &mut found);
            }
        }
    }
    comments.end(&mut found);
    found
}

fn lines(first: usize, text: &str, rule: impl Fn(&str) -> Vec<super::words::Match>) -> Vec<Found> {
    let numbered = text.lines().enumerate();
    let each = numbered
        .flat_map(|(offset, text)| rule(text).into_iter().map(move |found| (first.saturating_add(offset), found)));
    each.collect()
}

/// Successive comment lines are one text, because sentences continue on the next line.
#[derive(Default)]
struct Comments {
    first: usize,
    last: usize,
    text: String,
}

impl Comments {
    fn add(&mut self, line: usize, text: &str, found: &mut Vec<Found>) {
        if self.text.is_empty() || line != self.last.saturating_add(1) || text.trim().is_empty() {
            self.end(found);
            self.first = line;
        }
        self.last = line;
        self.text.push_str(text.trim());
        self.text.push('\n');
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        let text = std::mem::take(&mut self.text);
        for (start, part) in sentences(&text) {
            let before = text.get(..start).unwrap_or_default().matches('\n').count();
            found.extend(sentence(part).map(|found| (self.first.saturating_add(before), found)));
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Identifier,
    String,
    Comment,
}

#[derive(Debug, PartialEq, Eq)]
struct Piece<'a> {
    line: usize,
    kind: Kind,
    text: &'a str,
}

/// The comments, strings and identifiers of a source, without their marks.
fn pieces(source: &str) -> Vec<Piece<'_>> {
    let (mut found, mut rest, mut line) = (Vec::new(), source, 1usize);
    while !rest.is_empty() {
        let (length, piece) = next(rest);
        found.extend(piece.map(|(kind, text)| Piece { line, kind, text }));
        let (taken, after) = rest.split_at_checked(length.max(1)).unwrap_or((rest, ""));
        line = line.saturating_add(taken.matches('\n').count());
        rest = after;
    }
    found
}

/// The length of the token at the beginning of `rest`, and its piece, if it is one.
fn next(rest: &str) -> (usize, Option<(Kind, &str)>) {
    if rest.starts_with("//") {
        let length = rest.find('\n').unwrap_or(rest.len());
        let text = rest.get(..length).unwrap_or_default().trim_start_matches(['/', '!']);
        return (length, Some((Kind::Comment, text)));
    }
    if rest.starts_with("/*") {
        return until(rest, 2, "*/", Kind::Comment);
    }
    if let Some(hashes) = raw_string(rest) {
        let begin = rest.find('"').unwrap_or_default().saturating_add(1);
        return until(rest, begin, &format!("\"{}", "#".repeat(hashes)), Kind::String);
    }
    match rest.chars().next() {
        Some('"') => string(rest),
        Some('\'') => (quote(rest), None),
        Some(char) if char.is_alphanumeric() || char == '_' => word(rest),
        Some(char) => (char.len_utf8(), None),
        None => (0, None),
    }
}

fn until<'a>(rest: &'a str, begin: usize, end: &str, kind: Kind) -> (usize, Option<(Kind, &'a str)>) {
    let inside = rest.get(begin..).unwrap_or_default();
    let length = inside.find(end).unwrap_or(inside.len());
    let text = inside.get(..length).unwrap_or_default();
    (begin.saturating_add(length).saturating_add(end.len()).min(rest.len()), Some((kind, text)))
}

/// The number of `#` of a raw string, if one begins here: `r"`, `br##"`.
fn raw_string(rest: &str) -> Option<usize> {
    let after = rest.strip_prefix("br").or_else(|| rest.strip_prefix('r'))?;
    let hashes = after.len().saturating_sub(after.trim_start_matches('#').len());
    after.get(hashes..)?.starts_with('"').then_some(hashes)
}

/// A string with escapes. A line that ends with a backslash continues on the next line.
fn string(rest: &str) -> (usize, Option<(Kind, &str)>) {
    let mut escaped = false;
    for (place, char) in rest.char_indices().skip(1) {
        match char {
            '"' if !escaped => {
                return (place.saturating_add(1), Some((Kind::String, rest.get(1..place).unwrap_or_default())));
            }
            '\\' => escaped = !escaped,
            _ => escaped = false,
        }
    }
    (rest.len(), None)
}

/// A character or a lifetime: `'a'`, `'\''`, `'a`.
fn quote(rest: &str) -> usize {
    let mut chars = rest.char_indices().skip(1);
    match (chars.next(), chars.next()) {
        (Some((_, '\\')), Some((escaped, _))) => {
            let after = rest.get(escaped.saturating_add(1)..).unwrap_or_default();
            let end = after.find('\'').unwrap_or_default();
            escaped.saturating_add(end).saturating_add(2)
        }
        (Some(_), Some((end, '\''))) => end.saturating_add(1),
        _ => 1,
    }
}

/// An identifier or a number; a number is not a piece.
fn word(rest: &str) -> (usize, Option<(Kind, &str)>) {
    let length = rest.find(|char: char| !char.is_alphanumeric() && char != '_').unwrap_or(rest.len());
    let text = rest.get(..length).unwrap_or_default();
    let number = text.starts_with(|char: char| char.is_ascii_digit());
    (length, (!number).then_some((Kind::Identifier, text)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prose::words::tests::rules;

    fn found(source: &str) -> Vec<(usize, String)> {
        read(&rules(), source).into_iter().map(|(line, found)| (line, found.word)).collect()
    }

    #[test]
    fn comments_strings_and_names_are_read() {
        let source = "// one ear\nlet my_ear = \"an\near\"; /* two\nears */\n/// ear\nfn f<'ear>(c: char) { r#\"ear\"#; '\"'; b'\\''; 'x'; ear }\n";
        let lines: Vec<usize> = found(source).into_iter().map(|(line, _)| line).collect();
        assert_eq!(lines, [1, 2, 3, 4, 5, 6, 6, 6]);
    }

    #[test]
    fn names_only_words_are_free_in_comments_and_strings() {
        assert_eq!(found("// a tool\nlet tool = \"tool\";"), [(2, "tool".to_owned())]);
    }

    #[test]
    fn sentences_run_over_lines_of_comments() {
        assert_eq!(found("/// It waits.\n/// What\n/// is sent is read.\nfn f() {}"), [(2, "What is".to_owned())]);
        assert!(found("/// What\n/// is sent, and\n/// when?\nfn f() {}").is_empty());
        assert_eq!(found("x\n// Who asks is answered."), [(2, "Who asks".to_owned())]);
    }

    #[test]
    fn quotes_in_characters_open_no_string() {
        assert_eq!(pieces("'\"' a").len(), 1);
        assert_eq!(pieces("'\\'' \"b\" '\\u{1F}' c").len(), 2);
    }
}
