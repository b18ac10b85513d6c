//! The function blocks have only constructs that all implementations treat alike: docs/decisions/290-structured-text.md.
//!
//! The rules are about the text, so every file is held against them. Which types an expression mixes is a matter of the program that
//! executes the blocks (`executor.py`), which refuses `INT` with `DINT`.

use super::names::declared;
use profivac_client::st::{Dialect, st};
use profivac_devices::catalog::MODELS;
use std::collections::{BTreeMap, BTreeSet};

/// All words of the language in the blocks. Others are treated differently, or are in no need: `EXIT`, `REPEAT`, `XOR`, shifts, `EXPT`,
/// unsigned types, times, strings, structures, enumerations, references.
const LANGUAGE: &str = "
    FUNCTION_BLOCK END_FUNCTION_BLOCK VAR VAR_INPUT VAR_OUTPUT END_VAR ARRAY OF BOOL BYTE INT DINT REAL TRUE FALSE
    IF THEN ELSIF ELSE END_IF CASE END_CASE FOR TO DO END_FOR WHILE END_WHILE AND OR NOT MOD";

/// All functions. No conversion of a `REAL` to a whole number: tools round a half up, to even or towards zero.
const FUNCTIONS: [&str; 7] = ["ABS", "EXP", "BYTE_TO_INT", "INT_TO_BYTE", "INT_TO_REAL", "INT_TO_DINT", "DINT_TO_INT"];

const SIGNS: [&str; 17] = [":=", "<>", "<=", ">=", "..", "<", ">", "=", "+", "-", "*", "/", "(", ")", "[", "]", ","];

/// The text without its comments; an error for a comment in a comment, which some tools nest and others end.
fn without_comments(text: &str) -> Result<String, String> {
    let mut code = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("(*") {
        let (comment, after) = after.split_once("*)").ok_or("a comment without an end")?;
        if comment.contains("(*") {
            return Err(format!("a comment in a comment: {comment}"));
        }
        code += before;
        code.push(' ');
        rest = after;
    }
    Ok(code + rest)
}

/// Words, numbers and signs. A number takes all that follows it without a space: `16#FF`, `1_000`, `1.0E5`.
fn tokens(code: &str) -> Vec<String> {
    let characters: Vec<char> = code.chars().collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < characters.len() {
        let start = at;
        let first = characters[at];
        let next = characters.get(at + 1).copied().unwrap_or(' ');
        at += 1;
        if first.is_whitespace() {
            continue;
        }
        if first.is_ascii_alphabetic() || first == '_' {
            while characters.get(at).is_some_and(|one| one.is_ascii_alphanumeric() || *one == '_') {
                at += 1;
            }
        } else if first.is_ascii_digit() {
            while let Some(one) = characters.get(at).copied() {
                let follows = characters.get(at + 1).copied().unwrap_or(' ');
                let is_point = one == '.' && follows.is_ascii_digit();
                let is_sign = matches!(one, '+' | '-') && characters[at - 1] == 'E';
                if !(one.is_ascii_alphanumeric() || matches!(one, '_' | '#') || is_point || is_sign) {
                    break;
                }
                at += 1;
            }
        } else if SIGNS.contains(&format!("{first}{next}").as_str()) || (first, next) == ('*', '*') {
            at += 1;
        }
        tokens.push(characters[start..at].iter().collect());
    }
    tokens
}

/// Whether a number is written as all tools read it: decimal digits, or a real with a point and a signed exponent.
fn is_plain(number: &str) -> bool {
    let digits = |text: &str| !text.is_empty() && text.chars().all(|one| one.is_ascii_digit());
    let (mantissa, exponent) = number.split_once('E').unwrap_or((number, "+0"));
    let exponent = exponent.strip_prefix(['+', '-']);
    match mantissa.split_once('.') {
        Some((whole, part)) => digits(whole) && digits(part) && exponent.is_some_and(digits),
        None => digits(number),
    }
}

fn whole(token: &str) -> Option<u32> {
    token.parse().ok()
}

/// What a block has that implementations treat differently.
fn faults(block: &str) -> Vec<String> {
    let code = match without_comments(block) {
        Ok(code) => code,
        Err(fault) => return vec![fault],
    };
    let mut faults = Vec::new();
    if !block.is_ascii() {
        faults.push("a character that is not ASCII".to_owned());
    }
    let tokens = tokens(&code);
    let at = |index: usize| tokens.get(index).map_or("", String::as_str);
    let names = declared(block);
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut inputs = BTreeSet::new();
    let mut section = "";
    // The variables of the loops that are open.
    let mut loops: Vec<&str> = Vec::new();
    for (index, token) in tokens.iter().enumerate() {
        let token = token.as_str();
        let (previous, next) = (if index == 0 { "" } else { at(index - 1) }, at(index + 1));
        let mut fault = |text: &str| faults.push(format!("{text}: {previous} {token} {next} {}", at(index + 2)));
        let first = token.chars().next().unwrap_or_default();
        if first.is_ascii_alphabetic() {
            let is_function = FUNCTIONS.contains(&token);
            if !is_function && !names.contains(token) && !LANGUAGE.split_whitespace().any(|word| word == token) {
                fault("a word that not all tools know");
            }
            if is_function && next != "(" {
                fault("a function without an argument");
            }
        } else if first.is_ascii_digit() {
            if !is_plain(token) {
                fault("a literal that not all tools read");
            }
        } else if ![";", ":"].contains(&token) && !SIGNS.contains(&token) {
            fault("a sign that not all tools know");
        }
        match token {
            "VAR" | "VAR_INPUT" | "VAR_OUTPUT" => section = token,
            "END_VAR" => section = "",
            ":" if !section.is_empty() => {
                *counts.entry(previous.to_ascii_uppercase()).or_default() += 1;
                if section == "VAR_INPUT" {
                    inputs.insert(previous);
                }
                let end = tokens[index..].iter().position(|one| one == ";").unwrap_or_default();
                let declaration = &tokens[index..index + end];
                if next == "ARRAY" && declaration.iter().any(|one| one == ":=") {
                    fault("an array with initial values");
                }
            }
            ":=" if section.is_empty() && inputs.contains(previous) => fault("an input is assigned"),
            ":=" if at(index.saturating_sub(2)) != "FOR" && loops.contains(&previous) => {
                fault("the variable of a loop is assigned in it");
            }
            "FOR" => {
                let bounds = (whole(at(index + 3)), at(index + 4), whole(at(index + 5)), at(index + 6));
                if !matches!(bounds, (Some(low), "TO", Some(high), "DO") if low < high) {
                    fault("a FOR whose start is not a number below its end");
                }
                if loops.contains(&next) {
                    fault("two loops with one variable");
                }
                loops.push(next);
            }
            "END_FOR" => {
                loops.pop();
            }
            "(" if FUNCTIONS.contains(&previous) => {
                let mut depth = 0_usize;
                let argument: Vec<&str> = tokens[index..]
                    .iter()
                    .map(String::as_str)
                    .take_while(|one| {
                        match *one {
                            "(" => depth += 1,
                            ")" => depth -= 1,
                            _ => {}
                        }
                        depth > 0
                    })
                    .skip(1)
                    .collect();
                if argument.contains(&"[") {
                    fault("an element of an array as an argument");
                }
                if argument.contains(&",") {
                    fault("a function of two arguments");
                }
                if argument.first().is_some_and(|one| *one != "(") {
                    fault("an argument that begins with a name: iec61131 reads the name of a parameter");
                }
                let mut parts = argument.iter().filter(|one| !["(", ")"].contains(*one));
                if parts.all(|one| one.starts_with(|first: char| first.is_ascii_digit() || first == '-')) {
                    fault("a literal as an argument, which has no type");
                }
            }
            "/" | "MOD" if !next.starts_with(|first: char| ('1'..='9').contains(&first)) => {
                fault("a divisor that is not a number above 0");
            }
            ".." if section.is_empty() => fault("a range of cases"),
            "," if section.is_empty() && whole(previous).is_none() => fault("a list of something else than numbers"),
            "THEN" | "ELSE" | "DO" | "OF" if section.is_empty() => {
                let is_end = next.starts_with("END_") || ["ELSE", "ELSIF"].contains(&next);
                if is_end {
                    fault("no statement");
                }
            }
            ":" if section.is_empty() => {
                let is_end = next.starts_with("END_") || next == "ELSE" || whole(next).is_some();
                if is_end {
                    fault("a case without a statement");
                }
                if whole(previous).is_none() {
                    fault("a case of something else than a number");
                }
            }
            _ => {}
        }
    }
    faults.extend(counts.iter().filter(|(_, count)| **count > 1).map(|(name, _)| format!("{name} is declared twice")));
    faults
}

/// The blocks of a file, each with the heads of the standard dialect.
fn blocks(text: &str) -> Vec<String> {
    let standard = text.replace("\"\nVERSION : 0.1\n", "\n").replace("FUNCTION_BLOCK \"", "FUNCTION_BLOCK ");
    let standard = standard.replace("\nBEGIN\n", "\n\n");
    let blocks = standard.split_inclusive("END_FUNCTION_BLOCK\n").filter(|block| block.contains("END_FUNCTION_BLOCK"));
    blocks.map(str::to_owned).collect()
}

#[test]
fn no_function_block_has_a_construct_that_implementations_treat_differently() {
    for model in MODELS {
        for dialect in [Dialect::Standard, Dialect::Tia] {
            let blocks = blocks(&st(model, dialect));
            assert!(blocks.len() > 3, "{}", model.name);
            for block in blocks {
                let name =
                    declared(&block).into_iter().find(|name| name.starts_with("PV_")).unwrap_or_default().to_owned();
                assert_eq!(faults(&block), Vec::<String>::new(), "{name} ({dialect:?})");
            }
        }
    }
}

/// A block with these statements.
fn with(statements: &str) -> String {
    format!(
        "FUNCTION_BLOCK PV_A\n(* A comment. *)\nVAR_INPUT\n    OCTETS : ARRAY[0..7] OF BYTE;\n    UNIT : INT := -1;\nEND_VAR\nVAR\n    \
         RAW : BYTE;\n    A : INT;\n    B : INT;\n    C : ARRAY[1..2] OF REAL;\n    Y : REAL;\nEND_VAR\n\n{statements}\nEND_FUNCTION_BLOCK\n"
    )
}

#[test]
fn constructs_that_all_implementations_treat_alike_are_no_faults() {
    for statements in [
        "A := 1;",
        "RAW := OCTETS[A + 1];\nB := BYTE_TO_INT((RAW)) / 16;",
        "B := DINT_TO_INT((B / 256) MOD 256);",
        "FOR A := 0 TO 3 DO\n    C[A] := 1.5E-3;\nEND_FOR;",
        "CASE UNIT OF\n    0, 1: A := 1; (* mbar *)\n    2:\n        B := 2;\nELSE\n    A := -3;\nEND_CASE;",
        "WHILE (A < 3) AND NOT (B = 2) DO\n    A := A + 1;\nEND_WHILE;",
        "IF A MOD 2 = 1 THEN\n    Y := EXP((Y / 482.0 - 2.778) * 2.302585093);\nELSIF B <> 0 THEN\n    Y := 0.0;\nEND_IF;",
    ] {
        assert_eq!(faults(&with(statements)), Vec::<String>::new(), "{statements}");
    }
}

#[test]
fn each_construct_that_implementations_treat_differently_is_a_fault() {
    for (statements, expected) in [
        ("FOR A := 3 TO 3 DO B := 1; END_FOR;", "a FOR whose start"),
        ("FOR A := 3 TO 1 DO B := 1; END_FOR;", "a FOR whose start"),
        ("FOR A := 4 - B TO 3 DO B := 1; END_FOR;", "a FOR whose start"),
        ("FOR A := 0 TO 3 BY 1 DO B := 1; END_FOR;", "a FOR whose start"),
        ("FOR A := 0 TO 3 DO A := 1; END_FOR;", "the variable of a loop"),
        ("FOR A := 0 TO 3 DO FOR A := 0 TO 1 DO B := 1; END_FOR; END_FOR;", "two loops"),
        ("FOR A := 0 TO 3 DO EXIT; END_FOR;", "a word"),
        ("REPEAT A := 1; UNTIL TRUE END_REPEAT;", "a word"),
        ("A := REAL_TO_INT(Y);", "a word"),
        ("A := TRUNC(Y);", "a word"),
        ("A := SHL(A, 2);", "a word"),
        ("A := A XOR B;", "a word"),
        ("A := TIME_TO_INT(B);", "a word"),
        ("B := BYTE_TO_INT(OCTETS[1]);", "an element of an array"),
        ("B := BYTE_TO_INT(OCTETS[A + 1]) / 2;", "an element of an array"),
        ("B := BYTE_TO_INT((OCTETS[1]));", "an element of an array"),
        ("B := BYTE_TO_INT(RAW);", "an argument that begins with a name"),
        ("Y := INT_TO_REAL(A MOD 16);", "an argument that begins with a name"),
        ("Y := EXP(Y, 2.0);", "a function of two arguments"),
        ("RAW := INT_TO_BYTE(0);", "a literal as an argument"),
        ("RAW := INT_TO_BYTE((0));", "a literal as an argument"),
        ("A := 16#FF;", "a literal that"),
        ("A := INT#1;", "a sign"),
        ("A := 1_000;", "a literal that"),
        ("Y := 1E5;", "a literal that"),
        ("Y := 1.0E5;", "a literal that"),
        ("Y := Y ** 2.0;", "a sign"),
        ("A := A & B;", "a sign"),
        ("A := T#1s;", "a word"),
        ("A := OCTETS[1].0;", "a sign"),
        ("A := %IW1;", "a sign"),
        ("A := 'x';", "a sign"),
        ("A := B / A;", "a divisor"),
        ("A := B MOD A;", "a divisor"),
        ("A := B / 0;", "a divisor"),
        ("CASE A OF 1..3: B := 1; END_CASE;", "a range"),
        ("CASE A OF B: A := 1; END_CASE;", "a case of something else"),
        ("CASE A OF 1: 2: B := 1; END_CASE;", "a case without a statement"),
        ("CASE A OF ELSE B := 1; END_CASE;", "no statement"),
        ("IF A = 1 THEN END_IF;", "no statement"),
        ("UNIT := 1;", "an input is assigned"),
        ("(* a (* b *) c *)", "a comment in a comment"),
        ("(* \u{b5}bar *)", "a character"),
    ] {
        let found = faults(&with(statements));
        assert!(found.iter().any(|fault| fault.starts_with(expected)), "{statements}: {found:?}");
    }
    let twice = with("A := 1;").replace("    RAW :", "    b : INT;\n    RAW :");
    assert!(faults(&twice).contains(&"B is declared twice".to_owned()), "{:?}", faults(&twice));
    let array = with("A := 1;").replace("OF REAL;", "OF REAL := [1.0, 2.0];");
    assert!(faults(&array).iter().any(|fault| fault.starts_with("an array with initial")), "{:?}", faults(&array));
}
