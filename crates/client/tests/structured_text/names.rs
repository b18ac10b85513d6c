//! No tool after IEC 61131-3 reserves a name in the function blocks.

use profivac_client::st::{Dialect, st};
use profivac_devices::catalog::MODELS;
use std::collections::BTreeSet;

/// The keywords of IEC 61131-3:2013 (edition 3): of the textual elements, the declarations, the configuration and structured text.
const KEYWORDS: &str = "
    ABSTRACT ACTION AND ANY ANY_BIT ANY_CHAR ANY_CHARS ANY_DATE ANY_DERIVED ANY_DURATION ANY_ELEMENTARY ANY_INT ANY_MAGNITUDE
    ANY_NUM ANY_REAL ANY_SIGNED ANY_STRING ANY_UNSIGNED ARRAY AT BY CASE CLASS CONFIGURATION CONSTANT CONTINUE DO ELSE ELSIF EN
    END_ACTION END_CASE END_CLASS END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_INTERFACE END_METHOD
    END_NAMESPACE END_PROGRAM END_REPEAT END_RESOURCE END_STEP END_STRUCT END_TRANSITION END_TYPE END_VAR END_WHILE ENO EXIT EXTENDS
    F_EDGE FALSE FINAL FOR FROM FUNCTION FUNCTION_BLOCK IF IMPLEMENTS INITIAL_STEP INTERFACE INTERNAL INTERVAL METHOD MOD NAMESPACE
    NON_RETAIN NOT NULL OF ON OR OVERLAP OVERRIDE PRIORITY PRIVATE PROGRAM PROTECTED PUBLIC R_EDGE READ_ONLY READ_WRITE REF REF_TO
    REPEAT RESOURCE RETAIN RETURN SINGLE STEP STRUCT SUPER TASK THEN THIS TO TRANSITION TRUE TYPE UNTIL USING VAR VAR_ACCESS
    VAR_CONFIG VAR_EXTERNAL VAR_GLOBAL VAR_IN_OUT VAR_INPUT VAR_OUTPUT VAR_TEMP WHILE WITH XOR";

/// The elementary data types, with their short names.
const TYPES: &str = "
    BOOL BYTE CHAR DATE DATE_AND_TIME DINT DT DWORD INT LDATE LDATE_AND_TIME LDT LINT LREAL LTIME LTIME_OF_DAY LTOD LWORD REAL SINT
    STRING TIME TIME_OF_DAY TOD UDINT UINT ULINT USINT WCHAR WORD WSTRING";

/// The standard functions, except conversions between types, which [`is_conversion`] knows.
const FUNCTIONS: &str = "
    ABS ACOS ADD ADD_DT_TIME ADD_LDT_LTIME ADD_LTIME ADD_LTOD_LTIME ADD_TIME ADD_TOD_TIME ASIN ATAN ATAN2 CONCAT CONCAT_DATE
    CONCAT_DATE_TOD CONCAT_DT CONCAT_LDATE CONCAT_LDATE_LTOD CONCAT_LDT CONCAT_LTOD CONCAT_TOD COS DAY_OF_WEEK DELETE DIV DIV_LTIME
    DIV_TIME DIVTIME EQ EXP EXPT FIND FROM_BIG_ENDIAN FROM_LITTLE_ENDIAN GE GT INSERT IS_VALID IS_VALID_BCD LE LEFT LEN LIMIT LN LOG
    LOWER_BOUND LT MAX MID MIN MOVE MUL MUL_LTIME MUL_TIME MULTIME MUX NE REPLACE RIGHT ROL ROR SEL SHL SHR SIN SPLIT_DATE SPLIT_DT
    SPLIT_LDATE SPLIT_LDT SPLIT_LTOD SPLIT_TOD SQRT SUB SUB_DATE_DATE SUB_DT_DT SUB_DT_TIME SUB_LDATE_LDATE SUB_LDT_LDT SUB_LDT_LTIME
    SUB_LTIME SUB_LTOD_LTIME SUB_LTOD_LTOD SUB_TIME SUB_TOD_TIME SUB_TOD_TOD TAN TO_BIG_ENDIAN TO_LITTLE_ENDIAN TRUNC UPPER_BOUND";

/// The standard function blocks, also those with a type in their name, and those that edition 2 had.
const FUNCTION_BLOCKS: &str = "
    CTD CTD_DINT CTD_LINT CTD_UDINT CTD_ULINT CTU CTU_DINT CTU_LINT CTU_UDINT CTU_ULINT CTUD CTUD_DINT CTUD_LINT CTUD_UDINT CTUD_ULINT
    F_TRIG R_TRIG RS RTC SEMA SR TOF TOF_LTIME TOF_TIME TON TON_LTIME TON_TIME TP TP_LTIME TP_TIME";

/// The operators of the instruction list, with the inputs of function blocks that are operators in edition 2, and the qualifiers of
/// actions in a sequential function chart.
const OPERATORS: &str = "
    ANDN CAL CALC CALCN CD CLK CU D DS IN JMP JMPC JMPCN L LD LDN N ORN P P0 P1 PT PV R R1 RET RETC RETCN S S1 SD SL ST STN XORN";

/// Names that tools reserve in addition. chosen: the union, so that every tool takes every file.
///
/// CODESYS and TwinCAT (their lists of keywords), then S7-SCL, then edition 4 of the standard as its drafts have it.
const TOOLS: &str = "
    ADR AND_THEN BIT BITADR END_PROPERTY END_UNION INDEXOF INI OR_ELSE PARAMS PERSISTENT POINTER PROPERTY REFERENCE SIZEOF
    UNION VAR_GENERIC VAR_INST VAR_STAT
    BEGIN CONST COUNTER DATA_BLOCK END_CONST END_DATA_BLOCK END_LABEL END_ORGANIZATION_BLOCK END_REGION GOTO LABEL NIL
    ORGANIZATION_BLOCK REGION S5TIME TIMER TITLE VARIANT VERSION VOID
    ASSERT UCHAR USTRING";

fn reserved() -> BTreeSet<&'static str> {
    let lists = [KEYWORDS, TYPES, FUNCTIONS, FUNCTION_BLOCKS, OPERATORS, TOOLS];
    lists.into_iter().flat_map(str::split_whitespace).collect()
}

/// Whether a name is that of a conversion: `INT_TO_REAL`, `TO_REAL`, `REAL_TRUNC_INT`, `TRUNC_INT`, `BCD_TO_UINT`.
fn is_conversion(name: &str) -> bool {
    let is_type = |word: &str| word == "BCD" || TYPES.split_whitespace().any(|one| one == word);
    ["TO_", "TRUNC_"].iter().any(|word| {
        name.match_indices(word).any(|(start, _)| {
            let (from, to) = (&name[..start], &name[start + word.len()..]);
            is_type(to) && (from.is_empty() || from.strip_suffix('_').is_some_and(is_type))
        })
    })
}

/// Whether every tool takes a name: it is an identifier, and neither the standard nor a tool uses it.
fn is_free(name: &str) -> bool {
    let upper = name.to_ascii_uppercase();
    let has_form = name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|character| character.is_ascii_alphanumeric() || character == '_')
        && !name.contains("__")
        && !name.ends_with('_');
    has_form && !reserved().contains(upper.as_str()) && !is_conversion(&upper)
}

/// The names that a file declares: its blocks and their variables.
fn declared(text: &str) -> BTreeSet<&str> {
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
        "1A",
        "A__B",
        "A_",
        "",
        "A B",
    ];
    for name in taken {
        assert!(!is_free(name), "{name}");
    }
    for name in ["TASK_CODE", "MY_TASK", "INT_TO_OCTETS", "TO_INTERVAL", "INTO_REALITY", "Q", "PV_BCG450_T7"] {
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
