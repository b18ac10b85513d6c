//! No answer, the previous answer again, or octets that are no telegram.

use super::case::{OTHER_SAPS, all};
use crate::support::hex;

#[test]
fn no_answer_is_reported_as_such() {
    all().for_each(|case| case.refuses("nothing", &[], "no answer"));
}

#[test]
fn the_answer_to_the_former_request_is_refused_when_it_comes_again() {
    for case in all() {
        let former = hex(case.former);
        let function = format!("the answer's function code {:02X} does not fit the request", 0x08);
        let words = match (case.right.fc, former.len()) {
            (0, _) => function.as_str(),
            (_, 6) => "the answer's function code 00 does not fit the request",
            _ => OTHER_SAPS,
        };
        case.refuses("repeated", &former, words);
    }
}

#[test]
fn a_truncated_answer_is_refused() {
    for case in all() {
        let octets = case.right.octets();
        for length in 1..octets.len() {
            case.refuses(&format!("{length} octets of it"), &octets[..length], "the answer is damaged");
        }
    }
}

#[test]
fn an_answer_with_an_altered_octet_is_refused() {
    for case in all() {
        let octets = case.right.octets();
        for position in 0..octets.len() {
            for bit in 0..8 {
                let mut wrong = octets.clone();
                wrong[position] ^= 1 << bit;
                case.refuses(&format!("octet {position}, bit {bit}"), &wrong, "the answer is damaged");
            }
        }
    }
}

/// Two slaves answer at once: the result is no valid telegram.
#[test]
fn overlapping_answers_of_two_slaves_are_refused() {
    for case in all() {
        let one = case.right.octets();
        // Wired-and of two telegrams that begin a character apart.
        let mut both = one.clone();
        both.push(0xFF);
        for (octet, other) in both.iter_mut().skip(1).zip(&one) {
            *octet &= other;
        }
        case.refuses("on top of each other", &both, "the answer is damaged");
    }
}
