//! Divides the text of a file into passages. A citation is within one passage.
//!
//! Comment lines that follow each other are one passage, and so are the lines of a paragraph in Markdown. A row of a
//! table and a line of code are separate passages; a string with a backslash at the end of a line is not cut.

/// A tracked file.
#[derive(Debug)]
pub struct Source {
    /// The path from the root of the repository.
    pub path: String,
    /// The whole text.
    pub text: String,
}

/// Text that belongs together.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Passage {
    /// The text without comment marks and backticks.
    pub text: String,
    /// Where in `text` each line begins, and its number in the file, from 1.
    lines: Vec<(usize, usize)>,
    /// Whether it is a comment or Markdown, not code.
    pub prose: bool,
    /// Whether it is in a test.
    pub test: bool,
}

impl Passage {
    /// The number of the line at a place in the text.
    pub fn line(&self, at: usize) -> usize {
        self.lines.iter().rev().find(|(begin, _)| *begin <= at).map_or(1, |(_, line)| *line)
    }

    fn add(&mut self, text: &str, line: usize) {
        if !self.text.is_empty() {
            self.text.push(' ');
        }
        self.lines.push((self.text.len(), line));
        self.text.extend(text.trim().chars().filter(|char| *char != '`'));
    }
}

impl Source {
    fn extension(&self) -> &str {
        self.path.rsplit_once('.').map_or("", |(_, extension)| extension)
    }

    /// Whether it is Markdown.
    pub fn is_markdown(&self) -> bool {
        self.extension() == "md"
    }

    /// Whether it is a program in Rust.
    pub fn is_rust(&self) -> bool {
        self.extension() == "rs"
    }

    /// Its passages.
    pub fn passages(&self) -> Vec<Passage> {
        let in_tests = self.path.split('/').any(|part| part == "tests" || part == "tests.rs");
        if self.is_markdown() {
            return markdown(&self.text);
        }
        let tests = if in_tests { vec![true; self.text.lines().count()] } else { test_modules(&self.text) };
        code(&self.text, &tests, marks(self.extension()))
    }
}

/// The comment marks of a language, the longest first.
fn marks(extension: &str) -> &'static [&'static str] {
    match extension {
        "rs" | "ts" | "tsx" | "mjs" | "js" => &["//!", "///", "//", "/**", "/*", "*/", "* "],
        "css" => &["/*", "*/", "* "],
        "lua" => &["--"],
        "html" => &["<!--"],
        _ => &["#"],
    }
}

/// Passages of a file in Markdown. Text between fences is code.
fn markdown(text: &str) -> Vec<Passage> {
    let mut builder = Builder::default();
    let mut fenced = false;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim_start();
        if line.starts_with("```") {
            fenced = !fenced;
            builder.end();
        } else if fenced {
            builder.alone(line, number, false);
        } else if line.is_empty() {
            builder.end();
        } else if line.starts_with(['|', '#', '<']) {
            builder.alone(line, number, true);
        } else {
            if begins_entry(line) {
                builder.end();
            }
            builder.go_on(line, number, true);
        }
    }
    builder.end();
    builder.passages
}

/// Whether a line begins an entry of a list.
fn begins_entry(line: &str) -> bool {
    let number = line.split_once(". ").is_some_and(|(number, _)| number.parse::<u32>().is_ok());
    number || line.starts_with("- ") || line.starts_with("* ")
}

/// Passages of code and its comments.
fn code(text: &str, tests: &[bool], marks: &[&str]) -> Vec<Passage> {
    let mut builder = Builder::default();
    for ((number, line), test) in (1..).zip(text.lines()).zip(tests) {
        builder.test(*test);
        let line = line.trim();
        match marks.iter().find_map(|mark| line.strip_prefix(mark)) {
            Some(comment) if comment.trim().is_empty() => builder.end(),
            Some(comment) if comment.trim_start().starts_with('|') => builder.alone(comment, number, true),
            Some(comment) => builder.go_on(comment, number, true),
            None => builder.code(line, number, marks),
        }
    }
    builder.end();
    builder.passages
}

/// Joins lines to passages.
#[derive(Default)]
struct Builder {
    passages: Vec<Passage>,
    open: Passage,
    test: bool,
}

impl Builder {
    fn end(&mut self) {
        let passage = std::mem::take(&mut self.open);
        if !passage.text.is_empty() {
            self.passages.push(passage);
        }
    }

    fn test(&mut self, test: bool) {
        if self.test != test {
            self.end();
        }
        self.test = test;
    }

    fn go_on(&mut self, text: &str, line: usize, prose: bool) {
        if self.open.prose != prose {
            self.end();
        }
        self.open.prose = prose;
        self.open.test = self.test;
        self.open.add(text, line);
    }

    fn alone(&mut self, text: &str, line: usize, prose: bool) {
        self.end();
        self.go_on(text, line, prose);
        self.end();
    }

    /// A line of code, and the comment after it.
    fn code(&mut self, line: &str, number: usize, marks: &[&str]) {
        let behind = marks.iter().find_map(|mark| line.split_once(&format!(" {mark} ")));
        let (code, comment) = behind.map_or((line, None), |(code, comment)| (code, Some(comment)));
        match code.strip_suffix('\\') {
            Some(unfinished) => self.go_on(unfinished, number, false),
            None => {
                self.go_on(code, number, false);
                self.end();
            }
        }
        if let Some(comment) = comment {
            self.alone(comment, number, true);
        }
    }
}

/// For each line of a Rust file, whether it is in a module for tests: from `#[cfg(test)]` to the brace in the same column, or
/// to `mod tests;`.
fn test_modules(text: &str) -> Vec<bool> {
    let mut end: Option<String> = None;
    let mark = |line: &str| {
        let indent = line.len() - line.trim_start().len();
        if end.is_none() && line.trim() == "#[cfg(test)]" {
            end = Some(format!("{}}}", " ".repeat(indent)));
        }
        let inside = end.is_some();
        if end.as_deref() == Some(line) || line.trim() == "mod tests;" {
            end = None;
        }
        inside
    };
    text.lines().map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passages(path: &str, text: &str) -> Vec<(String, bool, bool)> {
        let source = Source { path: path.to_owned(), text: text.to_owned() };
        source.passages().into_iter().map(|passage| (passage.text, passage.prose, passage.test)).collect()
    }

    fn prose(text: &str) -> (String, bool, bool) {
        (text.to_owned(), true, false)
    }

    fn code(text: &str) -> (String, bool, bool) {
        (text.to_owned(), false, false)
    }

    #[test]
    fn lines_of_a_comment_are_one_passage_and_an_empty_one_ends_it() {
        let text = "    /// One `a`,\n    /// two.\n    ///\n    /// Three.\n    let x = 1; // four\n    // five\n";
        let expected = [prose("One a, two."), prose("Three."), code("let x = 1;"), prose("four"), prose("five")];
        assert_eq!(passages("a.rs", text), expected);
    }

    #[test]
    fn rows_of_a_table_stand_alone() {
        assert_eq!(passages("a.rs", "//! | a |\n//! | b |\n"), [prose("| a |"), prose("| b |")]);
        assert_eq!(passages("a.md", "text\n| a |\n| b |\n"), [prose("text"), prose("| a |"), prose("| b |")]);
    }

    #[test]
    fn a_string_goes_on_behind_a_backslash() {
        assert_eq!(passages("a.rs", "x: \"1 to 3, \\\n    5\",\ny\n"), [code("x: \"1 to 3, 5\","), code("y")]);
    }

    #[test]
    fn paragraphs_entries_and_fences_of_markdown_are_told_apart() {
        let text = "One\ntwo.\n\n- three\n  four\n- five\n\n```\nsix\n```\n";
        assert_eq!(passages("a.md", text), [prose("One two."), prose("- three four"), prose("- five"), code("six")]);
    }

    #[test]
    fn other_languages_have_other_marks() {
        assert_eq!(passages("a.lua", "-- one\n-- two\nx\n"), [prose("one two"), code("x")]);
        assert_eq!(passages("a.toml", "# one\nx = 1\n"), [prose("one"), code("x = 1")]);
    }

    #[test]
    fn a_module_for_tests_and_a_folder_of_tests_are_tests() {
        let text = "// a\n#[cfg(test)]\nmod tests {\n    // b\n}\n// c\n";
        let tests = |path| -> Vec<(String, bool)> {
            let comments = passages(path, text).into_iter().filter(|(_, prose, _)| *prose);
            comments.map(|(text, _, test)| (text, test)).collect()
        };
        assert_eq!(tests("src/a.rs"), [("a".to_owned(), false), ("b".to_owned(), true), ("c".to_owned(), false)]);
        assert!(["tests/a/b.rs", "src/a/tests.rs"].iter().all(|path| tests(path).iter().all(|(_, test)| *test)));
        assert!(passages("src/a.rs", "#[cfg(test)]\nmod tests;\n// a\n").contains(&prose("a")));
    }

    #[test]
    fn a_place_in_a_passage_has_its_line() {
        let source = Source { path: "a.rs".to_owned(), text: "\n// one\n// two\n".to_owned() };
        let lines: Vec<usize> =
            source.passages().iter().flat_map(|passage| [passage.line(0), passage.line(4)]).collect();
        assert_eq!(lines, [2, 3]);
    }
}
