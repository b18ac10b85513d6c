//! The text of function blocks, with its indentation.

use super::Dialect;
use std::fmt::Display;

/// Structured text that grows line by line.
pub(super) struct Source {
    pub text: String,
    dialect: Dialect,
    depth: usize,
}

impl Source {
    pub const fn new(dialect: Dialect) -> Self {
        Self { text: String::new(), dialect, depth: 0 }
    }

    /// One line at the present depth.
    pub fn line(&mut self, line: &str) {
        if !line.is_empty() {
            self.text.push_str(&"    ".repeat(self.depth));
            self.text.push_str(line);
        }
        self.text.push('\n');
    }

    /// Several lines, which keep their own indentation.
    pub fn lines(&mut self, lines: &str) {
        for line in lines.lines() {
            self.line(line);
        }
    }

    /// A line that opens a statement or a list of variables.
    pub fn open(&mut self, line: &str) {
        self.line(line);
        self.depth = self.depth.saturating_add(1);
    }

    /// Its end.
    pub fn close(&mut self, line: &str) {
        self.depth = self.depth.saturating_sub(1);
        self.line(line);
    }

    /// A branch of an `IF` or `CASE`: closes the one before.
    pub fn branch(&mut self, line: &str) {
        self.depth = self.depth.saturating_sub(1);
        self.open(line);
    }

    /// Variables: `VAR_INPUT` ... `END_VAR`.
    pub fn variables(&mut self, kind: &str, lines: &str) {
        self.open(kind);
        self.lines(lines);
        self.close("END_VAR");
    }

    /// The head of a block.
    pub fn begin_block(&mut self, name: &str) {
        self.line("");
        match self.dialect {
            Dialect::Standard => self.line(&format!("FUNCTION_BLOCK {name}")),
            Dialect::Tia => self.lines(&format!("FUNCTION_BLOCK \"{name}\"\nVERSION : 0.1")),
        }
    }

    /// The boundary between the variables and the statements.
    pub fn begin_statements(&mut self) {
        match self.dialect {
            Dialect::Standard => self.line(""),
            Dialect::Tia => self.line("BEGIN"),
        }
    }

    /// The end of a block.
    pub fn end_block(&mut self) {
        self.line("END_FUNCTION_BLOCK");
    }
}

/// The condition that this bit of a whole number is set. Not by `AND`, which tools define differently for numbers.
pub(super) fn bit(variable: &str, mask: u8) -> String {
    match mask {
        1 => format!("{variable} MOD 2 = 1"),
        mask => format!("({variable} / {mask}) MOD 2 = 1"),
    }
}

/// The statements that take an octet of the inputs as a whole number. `RAW` is a variable because tools differ about an element of an array
/// as the argument of a conversion. It has parentheses, as every argument that begins with a name: iec61131 would read the name of a
/// parameter.
pub(super) fn octet(variable: &str, place: impl Display) -> String {
    format!("RAW := OCTETS[{place}];\n{variable} := BYTE_TO_INT((RAW));")
}

/// A real literal, with the digits of a 32-bit float.
pub(super) fn real(number: f64) -> String {
    let text = format!("{number:.8E}");
    let (digits, power) = text.split_once('E').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0');
    let digits = if digits.ends_with('.') { format!("{digits}0") } else { digits.to_owned() };
    let power = if power.starts_with('-') { power.to_owned() } else { format!("+{power}") };
    format!("{digits}E{power}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_real_literal_has_a_point_and_a_signed_exponent() {
        assert_eq!(real(100.0), "1.0E+2");
        assert_eq!(real(0.002), "2.0E-3");
        assert_eq!(real(100.0 / 0.750_061_68), "1.33322369E+2");
    }

    #[test]
    fn a_bit_is_tested_by_division() {
        assert_eq!((bit("A", 1), bit("A", 32)), ("A MOD 2 = 1".into(), "(A / 32) MOD 2 = 1".into()));
    }
}
