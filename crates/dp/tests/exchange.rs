//! Data exchange: Data_Exchange, RD_Inp, RD_Outp, Global_Control and the diagnosis flag. profibus-wire 2.8 to 2.10, 3.3 and
//! 3.8.

use crate::rig;

use profivac_dp::slave::{Features, SlaveState};
use profivac_wire::control::Status;
use profivac_wire::{DataTelegram, Telegram};
use rig::{Answer, Gauge, MASTER, RR, RS, Rig, Seen, emit, hex, low};

const RD_INP: u8 = 56;
const RD_OUTP: u8 = 57;
const OTHER: u8 = 3;

fn exchanging() -> Rig {
    Rig::exchanging(Gauge::default())
}

/// A device with other lengths than two octets each way.
fn configured(cfg: &str, inputs: &str) -> Rig {
    let mut rig = Rig::new(Gauge { configurations: vec![hex(cfg)], inputs: hex(inputs), ..Gauge::default() });
    assert_eq!(rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00")), Answer::Ack);
    assert_eq!(rig.ms0(MASTER, 62, &hex(cfg)), Answer::Ack);
    rig
}

/// Global_Control as an SDN with this FC, to this station or to all stations (127).
fn control(rig: &mut Rig, sa: u8, da: u8, fc: u8, du: &str) {
    let du = hex(du);
    let data = DataTelegram { da, sa, dsap: Some(58), ssap: Some(62), fc, du: &du };
    assert_eq!(rig.raw(&emit(&Telegram::Data(data))), None, "an SDN is never answered");
}

fn all_stations(rig: &mut Rig, du: &str) {
    control(rig, MASTER, 127, 0x46, du);
}

fn outputs(rig: &mut Rig) -> Answer {
    rig.ms0(OTHER, RD_OUTP, &[])
}

fn is_exchanging(rig: &Rig) -> bool {
    matches!(rig.slave.state(), SlaveState::DataExch(..))
}

/// profibus-wire 2.8
#[test]
fn the_printed_exchanges() {
    let mut rig = exchanging();
    let request = "68 05 05 68 08 02 7D AA 55 86 16";
    assert_eq!(rig.dialogue(request), "68 05 05 68 02 08 08 01 02 15 16");
    rig.device().changed = true;
    assert_eq!(rig.dialogue(request), "68 05 05 68 02 08 0A 01 02 17 16");
    let mut no_inputs = configured("21", "");
    assert_eq!(no_inputs.dialogue(request), "E5");
    no_inputs.device().changed = true;
    assert_eq!(no_inputs.dialogue(request), "10 02 08 0A 14 16");
    let mut no_outputs = configured("11", "01 02");
    assert_eq!(no_outputs.dialogue("10 08 02 5D 67 16"), "68 05 05 68 02 08 08 01 02 15 16");
}

#[test]
fn data_exchange_is_closed_in_other_states_and_to_other_masters() {
    let mut rig = Rig::new(Gauge::default());
    let closed = |rig: &mut Rig| {
        for sap in [RD_INP, RD_OUTP] {
            assert_eq!(rig.ms0(MASTER, sap, &[]), RS);
        }
        assert_eq!(rig.dx(MASTER, &[1, 2]), RS);
    };
    closed(&mut rig);
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00"));
    closed(&mut rig);
    rig.ms0(MASTER, 62, &hex("11 21"));
    assert_eq!(rig.dx(OTHER, &[1, 2]), RS);
    assert_eq!(outputs(&mut rig), low("00 00"));
}

#[test]
fn a_wrong_length_is_answered_once_and_then_the_slave_leaves() {
    for length in [0, 1, 3, 244] {
        let mut rig = exchanging();
        assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
        assert_eq!(rig.dx(MASTER, &vec![7; length]), low("01 02"), "{length}");
        assert_eq!(rig.dx(MASTER, &[5, 6]), RS, "{length}");
        assert_eq!(rig.diag(MASTER), "02 05 00 FF", "{length}");
        let [.., Seen::Outputs(last), Seen::Safe, Seen::Exchanging(false)] = &rig.device().seen[..] else {
            panic!("the faulty outputs reached the process")
        };
        assert_eq!(last, &[5, 6], "{length}");
    }
}

#[test]
fn outputs_of_length_zero_mean_fail_safe_if_set_prm_says_so() {
    let mut rig = Rig::new(Gauge::default());
    rig.start(MASTER, "C0 00 00");
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    assert_eq!(rig.dx(MASTER, &[]), low("01 02"));
    assert_eq!(rig.device().seen.last(), Some(&Seen::Safe));
    assert!(is_exchanging(&rig));
    assert_eq!(rig.dx(MASTER, &[7, 8]), low("01 02"));
    assert_eq!(rig.device().seen.last(), Some(&Seen::Outputs(vec![7, 8])));
}

/// A DP-V0 master has no bit for it: the GSD file says it.
#[test]
fn outputs_of_length_zero_mean_fail_safe_to_a_dp_v0_device_with_fail_safe() {
    let features = Features { dpv1: false, ms1: false, ..Gauge::default().features };
    for fail_safe in [false, true] {
        let mut rig = Rig::new(Gauge { features, fail_safe, ..Gauge::default() });
        rig.start(MASTER, "");
        rig.dx(MASTER, &[5, 6]);
        rig.dx(MASTER, &[]);
        assert_eq!(is_exchanging(&rig), fail_safe);
    }
}

#[test]
fn the_longest_exchange_has_244_octets_each_way() {
    let inputs: Vec<u8> = (0..244).collect();
    let cfg = "C0 FF FF C0 F9 F9";
    let mut rig = Rig::new(Gauge { configurations: vec![hex(cfg)], inputs: inputs.clone(), ..Gauge::default() });
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00"));
    rig.ms0(MASTER, 62, &hex(cfg));
    assert_eq!(rig.dx(MASTER, &[7; 244]), Answer::Low(inputs));
    assert_eq!(outputs(&mut rig), Answer::Low(vec![7; 244]));
}

/// profibus-wire 2.10
#[test]
fn the_printed_reads_of_another_master() {
    let mut rig = exchanging();
    rig.dx(MASTER, &[0xAA, 0x55]);
    assert_eq!(rig.dialogue("68 05 05 68 88 83 6D 38 3E EE 16"), "68 07 07 68 83 88 08 3E 38 01 02 8C 16");
    assert_eq!(rig.dialogue("68 05 05 68 88 83 5D 39 3E DF 16"), "68 07 07 68 83 88 08 3E 39 AA 55 89 16");
    for sap in [RD_INP, RD_OUTP] {
        assert_eq!(rig.ms0(OTHER, sap, &[0]), RR);
    }
    assert_eq!(configured("21", "").ms0(OTHER, RD_INP, &[]), Answer::Ack);
    assert_eq!(configured("11", "01 02").ms0(OTHER, RD_OUTP, &[]), Answer::Ack);
}

/// profibus-wire 3.3
/// profibus-wire 9.3, point 25
#[test]
fn a_changed_diagnosis_is_announced_until_the_owner_has_read_it() {
    let high = Answer::High(vec![1, 2]);
    let mut rig = exchanging();
    rig.device().changed = true;
    assert_eq!(rig.dx(MASTER, &[5, 6]), high);
    assert_eq!(rig.dx(MASTER, &[5, 6]), high);
    rig.ms0(OTHER, 60, &[]);
    assert_eq!(rig.dx(MASTER, &[5, 6]), high, "read by another master");
    assert_eq!(rig.ms0(MASTER, 60, &[0]), RR);
    assert_eq!(rig.dx(MASTER, &[5, 6]), high, "asked for wrongly");
    rig.ms0(MASTER, 60, &[]);
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
}

#[test]
fn a_static_diagnosis_is_announced_as_long_as_it_lasts() {
    let mut rig = exchanging();
    rig.device().static_diag = true;
    assert_eq!(rig.diag(MASTER), "00 06 00 02");
    assert_eq!(rig.dx(MASTER, &[5, 6]), Answer::High(vec![1, 2]), "and outputs are taken meanwhile");
    assert_eq!(rig.device().seen.last(), Some(&Seen::Outputs(vec![5, 6])));
    rig.device().static_diag = false;
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
}

#[test]
fn an_event_comes_with_its_blocks_and_is_announced_from_the_start() {
    let blocks = hex("07 81 02 00 05 01 2C");
    let mut rig = Rig::exchanging(Gauge { event: true, blocks: blocks.clone(), ..Gauge::default() });
    assert_eq!(rig.dx(MASTER, &[5, 6]), Answer::High(vec![1, 2]));
    assert_eq!(rig.ms0(MASTER, 60, &[]), low("08 04 00 02 12 34 07 81 02 00 05 01 2C"));
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    rig.device().event = false;
    assert_eq!(rig.ms0(MASTER, 60, &[]), low("00 04 00 02 12 34 07 81 02 00 05 01 2C"), "a status");
    rig.device().blocks = vec![0x3F; 238];
    let Answer::Low(du) = rig.ms0(MASTER, 60, &[]) else { panic!("a diagnosis") };
    assert_eq!(du.len(), 244);
}

#[test]
fn a_repeated_request_for_the_diagnosis_gets_the_same_answer() {
    let mut rig = exchanging();
    let first = rig.dialogue("68 05 05 68 88 82 5D 3C 3E E1 16");
    rig.device().event = true;
    rig.device().changed = true;
    assert_eq!(rig.again(), first);
    assert_eq!(rig.diag(MASTER), "08 04 00 02");
}

/// profibus-wire 2.9
#[test]
fn sync_holds_the_outputs_until_the_next_sync() {
    let mut rig = exchanging();
    rig.dx(MASTER, &[1, 1]);
    all_stations(&mut rig, "20 00");
    assert_eq!(outputs(&mut rig), low("01 01"));
    rig.dx(MASTER, &[2, 2]);
    rig.dx(MASTER, &[3, 3]);
    assert_eq!(outputs(&mut rig), low("01 01"));
    assert_eq!(rig.diag(MASTER), "00 24 00 02");
    all_stations(&mut rig, "20 00");
    assert_eq!(outputs(&mut rig), low("03 03"));
    rig.dx(MASTER, &[4, 4]);
    all_stations(&mut rig, "30 00");
    assert_eq!(outputs(&mut rig), low("04 04"), "Unsync beside Sync");
    rig.dx(MASTER, &[5, 5]);
    assert_eq!(outputs(&mut rig), low("05 05"));
    let reached: Vec<_> = rig.device().seen.iter().filter(|seen| matches!(seen, Seen::Outputs(_))).cloned().collect();
    assert_eq!(reached, [1, 3, 4, 5].map(|octet| Seen::Outputs(vec![octet; 2])));
}

#[test]
fn freeze_keeps_the_inputs_until_the_next_freeze() {
    let mut rig = exchanging();
    all_stations(&mut rig, "08 00");
    rig.device().inputs = vec![3, 4];
    assert_eq!(rig.dx(MASTER, &[0, 0]), low("01 02"));
    assert_eq!(rig.ms0(OTHER, RD_INP, &[]), low("01 02"));
    assert_eq!(rig.diag(MASTER), "00 14 00 02");
    all_stations(&mut rig, "08 00");
    assert_eq!(rig.dx(MASTER, &[0, 0]), low("03 04"));
    rig.device().inputs = vec![5, 6];
    all_stations(&mut rig, "0C 00");
    assert_eq!(rig.dx(MASTER, &[0, 0]), low("05 06"), "Unfreeze beside Freeze");
    assert_eq!(rig.diag(MASTER), "00 04 00 02");
}

#[test]
fn clear_makes_outputs_safe_at_once_also_in_sync() {
    let mut rig = exchanging();
    rig.dx(MASTER, &[5, 6]);
    all_stations(&mut rig, "02 00");
    assert_eq!(outputs(&mut rig), low("00 00"));
    assert_eq!(rig.device().seen.last(), Some(&Seen::Safe));
    rig.dx(MASTER, &[7, 8]);
    assert_eq!(outputs(&mut rig), low("07 08"));
    all_stations(&mut rig, "20 00");
    rig.dx(MASTER, &[9, 9]);
    all_stations(&mut rig, "02 00");
    all_stations(&mut rig, "20 00");
    assert_eq!(outputs(&mut rig), low("00 00"), "the outputs that Sync holds back are cleared too");
}

#[test]
fn a_command_is_executed_for_the_own_group_of_the_owner_in_data_exchange() {
    let group = |select: u8| {
        let mut rig = Rig::new(Gauge::default());
        rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 06"));
        all_stations(&mut rig, "28 00");
        rig.ms0(MASTER, 62, &hex("11 21"));
        assert_eq!(rig.diag(MASTER), "00 04 00 02", "not before data exchange");
        all_stations(&mut rig, &format!("28 {select:02X}"));
        rig.diag(MASTER)
    };
    assert_eq!([0, 2, 4, 6, 0xFF].map(group), ["00 34 00 02"; 5]);
    assert_eq!([1, 8, 0xF9].map(group), ["00 04 00 02"; 3]);
    let mut rig = exchanging();
    control(&mut rig, OTHER, 127, 0x46, "28 00");
    assert_eq!(rig.diag(MASTER), "00 04 00 02", "from another master");
    control(&mut rig, MASTER, 9, 0x46, "28 00");
    assert_eq!(rig.diag(MASTER), "00 04 00 02", "to another station");
    all_stations(&mut rig, "28");
    assert_eq!(rig.diag(MASTER), "00 04 00 02", "cut");
}

#[test]
fn a_command_may_be_low_priority_and_may_address_one_station() {
    for (da, fc) in [(127, 0x44), (8, 0x46), (8, 0x44)] {
        let mut rig = exchanging();
        control(&mut rig, MASTER, da, fc, "20 00");
        assert_eq!(rig.diag(MASTER), "00 24 00 02", "{da} {fc:02X}");
    }
}

/// "Unsupported Sync/Freeze": a command that only cancels requires no feature. Both bits of a pair cancel each other.
#[test]
fn a_slave_without_sync_and_freeze_accepts_unsync_and_unfreeze() {
    for (sync, freeze, harmless, in_vain) in [
        (false, false, &["10 00", "30 00", "04 00", "0C 00", "14 00", "3C 00"][..], &["20 00", "24 00", "28 00"][..]),
        (true, false, &["20 00", "10 00", "04 00", "0C 00", "24 00", "2C 00"], &["08 00", "28 00", "18 00", "38 00"]),
        (false, true, &["08 00", "04 00", "10 00", "30 00", "18 00", "38 00"], &["20 00", "28 00", "24 00", "2C 00"]),
    ] {
        let features = Features { sync, freeze, ..Gauge::default().features };
        let not_supported = |command: &str| {
            let mut rig = Rig::exchanging(Gauge { features, ..Gauge::default() });
            all_stations(&mut rig, command);
            let announced = matches!(rig.dx(MASTER, &[5, 6]), Answer::High(_));
            assert_eq!(rig.diag(MASTER).starts_with("10 "), announced, "{command}");
            announced
        };
        assert!(!harmless.iter().any(|command| not_supported(command)), "sync {sync}, freeze {freeze}");
        assert!(in_vain.iter().all(|command| not_supported(command)), "sync {sync}, freeze {freeze}");
    }
}

/// profibus-wire 10, point 14 for the reserved bits.
#[test]
fn an_unsupported_command_sets_not_supported() {
    let features = Features { sync: false, freeze: false, ..Gauge::default().features };
    for command in ["20 00", "08 00", "01 00", "40 00", "80 00"] {
        let mut rig = Rig::exchanging(Gauge { features, ..Gauge::default() });
        all_stations(&mut rig, command);
        assert_eq!(rig.dx(MASTER, &[5, 6]), Answer::High(vec![1, 2]), "{command}");
        assert_eq!(rig.diag(MASTER), "10 04 00 02", "{command}");
        assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"), "{command}");
        assert_eq!(outputs(&mut rig), low("05 06"), "{command}");
    }
}

#[test]
fn a_new_start_ends_sync_and_freeze() {
    let mut rig = exchanging();
    all_stations(&mut rig, "28 00");
    rig.start(MASTER, "80 00 00");
    assert_eq!(rig.diag(MASTER), "00 04 00 02");
    rig.dx(MASTER, &[5, 6]);
    assert_eq!(outputs(&mut rig), low("05 06"));
}

/// The owner has not got the diagnosis, so DH goes on announcing it.
#[test]
fn a_diagnosis_that_does_not_fit_a_telegram_stays_pending() {
    let mut rig = exchanging();
    rig.device().blocks = vec![0; 239];
    rig.device().changed = true;
    assert_eq!(rig.dx(MASTER, &[0, 0]), Answer::High(hex("01 02")));
    assert_eq!(rig.ms0(MASTER, 60, &[]), Answer::Status(Status::UserError));
    assert_eq!(rig.dx(MASTER, &[0, 0]), Answer::High(hex("01 02")));
    rig.device().blocks.pop();
    assert!(matches!(rig.ms0(MASTER, 60, &[]), Answer::Low(du) if du.len() == 244));
    assert_eq!(rig.dx(MASTER, &[0, 0]), low("01 02"));
}
