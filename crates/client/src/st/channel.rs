//! The block for the parameter channel.

use super::channel_name;
use super::source::Source;
use profivac_devices::model::{AccessError, ChannelRules, Model, TaskKind};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Writes the block.
pub(super) fn write(source: &mut Source, model: &Model) {
    source.begin_block(&channel_name(model));
    source.lines(HEAD);
    for (code, texts) in error_codes(model.channel_rules) {
        source.line(&format!("   {code:<8} {texts}"));
    }
    source.line("   Other codes: see the manual. *)");
    source.variables("VAR_INPUT", INPUTS);
    source.variables("VAR_OUTPUT", OUTPUTS);
    source.variables("VAR", OWN);
    source.begin_statements();
    source.lines(&STATEMENTS.replace("{TASKS}\n", &tasks(model.channel_rules)));
    source.end_block();
}

/// The error codes of the device, each with its meanings.
fn error_codes(rules: &ChannelRules) -> BTreeMap<u8, String> {
    const ERRORS: [AccessError; 12] = [
        AccessError::UnknownSlot,
        AccessError::UnknownIndex,
        AccessError::NotReadable,
        AccessError::NotWritable,
        AccessError::NotInChannel,
        AccessError::WrongLength,
        AccessError::WrongMode,
        AccessError::AlreadyInState,
        AccessError::StateConflict,
        AccessError::OutOfRange,
        AccessError::StorageFailed,
        AccessError::UnknownTask,
    ];
    let mut codes: BTreeMap<u8, String> = BTreeMap::new();
    for error in ERRORS {
        let texts = codes.entry(rules.error_code(error)).or_default();
        let separator = if texts.is_empty() { "" } else { "; " };
        // Writing to a string cannot fail.
        let _ = write!(texts, "{separator}{error}");
    }
    codes
}

/// The choice of the task for a write of each length. A device without a task that writes has no choice: a `CASE` needs a value.
fn tasks(rules: &ChannelRules) -> String {
    let mut tasks = String::new();
    for length in [1, 2, 4] {
        let own = rules.tasks.iter().find(|(_, kind)| match kind {
            TaskKind::Read => false,
            TaskKind::Write(lengths) => lengths.contains(&length),
        });
        if let Some((ak, _)) = own {
            let _ = writeln!(tasks, "            {length}: TASK_CODE := {ak};");
        }
    }
    if tasks.is_empty() {
        return tasks;
    }
    format!("        CASE LENGTH OF\n{tasks}        ELSE\n            TASK_CODE := 0;\n        END_CASE;\n")
}

const HEAD: &str = "\
(* Reads or writes one parameter in the parameter channel, the first 8 octets of inputs and outputs.
   Call it once in each cycle. A rising edge of EXECUTE begins; DONE or ERROR stay TRUE until EXECUTE is FALSE.
   RESPONSE: octets 0 to 7 of the inputs. REQUEST: octets 0 to 7 of the outputs.
   WRITE: FALSE reads, TRUE writes LENGTH octets: NUMBER as a float if IS_REAL (LENGTH 4), otherwise WHOLE.
   ERROR_CODE below 0:
   -1       the inputs of the block do not fit each other, nothing was sent
   -2       no answer within TIMEOUT_CALLS calls; a write may have been executed: read before you write again.
            The block counts calls, not time: a program without a cycle time calls it too often
   -3       the slave does not exchange data; as -2
   -4       an answer of unknown kind
   ERROR_CODE of the device:";

const INPUTS: &str = "\
RESPONSE : ARRAY[0..7] OF BYTE;
EXCHANGING : BOOL;
EXECUTE : BOOL;
WRITE : BOOL;
SLOT : INT;
INDEX : INT;
LENGTH : INT;
IS_REAL : BOOL;
NUMBER : REAL;
WHOLE : DINT;
TIMEOUT_CALLS : DINT := 1000;";

const OUTPUTS: &str = "\
REQUEST : ARRAY[0..7] OF BYTE;
BUSY : BOOL;
DONE : BOOL;
ERROR : BOOL;
ERROR_CODE : INT;
RESULT : ARRAY[0..3] OF BYTE;
RESULT_LENGTH : INT;
RESULT_WHOLE : DINT;
RESULT_NUMBER : REAL;
RESULT_IS_NUMBER : BOOL;";

const OWN: &str = "\
STATE : INT;
WAS_EXECUTE : BOOL;
TASK_CODE : INT;
VALUE : ARRAY[0..3] OF INT;
CALLS : DINT;
IS_LATE : BOOL;
RAW : BYTE;
AK : INT;
ELEMENT : INT;
ITEM : INT;
REST : DINT;
OCTET : DINT;
MANTISSA : REAL;
PLACE : REAL;
EXPONENT : INT;";

/// STATE 0: no task; 1: waits until the answer has no task, because some devices begin a task only then; 2: waits for the answer.
const STATEMENTS: &str = "\
RAW := RESPONSE[0];
AK := BYTE_TO_INT((RAW)) / 16;
IF NOT EXECUTE AND (STATE = 0) THEN
    DONE := FALSE;
    ERROR := FALSE;
END_IF;

IF EXECUTE AND NOT WAS_EXECUTE AND (STATE = 0) THEN
    DONE := FALSE;
    ERROR := FALSE;
    ERROR_CODE := 0;
    CALLS := 0;
    TASK_CODE := 1;
    FOR ELEMENT := 0 TO 3 DO
        VALUE[ELEMENT] := 0;
    END_FOR;
    IF WRITE THEN
        TASK_CODE := 0;
{TASKS}
        IF IS_REAL THEN
            MANTISSA := ABS((NUMBER));
            EXPONENT := 150;
            WHILE (MANTISSA >= 16777216.0) AND (EXPONENT < 255) DO
                MANTISSA := MANTISSA * 0.5;
                EXPONENT := EXPONENT + 1;
            END_WHILE;
            WHILE (MANTISSA < 8388608.0) AND (EXPONENT > 1) DO
                MANTISSA := MANTISSA * 2.0;
                EXPONENT := EXPONENT - 1;
            END_WHILE;
            IF NUMBER = 0.0 THEN
                REST := 0;
                EXPONENT := 0;
            ELSIF (LENGTH <> 4) OR (EXPONENT > 254) OR NOT (MANTISSA >= 8388608.0) THEN
                TASK_CODE := 0;
                REST := 0;
                EXPONENT := 0;
            ELSE
                MANTISSA := MANTISSA - 8388608.0;
                REST := 0;
                PLACE := 4194304.0;
                WHILE PLACE >= 1.0 DO
                    REST := REST * 2;
                    IF MANTISSA >= PLACE THEN
                        MANTISSA := MANTISSA - PLACE;
                        REST := REST + 1;
                    END_IF;
                    PLACE := PLACE * 0.5;
                END_WHILE;
            END_IF;
            IF LENGTH <> 4 THEN
                TASK_CODE := 0;
            END_IF;
            VALUE[0] := EXPONENT / 2;
            IF NUMBER < 0.0 THEN
                VALUE[0] := VALUE[0] + 128;
            END_IF;
            VALUE[1] := (EXPONENT MOD 2) * 128 + DINT_TO_INT((REST / 65536));
            VALUE[2] := DINT_TO_INT((REST / 256) MOD 256);
            VALUE[3] := DINT_TO_INT((REST MOD 256));
        ELSE
            IF (LENGTH = 1) AND ((WHOLE < -128) OR (WHOLE > 255)) THEN
                TASK_CODE := 0;
            ELSIF (LENGTH = 2) AND ((WHOLE < -32768) OR (WHOLE > 65535)) THEN
                TASK_CODE := 0;
            END_IF;
            REST := WHOLE;
            ELEMENT := 3;
            WHILE (TASK_CODE > 0) AND (ELEMENT > 3 - LENGTH) DO
                OCTET := REST MOD 256;
                IF OCTET < 0 THEN
                    OCTET := OCTET + 256;
                END_IF;
                VALUE[ELEMENT] := DINT_TO_INT((OCTET));
                REST := (REST - OCTET) / 256;
                ELEMENT := ELEMENT - 1;
            END_WHILE;
        END_IF;
    END_IF;
    IF (TASK_CODE = 0) OR (SLOT < 0) OR (SLOT > 255) OR (INDEX < 0) OR (INDEX > 255) THEN
        ERROR := TRUE;
        ERROR_CODE := -1;
    ELSE
        STATE := 1;
    END_IF;
END_IF;
WAS_EXECUTE := EXECUTE;

IF STATE <> 0 THEN
    IS_LATE := CALLS >= TIMEOUT_CALLS;
    IF NOT IS_LATE THEN
        CALLS := CALLS + 1;
    END_IF;
    IF NOT EXCHANGING THEN
        STATE := 0;
        ERROR := TRUE;
        ERROR_CODE := -3;
    ELSIF (STATE = 1) AND (AK = 0) THEN
        STATE := 2;
        REQUEST[0] := INT_TO_BYTE((TASK_CODE * 16));
        REQUEST[1] := INT_TO_BYTE((SLOT));
        REQUEST[2] := INT_TO_BYTE((INDEX));
        ITEM := 0;
        REQUEST[3] := INT_TO_BYTE((ITEM));
        FOR ELEMENT := 0 TO 3 DO
            ITEM := VALUE[ELEMENT];
            REQUEST[4 + ELEMENT] := INT_TO_BYTE((ITEM));
        END_FOR;
    ELSIF (STATE = 2) AND (AK <> 0) AND (RESPONSE[1] = REQUEST[1]) AND (RESPONSE[2] = REQUEST[2]) THEN
        STATE := 0;
        DONE := TRUE;
        FOR ELEMENT := 0 TO 3 DO
            RESULT[ELEMENT] := RESPONSE[4 + ELEMENT];
            RAW := RESPONSE[4 + ELEMENT];
            VALUE[ELEMENT] := BYTE_TO_INT((RAW));
        END_FOR;
        CASE AK OF
            1: RESULT_LENGTH := 2;
            2: RESULT_LENGTH := 4;
            11: RESULT_LENGTH := 1;
            7:
                DONE := FALSE;
                ERROR := TRUE;
                ERROR_CODE := VALUE[3];
        ELSE
            DONE := FALSE;
            ERROR := TRUE;
            ERROR_CODE := -4;
        END_CASE;
        RESULT_IS_NUMBER := FALSE;
        RESULT_NUMBER := 0.0;
        RESULT_WHOLE := 0;
        IF DONE THEN
            IF (AK = 2) AND (VALUE[0] >= 128) THEN
                RESULT_WHOLE := -1;
            END_IF;
            ELEMENT := 4 - RESULT_LENGTH;
            WHILE ELEMENT <= 3 DO
                ITEM := VALUE[ELEMENT];
                RESULT_WHOLE := RESULT_WHOLE * 256 + INT_TO_DINT((ITEM));
                ELEMENT := ELEMENT + 1;
            END_WHILE;
            EXPONENT := (VALUE[0] MOD 128) * 2 + VALUE[1] / 128;
            RESULT_IS_NUMBER := (AK = 2) AND (EXPONENT < 255);
            IF RESULT_IS_NUMBER AND (EXPONENT > 0) THEN
                ITEM := VALUE[1] MOD 128 + 128;
                RESULT_NUMBER := INT_TO_REAL((ITEM)) * 65536.0;
                ITEM := VALUE[2];
                RESULT_NUMBER := RESULT_NUMBER + INT_TO_REAL((ITEM)) * 256.0;
                ITEM := VALUE[3];
                RESULT_NUMBER := RESULT_NUMBER + INT_TO_REAL((ITEM));
                EXPONENT := EXPONENT - 150;
                WHILE EXPONENT > 0 DO
                    RESULT_NUMBER := RESULT_NUMBER * 2.0;
                    EXPONENT := EXPONENT - 1;
                END_WHILE;
                WHILE EXPONENT < 0 DO
                    RESULT_NUMBER := RESULT_NUMBER * 0.5;
                    EXPONENT := EXPONENT + 1;
                END_WHILE;
                IF VALUE[0] >= 128 THEN
                    RESULT_NUMBER := 0.0 - RESULT_NUMBER;
                END_IF;
            END_IF;
        END_IF;
    ELSIF IS_LATE THEN
        STATE := 0;
        ERROR := TRUE;
        ERROR_CODE := -2;
    END_IF;
END_IF;

IF STATE < 2 THEN
    ITEM := 0;
    FOR ELEMENT := 0 TO 7 DO
        REQUEST[ELEMENT] := INT_TO_BYTE((ITEM));
    END_FOR;
END_IF;
BUSY := STATE <> 0;";
