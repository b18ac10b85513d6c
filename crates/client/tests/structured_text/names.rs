//! No tool after IEC 61131-3 reserves a name in the function blocks.
//!
//! Clauses and tables are those of IEC 61131-3:2013, edition 3, by its published contents and the compliance statements of vendors: the text
//! itself was not at hand. Edition 4 (2025) keeps these names, but drops the instruction list and the untyped `TRUNC`; [`EDITION_4`] has
//! its additions.

use profivac_client::st::{Dialect, st};
use profivac_devices::catalog::MODELS;
use std::collections::BTreeSet;

/// Names, and where they are reserved. A name may be in several lists.
type List = (&'static str, &'static str);

/// The keywords (6.1.3), by the clause that uses them.
const KEYWORDS: &[List] = &[
    ("6.4.4, Tables 11 and 12: types of the user, references", "ARRAY END_STRUCT END_TYPE OF OVERLAP REF REF_TO STRUCT TYPE NULL"),
    (
        "6.5, Tables 13 to 17: variables",
        "AT CONSTANT END_VAR F_EDGE NON_RETAIN R_EDGE READ_ONLY READ_WRITE RETAIN VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL VAR_GLOBAL
        VAR_IN_OUT VAR_INPUT VAR_OUTPUT VAR_TEMP",
    ),
    ("6.6.1, Table 18: execution control", "EN ENO"),
    ("6.6.2, Table 19: functions", "END_FUNCTION FUNCTION"),
    ("6.6.3, Table 40: function blocks", "END_FUNCTION_BLOCK FUNCTION_BLOCK"),
    ("6.6.4, Table 47: programs", "END_PROGRAM PROGRAM"),
    (
        "6.6.5 to 6.6.7, Tables 48 to 53: classes, interfaces, function blocks with methods",
        "ABSTRACT CLASS END_CLASS END_INTERFACE END_METHOD EXTENDS FINAL IMPLEMENTS INTERFACE INTERNAL METHOD OVERRIDE PRIVATE PROTECTED
        PUBLIC SUPER THIS",
    ),
    (
        "6.7, Tables 54 to 61: sequential function chart",
        "ACTION END_ACTION END_STEP END_TRANSITION FROM INITIAL_STEP STEP TO TRANSITION",
    ),
    (
        "6.8, Tables 62 and 63: configuration",
        "CONFIGURATION END_CONFIGURATION END_RESOURCE INTERVAL ON PRIORITY RESOURCE SINGLE TASK WITH",
    ),
    ("6.9, Tables 64 to 66: namespaces", "END_NAMESPACE NAMESPACE USING"),
    ("6.3.2, Table 5: literals", "FALSE TRUE"),
    ("7.3.2, Table 71: operators of structured text", "AND MOD NOT OR XOR"),
    (
        "7.3.3, Table 72: statements of structured text",
        "BY CASE CONTINUE DO ELSE ELSIF END_CASE END_FOR END_IF END_REPEAT END_WHILE EXIT FOR IF OF REPEAT RETURN THEN TO UNTIL WHILE",
    ),
];

/// The data types.
const TYPES: &[List] = &[
    (
        "6.4.2, Table 10: elementary data types",
        "BOOL BYTE CHAR DATE DATE_AND_TIME DINT DT DWORD INT LDATE LDATE_AND_TIME LDT LINT LREAL LTIME LTIME_OF_DAY LTOD LWORD REAL SINT
        STRING TIME TIME_OF_DAY TOD UDINT UINT ULINT USINT WCHAR WORD WSTRING",
    ),
    // ANY_BITS, ANY_STRINGS and ANY_DATES are spellings of edition 3 and of tools.
    (
        "6.4.3, Figure 5: generic data types",
        "ANY ANY_BIT ANY_BITS ANY_CHAR ANY_CHARS ANY_DATE ANY_DATES ANY_DERIVED ANY_DURATION ANY_ELEMENTARY ANY_INT ANY_MAGNITUDE ANY_NUM
        ANY_REAL ANY_SIGNED ANY_STRING ANY_STRINGS ANY_UNSIGNED",
    ),
];

/// The standard functions, except conversions between types (Tables 22 to 27), which [`is_conversion`] knows.
const FUNCTIONS: &[List] = &[
    ("6.6.2.5, Table 28: of one number", "ABS ACOS ASIN ATAN ATAN2 COS EXP LN LOG SIN SQRT TAN"),
    ("6.6.2.5, Table 29: arithmetic", "ADD DIV EXPT MOD MOVE MUL SUB"),
    ("6.6.2.5, Table 30: shift", "ROL ROR SHL SHR"),
    ("6.6.2.5, Table 31: bitwise", "AND NOT OR XOR"),
    ("6.6.2.5, Table 32: selection", "LIMIT MAX MIN MOVE MUX SEL"),
    ("6.6.2.5, Table 33: comparison", "EQ GE GT LE LT NE"),
    ("6.6.2.5, Table 34: character strings", "CONCAT DELETE FIND INSERT LEFT LEN MID REPLACE RIGHT"),
    (
        "6.6.2.5, Table 35: time and duration",
        "ADD_DT_TIME ADD_LDT_LTIME ADD_LTIME ADD_LTOD_LTIME ADD_TIME ADD_TOD_TIME DIV_LTIME DIV_TIME DIVTIME MUL_LTIME MUL_TIME MULTIME
        SUB_DATE_DATE SUB_DT_DT SUB_DT_TIME SUB_LDATE_LDATE SUB_LDT_LDT SUB_LDT_LTIME SUB_LTIME SUB_LTOD_LTIME SUB_LTOD_LTOD SUB_TIME
        SUB_TOD_TIME SUB_TOD_TOD",
    ),
    (
        "6.6.2.5, Table 36: CONCAT and SPLIT of time",
        "CONCAT_DATE CONCAT_DATE_LTOD CONCAT_DATE_TOD CONCAT_DT CONCAT_LDATE CONCAT_LDATE_LTOD CONCAT_LDATE_TOD CONCAT_LDT CONCAT_LTOD
        CONCAT_TOD DAY_OF_WEEK SPLIT_DATE SPLIT_DT SPLIT_LDATE SPLIT_LDT SPLIT_LTOD SPLIT_TOD",
    ),
    (
        "6.6.2.5, Table 37: endianness",
        "BIG_ENDIAN_TO FROM_BIG_ENDIAN FROM_LITTLE_ENDIAN LITTLE_ENDIAN_TO TO_BIG_ENDIAN TO_LITTLE_ENDIAN",
    ),
    ("6.6.2.5, Table 38: enumerations", "EQ MUX NE SEL"),
    ("6.6.2.5, Table 39: validation", "IS_VALID IS_VALID_BCD"),
    ("6.5, Table 15: bounds of arrays", "LOWER_BOUND UPPER_BOUND"),
    ("6.6.2.5, Table 22: conversion", "TRUNC"),
];

/// The standard function blocks, also those with a type in their name; RTC and SEMA are of edition 2.
const FUNCTION_BLOCKS: &[List] = &[
    ("6.6.3.5, Table 43: bistable", "RS SR"),
    ("6.6.3.5, Table 44: edge detection", "F_TRIG R_TRIG"),
    (
        "6.6.3.5, Table 45: counters",
        "CTD CTD_DINT CTD_LINT CTD_UDINT CTD_ULINT CTU CTU_DINT CTU_LINT CTU_UDINT CTU_ULINT CTUD CTUD_DINT CTUD_LINT CTUD_UDINT CTUD_ULINT",
    ),
    ("6.6.3.5, Table 46: timers", "TOF TOF_LTIME TOF_TIME TON TON_LTIME TON_TIME TP TP_LTIME TP_TIME"),
    ("IEC 61131-3:2003 2.5.2.3", "RTC SEMA"),
];

/// The instruction list, with the inputs of function blocks that are operators in edition 2, and the qualifiers of actions.
const OPERATORS: &[List] = &[
    (
        "7.2, Tables 67 to 70: instruction list",
        "ADD AND ANDN CAL CALC CALCN CD CLK CU DIV EQ GE GT IN JMP JMPC JMPCN LD LDN LE LT MOD MUL NE NOT OR ORN PT PV R R1 RET RETC RETCN S
        S1 ST STN SUB XOR XORN",
    ),
    ("6.7.4, Table 59: qualifiers of actions", "D DS L N P P0 P1 R S SD SL"),
];

/// The additions of IEC 61131-3:2025.
// chosen: from published comparisons of the editions, because the text was not at hand. They do not name the parts of mutual exclusion:
// these are the usual names.
const EDITION_4: &[List] = &[
    ("6.4.2: strings in UTF-8", "UCHAR USTRING"),
    ("6.6.5: properties", "END_GET END_PROPERTY END_SET GET PROPERTY PROPERTY_GET PROPERTY_SET SET"),
    ("6.6.2: assertion and conversion", "ASSERT TRUNC_DINT TRUNC_INT TRUNC_LINT TRUNC_SINT"),
    ("6.6.2: strings", "LEN_CODE_UNIT LEN_MAX"),
    ("6.9: mutual exclusion", "ACQUIRE LOCK MUTEX RELEASE SEMA SEMAPHORE TRY_ACQUIRE TRY_LOCK UNLOCK"),
];

/// Names that tools reserve in addition. chosen: the union, so that every tool takes every file.
const TOOLS: &[List] = &[
    (
        "CODESYS, Development System, Keywords and Operators",
        "ADR AND_THEN BIT BITADR CONTINUE END_UNION INDEXOF INI LIMIT OR_ELSE PARAMS PERSISTENT POINTER REFERENCE SIZEOF TEST_AND_SET UNION
        VAR_GENERIC VAR_INST VAR_STAT XSIZEOF",
    ),
    ("CODESYS, compiler error C0543", "ANY_CHARS CHAR_TO CLASS TO_CHAR TO_WCHAR USING WCHAR_TO"),
    ("CODESYS, export format", "ACTION END_ACTION END_FUNCTION END_FUNCTION_BLOCK END_PROGRAM FUNCTIONBLOCK END_FUNCTIONBLOCK"),
    (
        "TwinCAT 3, PLC, Keywords",
        "ADR ANDN BITADR CALC HRESULT INDEXOF JMPC PARAMS PERSISTENT POINTER PVOID RETCN SIZEOF UXINT VAR_STAT XINT XWORD",
    ),
    (
        "S7-SCL, reserved words",
        "BEGIN BLOCK_DB BLOCK_FB BLOCK_FC BLOCK_SDB BLOCK_SFB BLOCK_SFC CONST COUNTER DATA_BLOCK END_CONST END_DATA_BLOCK END_LABEL
        END_ORGANIZATION_BLOCK GOTO LABEL NIL OK ORGANIZATION_BLOCK POINTER S5TIME TIMER TITLE VOID",
    ),
    (
        "TIA Portal, SCL: declarations, structures, functions",
        "ANY AUTHOR CEIL DB_ANY END_REGION EXPD FAMILY FLOOR FRAC KNOW_HOW_PROTECT NAME NETWORK NORM_X PEEK POKE REGION ROUND SCALE_X SQR SWAP
        UNLINKED VARIANT VERSION",
    ),
];

fn words(lists: &[List]) -> impl Iterator<Item = &'static str> {
    lists.iter().flat_map(|&(_, names)| names.split_whitespace())
}

fn reserved() -> BTreeSet<&'static str> {
    let lists = [KEYWORDS, TYPES, FUNCTIONS, FUNCTION_BLOCKS, OPERATORS, EDITION_4, TOOLS];
    lists.into_iter().flat_map(words).collect()
}

/// Whether a name is that of a conversion (6.6.2.5, Tables 22 to 27): `INT_TO_REAL`, `TO_REAL`, `REAL_TRUNC_INT`, `TRUNC_INT`, `BCD_TO_UINT`.
fn is_conversion(name: &str) -> bool {
    let is_type = |word: &str| matches!(word, "BCD" | "UCHAR" | "USTRING") || words(TYPES).any(|one| one == word);
    ["TO_BCD_", "TO_", "TRUNC_", "ROUND_"].iter().any(|word| {
        name.match_indices(word).any(|(start, _)| {
            let (from, to) = (&name[..start], &name[start + word.len()..]);
            is_type(to) && (from.is_empty() || from.strip_suffix('_').is_some_and(is_type))
        })
    })
}

/// Whether a name is an address of a Siemens controller, in English or German: `Q`, `MB10`, `EW`, `DB5`, `T3`.
fn is_address(name: &str) -> bool {
    let letters = name.trim_end_matches(|last: char| last.is_ascii_digit());
    let has_number = letters.len() < name.len();
    let areas = ["I", "Q", "M", "L", "E", "A", "PI", "PQ", "PE", "PA", "DB", "DI"];
    let is_area = |text: &str| areas.contains(&text);
    let is_sized = |text: &str| ["B", "W", "D", "X"].iter().any(|size| text.strip_suffix(*size).is_some_and(is_area));
    let is_object = |text: &str| ["T", "C", "Z", "OB", "FB", "FC", "SFB", "SFC", "SDB", "UDT"].contains(&text);
    is_area(letters) || is_sized(letters) || (has_number && is_object(letters))
}

/// Whether every tool takes a name: it is an identifier (6.1.2), and neither the standard nor a tool uses it.
fn is_free(name: &str) -> bool {
    let upper = name.to_ascii_uppercase();
    let has_form = name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|character| character.is_ascii_alphanumeric() || character == '_')
        && !name.contains("__")
        && !name.ends_with('_')
        && name.len() <= 32;
    has_form && !reserved().contains(upper.as_str()) && !is_conversion(&upper) && !is_address(&upper)
}

/// The names that a file declares: its blocks and their variables.
pub(super) fn declared(text: &str) -> BTreeSet<&str> {
    let mut names = BTreeSet::new();
    let mut is_variable = false;
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix("FUNCTION_BLOCK ") {
            names.insert(name.trim_matches('"'));
        }
        let first = line.split([' ', ';']).next().unwrap_or_default();
        // `VAR CONSTANT` and `VAR_TEMP` begin declarations too.
        if first == "VAR" || first.starts_with("VAR_") {
            is_variable = true;
        } else if first == "END_VAR" {
            is_variable = false;
        } else if is_variable {
            let (variables, _) = line.split_once(':').unwrap();
            names.extend(variables.split(',').map(str::trim));
        }
    }
    names
}

/// The variables that the statements of a file assign.
fn assigned(text: &str) -> BTreeSet<&str> {
    let targets = text.lines().filter_map(|line| line.split_once(" := ")).map(|(target, _)| target);
    let targets =
        targets.filter(|target| !target.contains(" : ")).map(|target| target.rsplit([' ', ':']).next().unwrap());
    targets.map(|target| target.split('[').next().unwrap()).filter(|name| !name.contains(']')).collect()
}

#[test]
fn no_name_in_a_function_block_is_reserved_by_the_standard_or_by_a_tool() {
    for model in MODELS {
        for dialect in [Dialect::Standard, Dialect::Tia] {
            let text = st(model, dialect);
            let names = declared(&text);
            let taken: Vec<_> = names.iter().filter(|name| !is_free(name)).collect();
            assert_eq!(taken, Vec::<&&str>::new(), "{}", model.name);
            let assigned = assigned(&text);
            assert!(assigned.len() > 10, "{}: {assigned:?}", model.name);
            let missed: Vec<_> = assigned.difference(&names).copied().collect();
            assert_eq!(missed, Vec::<&str>::new(), "{}: the test has not found their declarations", model.name);
        }
    }
}

#[test]
fn a_reserved_name_is_known_in_any_case_and_a_name_that_only_contains_one_is_free() {
    let taken = [
        "TASK",
        "task",
        "Task",
        "End_Function_Block",
        "overlap",
        "LTOD",
        "Limit",
        "ctud_ulint",
        "sema",
        "st",
        "int_to_real",
        "REAL_TRUNC_DINT",
        "to_lreal",
        "TIME_OF_DAY_TO_LTOD",
        "BCD_TO_UINT",
        "eno",
        "ref_to",
        "clk",
        "PV",
        "r1",
        "adr",
        "Union",
        "AND_THEN",
        "begin",
        "Version",
        "ASSERT",
        "ustring",
        "Mutex",
        "any_magnitude",
        "Test_And_Set",
        "s5time",
        "q",
        "MB10",
        "db5",
        "Pew",
        "t3",
        "1A",
        "A__B",
        "A_",
        "",
        "A B",
        "A_NAME_OF_MORE_THAN_32_CHARACTERS",
    ];
    for name in taken {
        assert!(!is_free(name), "{name}");
    }
    for name in
        ["TASK_CODE", "MY_TASK", "INT_TO_OCTETS", "TO_INTERVAL", "INTO_REALITY", "QUALITY", "B0", "PV_BCG450_T7"]
    {
        assert!(is_free(name), "{name}");
    }
}

#[test]
fn the_names_of_every_kind_of_variable_are_found() {
    let kinds =
        ["VAR", "VAR CONSTANT", "VAR_INPUT", "VAR_OUTPUT RETAIN", "VAR_IN_OUT", "VAR_TEMP", "VAR_STAT", "VAR_EXTERNAL"];
    for kind in kinds {
        let text = format!("FUNCTION_BLOCK BLOCK\n  {kind}\n    FIRST, SECOND : INT;\n  END_VAR\n  OTHER := 1;\n");
        assert_eq!(declared(&text), BTreeSet::from(["BLOCK", "FIRST", "SECOND"]), "{kind}");
    }
}
