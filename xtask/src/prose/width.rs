//! The width of lines of text: pages, and comments in Rust. `rustfmt` breaks code and leaves comments as they are.
//!
//! Rows of tables, blocks of code and lines without a place to break may be longer.

/// The most characters of a line of a page.
pub const PAGE: usize = 160;

/// The most characters of a line with a comment.
pub const COMMENT: usize = 140;

/// The lines of a page that are too wide.
pub fn in_page(text: &str) -> Vec<usize> {
    numbers(text, |line| Some(line).filter(|line| !line.trim_start().starts_with("<!--")), PAGE)
}

/// The lines of a source in Rust whose comment is too wide.
pub fn in_rust(text: &str) -> Vec<usize> {
    numbers(text, comment, COMMENT)
}

/// The page with its wide lines broken.
pub fn wrap_page(text: &str) -> String {
    wrap(text, &in_page(text), PAGE, page_indent)
}

/// The source with its wide comments broken.
pub fn wrap_rust(text: &str) -> String {
    wrap(text, &in_rust(text), COMMENT, comment_indent)
}

/// The text of a line that is nothing but a comment.
fn comment(line: &str) -> Option<&str> {
    line.trim_start().strip_prefix("//").map(|text| text.trim_start_matches(['/', '!']))
}

/// The numbers of the lines that are too wide and can be broken. `text_of` gives the text of a line; lines without one end a block of code.
fn numbers(text: &str, text_of: impl Fn(&str) -> Option<&str>, most: usize) -> Vec<usize> {
    let (mut found, mut in_code) = (Vec::new(), false);
    for (number, line) in (1..).zip(text.lines()) {
        let Some(content) = text_of(line) else {
            in_code = false;
            continue;
        };
        if content.trim_start().starts_with("```") {
            in_code = !in_code;
        } else if !in_code && !content.trim_start().starts_with('|') && place(line, most).is_some() {
            found.push(number);
        }
    }
    found
}

/// Where a line that is too wide is broken: the last blank within the width at which the rest begins no list, heading, table or number,
/// and which is neither in code nor in the text of a link. `None` for a line that is narrow enough, or that has no such blank.
fn place(line: &str, most: usize) -> Option<usize> {
    let width = line.char_indices().nth(most).map(|(at, _)| at)?;
    let indent = line.len().saturating_sub(line.trim_start().len());
    let (mut in_code, mut brackets, mut last) = (false, 0_i32, None);
    for (at, letter) in line.char_indices().take_while(|(at, _)| *at <= width) {
        match letter {
            '`' => in_code = !in_code,
            '[' if !in_code => brackets += 1,
            ']' if !in_code => brackets -= 1,
            ' ' if at > indent && !in_code && brackets <= 0 && may_begin(line.get(at..)?.trim_start()) => {
                last = Some(at)
            }
            _ => {}
        }
    }
    // A marker of a list alone is no line.
    last.filter(|at| line.get(..*at).is_some_and(|before| before.split_whitespace().count() > 1))
}

/// Whether a line may begin with this text: without becoming something else than a part of its paragraph, and without separating the
/// number of a citation or a unit from the word before it.
fn may_begin(rest: &str) -> bool {
    rest.chars().next().is_some_and(|first| !first.is_ascii_digit() && !"-+*#>|=<[".contains(first))
}

/// The text before the second part of a broken line of a page: the indentation of the text in a list.
fn page_indent(line: &str) -> String {
    let text = line.trim_start();
    let indent = line.len().saturating_sub(text.len());
    let word = text.split(' ').next().unwrap_or_default();
    let marker = if matches!(word, "-" | "*" | "+" | ">") || is_item(text) { word.len().saturating_add(1) } else { 0 };
    if word == ">" { "> ".to_owned() } else { " ".repeat(indent.saturating_add(marker)) }
}

/// The same for a comment: its slashes.
fn comment_indent(line: &str) -> String {
    let text = line.trim_start();
    let blanks = " ".repeat(line.len().saturating_sub(text.len()));
    let end = text.find(|letter| !matches!(letter, '/' | '!')).unwrap_or(text.len());
    let (slashes, text) = text.split_at(end);
    format!("{blanks}{slashes} {}", page_indent(text.strip_prefix(' ').unwrap_or(text)))
}

/// Breaks the lines with these numbers. The rest of a line goes to the next one if that continues its paragraph.
fn wrap(text: &str, wide: &[usize], most: usize, indent: impl Fn(&str) -> String) -> String {
    let mut wrapped = String::with_capacity(text.len());
    let mut lines = (1..).zip(text.lines()).peekable();
    while let Some((number, line)) = lines.next() {
        let (mut rest, mut next_indent) = (line.to_owned(), None);
        while let Some(at) = place(&rest, most).filter(|_| next_indent.is_some() || wide.contains(&number)) {
            let (first, behind) = rest.split_at(at);
            wrapped.push_str(first.trim_end());
            wrapped.push('\n');
            let indent = next_indent.get_or_insert_with(|| indent(line));
            rest = format!("{indent}{}", behind.trim_start());
            while let Some((_, next)) =
                lines.next_if(|(_, next)| place(&rest, most).is_none() && continues(next, indent))
            {
                rest = format!("{rest} {}", next.get(indent.len()..).unwrap_or_default());
            }
        }
        wrapped.push_str(&rest);
        wrapped.push('\n');
    }
    wrapped
}

/// Whether a line continues a paragraph whose lines begin with `indent`.
fn continues(line: &str, indent: &str) -> bool {
    let text = line.strip_prefix(indent).filter(|text| !text.starts_with([' ', '`', '!', '\\']));
    text.is_some_and(|text| text.starts_with(|first: char| first.is_ascii_digit() || may_begin(text)) && !is_item(text))
}

/// Whether a text begins with the number of a list.
fn is_item(text: &str) -> bool {
    let word = text.split(' ').next().unwrap_or_default();
    word.strip_suffix(['.', ')'])
        .is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|it| it.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words with this number of characters in all, and the blanks between them.
    fn words(characters: usize) -> String {
        "word ".repeat(characters / 5)
    }

    #[test]
    fn a_wide_line_is_found_unless_it_is_a_row_or_code_or_cannot_be_broken() {
        let wide = words(200);
        let page = format!("{wide}\n| {wide} |\n```\n{wide}\n```\n{}\nshort\n<!-- {wide} -->\n", "x".repeat(200));
        assert_eq!(in_page(&page), [1]);
        let rust = format!("/// {wide}\nlet a = 1; // {wide}\n/// ```\n/// {wide}\n/// ```\n//! | {wide} |\n");
        assert_eq!(in_rust(&rust), [1]);
    }

    #[test]
    fn a_wrapped_page_has_no_wide_line_and_the_same_words() {
        let item =
            format!("- {}[a link of words](a.md) `code of words` {}- 12. {}\n", words(150), words(100), words(150));
        let page = wrap_page(&format!("{}\n1. {item}{item}", words(400)));
        assert_eq!(in_page(&page), [0_usize; 0]);
        assert!(page.lines().filter(|line| line.starts_with("  ")).count() >= 4, "{page}");
        assert!(page.contains("[a link of words](a.md)") && page.contains("`code of words`"), "{page}");
        assert!(!page.lines().any(|line| line.trim_start().starts_with("12.")), "no new list: {page}");
        let all = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(all(&page), all(&format!("{}\n1. {item}{item}", words(400))));
        assert_eq!(wrap_page(&page), page);
    }

    #[test]
    fn the_rest_of_a_line_joins_the_next_line_of_its_paragraph() {
        let wide = format!("{}tail of it", words(155));
        assert_eq!(wrap_page(&format!("{wide}\nnext line\n")), format!("{}tail\nof it next line\n", words(155)));
        for other in ["", "- item", "1. item", "| row |", "```", "# Heading", "    code"] {
            let page = format!("{wide}\n{other}\n");
            assert_eq!(wrap_page(&page), format!("{}tail\nof it\n{other}\n", words(155)));
        }
        let comment = wrap_rust(&format!("/// {}tail\n/// of it\nfn a() {{}}\n", words(135)));
        assert_eq!(comment, format!("/// {}\n/// tail of it\nfn a() {{}}\n", words(135).trim_end()));
    }

    #[test]
    fn a_wrapped_comment_keeps_its_slashes_and_its_indentation() {
        let source = wrap_rust(&format!("    /// - {}\nfn a() {{}}\n", words(200)));
        let lines: Vec<_> = source.lines().collect();
        assert!(lines[1].starts_with("    ///   word") && lines[2] == "fn a() {}", "{source}");
    }
}
