//! One field of the answer is wrong.

use super::case::{Answer, FORM, OTHER_SAPS, all, saps};

#[test]
fn every_request_accepts_the_right_answer() {
    all().for_each(|case| case.takes_the_right_answer());
}

#[test]
fn an_answer_from_another_station_is_refused() {
    for case in all() {
        let wrong = Answer { sa: 9, ..case.right.clone() };
        case.refuses("source", &wrong.octets(), "the answer came from station 9");
    }
}

#[test]
fn an_answer_to_another_master_is_refused() {
    for case in all() {
        let wrong = Answer { da: 3, ..case.right.clone() };
        case.refuses("destination", &wrong.octets(), "the answer was for station 3");
    }
}

#[test]
fn an_answer_of_another_access_point_is_refused() {
    for case in all() {
        let right = &case.right;
        match right.saps {
            Some([master, slave]) => {
                for saps in [Some([master, slave ^ 1]), Some([master ^ 1, slave]), Some([slave, master]), None] {
                    let wrong = Answer { saps, ..right.clone() };
                    case.refuses("access point", &wrong.octets(), OTHER_SAPS);
                }
            }
            // Access points in an answer that must have none, or in an answer without data: a wrong form.
            None => {
                let words = if right.fc == 8 { OTHER_SAPS } else { FORM };
                let wrong = Answer { saps: saps(0x3C), ..right.clone() };
                case.refuses("access point", &wrong.octets(), words);
            }
        }
    }
}

#[test]
fn an_answer_with_another_function_code_is_refused() {
    for case in all() {
        let uncounted = case.right.fc == 0;
        // The codes of FDL status in place of those with data and the reverse; reserved codes.
        for fc in [if uncounted { 0x08 } else { 0x00 }, 0x04, 0x07, 0x0B, 0x0E, 0x0F, 0x88] {
            let wrong = Answer { fc, ..case.right.clone() };
            let words = format!("the answer's function code {fc:02X} does not fit the request");
            case.refuses("function", &wrong.octets(), &words);
        }
    }
}

/// A slave that answers with the function code of a request is no master: this master keeps the token, and the other slaves exchange data.
#[test]
fn an_answer_with_the_function_code_of_a_request_is_refused() {
    for case in all() {
        for fc in [0x40, 0x43, 0x46, 0x49, 0x4C, 0x4D, 0x5D, 0x6D, 0x7D, 0x4E, 0x4F] {
            // A station that answers FDL status with an FDL status request is another master.
            if case.right.fc == 0 && fc == 0x49 {
                continue;
            }
            let wrong = Answer { fc, ..case.right.clone() };
            let words = format!("the answer's function code {fc:02X} does not fit the request");
            case.refuses("request", &wrong.octets(), &words);
            let mut rig = (case.asked)();
            rig.receive_octets(11, &wrong.octets());
            assert!(rig.station.has_token(), "{} {fc:02X}", case.name);
        }
    }
}

#[test]
fn an_answer_of_another_length_is_refused() {
    for case in all() {
        for (length, words) in case.lengths {
            let mut du = case.right.du.clone();
            du.resize(*length, 7);
            let acknowledges = case.right.fc == 9;
            let wrong = if acknowledges {
                // Data where SC is due: with the access points that fit, so that the status alone is wrong.
                let service = [(0, 0x3D), (1, 0x3E)][usize::from(case.name == "Chk_Cfg")].1;
                let service = if case.class2.is_some() { 0x37 } else { service };
                Answer { fc: 8, saps: saps(service), du, ..case.right.clone() }
            } else {
                Answer { du, ..case.right.clone() }
            };
            case.refuses(&format!("{length} octets"), &wrong.octets(), words);
        }
    }
}

#[test]
fn a_short_acknowledgement_in_place_of_data_is_refused() {
    for case in all().filter(|case| case.right.fc != 9) {
        let image = case.name == "Data_Exchange" || case.name.starts_with("RD_");
        let words = match (case.right.fc, image) {
            (0, _) => FORM,
            (_, true) => "its answer has 0 octets instead of 2",
            (_, false) => "it acknowledges where it should answer with data",
        };
        case.refuses("SC", &[0xE5], words);
    }
}
