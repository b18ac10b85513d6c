//! What the model holds.

use crate::support::{file, problems};
use profivac_gsd::{Alarm, Configuration, DataType, Fault, GsdFile, PrmContent, text};

#[test]
fn the_number_of_a_module_stands_anywhere_in_it() {
    let file = file(
        "Module=\"a\" 0x10\n7\nEndModule\nModule=\"b\" 0x10\nPreset=1\n8\nEndModule\n\
         Module=\"c\" 0x10\nExt_Module_Prm_Data_Len=1\nExt_User_Prm_Data_Const(0)=1\n0\nEndModule",
    );
    let numbers: Vec<_> = file.device().modules.iter().map(|module| (module.number, module.numbered)).collect();
    assert_eq!(numbers, [(7, true), (8, true), (0, true)]);
    assert_eq!(file.device().module(0).map(|module| module.name.as_str()), Some("c"));
    assert_eq!(problems(&file), []);
}

#[test]
fn a_second_number_in_a_module_is_a_problem() {
    let file = file("Module=\"a\" 0x10\n7\n8\nEndModule");
    assert_eq!(file.device().modules.first().map(|module| module.number), Some(7));
    assert_eq!(problems(&file), [(5, Fault::NoKeyword)]);
}

#[test]
fn a_module_without_a_number_gets_its_place_or_the_next_free_number() {
    let file = file(
        "Module=\"a\" 1\nEndModule\nModule=\"b\" 1\n1\nEndModule\nModule=\"c\" 1\nEndModule\nModule=\"d\" 1\n4\nEndModule\nModule=\"e\" 1\nEndModule",
    );
    let numbers: Vec<_> = file.device().modules.iter().map(|module| module.number).collect();
    assert_eq!(numbers, [5, 1, 3, 4, 6]);
}

#[test]
fn a_module_number_above_65535_is_refused_and_the_search_for_a_free_one_ends() {
    let modules = |first: &str| {
        file(&format!(
            "Module=\"a\" 0\n{first}\nEndModule\nModule=\"b\" 0\n3\nEndModule\nModule=\"c\" 0\nEndModule\nModule=\"d\" 0\nEndModule"
        ))
    };
    let numbers = |file: &GsdFile| file.device().modules.iter().map(|module| module.number).collect::<Vec<_>>();
    let refused = modules("65536");
    assert_eq!(problems(&refused), [(4, Fault::OutOfRange)]);
    assert_eq!(numbers(&refused), [1, 3, 4, 5]);
    assert_eq!(numbers(&modules("4294967294")), [1, 3, 4, 5]);
    let highest = modules("65535");
    assert_eq!(problems(&highest), []);
    assert_eq!(numbers(&highest), [65535, 3, 1, 4]);
}

#[test]
fn modules_with_one_name_one_number_or_the_same_octets_are_all_there() {
    let file =
        file("Module=\"a   \" 0x10\n1\nEndModule\nModule=\"a\" 0x10\n1\nEndModule\nModule=\"b\" 0x20\n2\nEndModule");
    let device = file.device();
    assert_eq!(device.modules_named(" a ").count(), 2);
    assert_eq!(device.modules_with(&[0x10]).count(), 2);
    assert_eq!(device.module(1).map(|module| module.line), Some(3));
    assert_eq!(problems(&file), [(6, Fault::ModuleNameTwice), (6, Fault::ModuleNumberTwice)]);
}

#[test]
fn each_type_of_parameter_has_its_default_and_its_allowed_values() {
    type Row = (&'static str, DataType, i64, &'static [(i64, i64)]);
    let rows: [Row; 12] = [
        ("Bit(3) 1 0-1", DataType::Bit(3), 1, &[(0, 1)]),
        ("Bit(0)  0-1", DataType::Bit(0), 0, &[(0, 1)]),
        ("BitArea(2-5) 3 0,2,3", DataType::BitArea(2, 5), 3, &[(0, 0), (2, 2), (3, 3)]),
        ("BitArea(0-7) 0x54 0x50-0x55,0x1b", DataType::BitArea(0, 7), 0x54, &[(0x50, 0x55), (0x1b, 0x1b)]),
        ("Unsigned8 200", DataType::Unsigned8, 200, &[]),
        ("Unsigned16 0x4802 0-0xffff", DataType::Unsigned16, 0x4802, &[(0, 0xFFFF)]),
        ("Unsigned32 4294967295 0-4294967295", DataType::Unsigned32, 4_294_967_295, &[(0, 4_294_967_295)]),
        ("Signed8 -1 -128-127", DataType::Signed8, -1, &[(-128, 127)]),
        ("Signed16 -27648 -27648--5", DataType::Signed16, -27648, &[(-27648, -5)]),
        ("Signed16 0 -5 - 5", DataType::Signed16, 0, &[(-5, 5)]),
        ("Signed32 5 -5,5,7", DataType::Signed32, 5, &[(-5, -5), (5, 5), (7, 7)]),
        ("Unsigned8 5 9-1", DataType::Unsigned8, 5, &[(1, 9)]),
    ];
    for (line, kind, default, allowed) in rows {
        let file = file(&format!("ExtUserPrmData=1 \"p\"\n{line}\nEndExtUserPrmData"));
        let parameter = file.device().parameters.get(&1).expect("a parameter");
        assert_eq!(
            (parameter.kind, parameter.default, parameter.allowed.as_slice()),
            (kind, default, allowed),
            "{line}"
        );
        let expected: &[_] = if line == "Bit(0)  0-1" { &[(4, Fault::MissingDefault)] } else { &[] };
        assert_eq!(problems(&file), expected, "{line}");
    }
}

#[test]
fn a_parameter_has_texts_and_may_be_fixed_or_hidden() {
    let file = file(
        "PrmText=4\nText(0)=\"off\"\nText(0x02)=\"on\"\nEndPrmText\n\
         ExtUserPrmData=9 \" p  \"\nUnsigned8 0 0-2\nPrm_Text_Ref=4\nChangeable=0\nVisible=0\nEndExtUserPrmData",
    );
    let parameter = file.device().parameters.get(&9).expect("a parameter");
    assert_eq!((parameter.name.as_str(), parameter.changeable, parameter.visible), ("p", false, false));
    assert_eq!(file.device().text_of(parameter, 2), Some("on"));
    assert_eq!(file.device().values_of(parameter), "0 (off), 2 (on)");
    assert_eq!(problems(&file), []);
}

#[test]
fn a_text_belongs_to_a_value_with_its_sign() {
    let file = file(
        "PrmText=4\nText(-1)=\"below\"\nText(1)=\"above\"\nEndPrmText\nExtUserPrmData=9 \"p\"\nSigned8 -1 -1-1\nPrm_Text_Ref=4\nEndExtUserPrmData\n\
         Unit_Diag_Bit(-1)=\"none\"",
    );
    let parameter = file.device().parameters.get(&9).expect("a parameter");
    assert_eq!([-1, 1].map(|value| file.device().text_of(parameter, value)), [Some("below"), Some("above")]);
    assert!(text(file.device()).contains("Text(-1)=\"below\""));
    assert_eq!(problems(&file), [(11, Fault::BadValue)]);
}

#[test]
fn of_many_possible_values_the_first_twenty_are_listed() {
    let texts: String = (0..30).map(|value| format!("Text({value})=\"t\"\n")).collect();
    let values: String = (0..30).map(|value| format!("{},", value * 2)).collect();
    let file = file(&format!(
        "PrmText=1\n{texts}EndPrmText\nExtUserPrmData=1 \"named\"\nUnsigned8 0\nPrm_Text_Ref=1\nEndExtUserPrmData\n\
         ExtUserPrmData=2 \"plain\"\nUnsigned8 0 {values}60\nEndExtUserPrmData"
    ));
    let words = |number: u32| file.device().parameters.get(&number).map(|one| file.device().values_of(one));
    assert!(words(1).is_some_and(|words| words.ends_with("18 (t), 19 (t) and 10 more")), "{:?}", words(1));
    assert!(words(2).is_some_and(|words| words.ends_with("36, 38 and 11 more")), "{:?}", words(2));
}

#[test]
fn wrong_parameters_are_problems_with_lines() {
    let file = file(
        "ExtUserPrmData=1 \"p\"\nUnsigned8 9 0-2\nPrm_Text_Ref=4\nEndExtUserPrmData\n\
         ExtUserPrmData=1 \"q\"\nBitArea(5-9) 0\nEndExtUserPrmData\n\
         Max_User_Prm_Data_Len=1\nExt_User_Prm_Data_Ref(1)=1\nExt_User_Prm_Data_Ref(0)=3\nExt_User_Prm_Data_Const(300)=1\nBit(0) 0",
    );
    let expected = [
        (3, Fault::DefaultOutOfRange),
        (7, Fault::DefinitionTwice),
        (8, Fault::BadBits),
        (11, Fault::BeyondLength),
        (12, Fault::UnknownParameter),
        (13, Fault::OutOfRange),
        (14, Fault::MisplacedKeyword),
    ];
    assert_eq!(problems(&file), expected);
    assert_eq!(file.device().parameters.get(&1).map(|parameter| parameter.kind), Some(DataType::BitArea(5, 7)));
}

#[test]
fn problems_of_user_prm_data_and_of_the_ident_name_its_line() {
    let ident = |value: &str| {
        let text = format!("#Profibus_DP\nVendor_Name=\"v\"\n{value}");
        let file = GsdFile::read(text.as_bytes());
        (problems(&file), file.device().general.ident_number)
    };
    assert_eq!(ident("Ident_Number=0x12345"), (vec![(3, Fault::OutOfRange)], None));
    assert_eq!(ident("Ident_Number=0xFFFF"), (vec![], Some(0xFFFF)));
    assert_eq!(ident(""), (vec![(1, Fault::NoIdent)], None));
    let file = file("Max_Module=1\nUser_Prm_Data=1,2\nUser_Prm_Data_Len=3\nExt_User_Prm_Data_Const(0)=1,3");
    assert_eq!(problems(&file), [(4, Fault::PrmLength), (4, Fault::BothPrm)]);
}

#[test]
fn slots_name_their_modules_and_missing_ones_are_problems() {
    let modules = "Module=\"a\" 0x10\n1\nEndModule\nModule=\"b\" 0x10\n2\nEndModule\nModule=\"d\" 0x10\n4\nEndModule\n";
    let file = file(&format!(
        "{modules}SlotDefinition\nSlot(1)=\"first\" 1 1-2\nSlot(2)=\"second\" 2 1,4\nSlot(3)=\"third\" 1 1-4294967295\nSlot(4)=\"last\" 4 4\nEndSlotDefinition"
    ));
    let slot = file.device().slots.get(&2).expect("a slot");
    assert_eq!([0, 1, 2, 3, 4].map(|module| slot.allows(module)), [false, true, true, false, true]);
    assert_eq!(problems(&file), [(14, Fault::SlotDefault), (15, Fault::UnknownModule)]);
    let found = file
        .problems()
        .iter()
        .find(|problem| problem.fault == Fault::UnknownModule)
        .map(|problem| problem.found.as_str());
    assert_eq!(found, Some("slot 3 allows 3"));
}

#[test]
fn parameters_for_safety_are_apart_from_the_others() {
    let file = file(
        "ExtUserPrmData=1 \"p\"\nUnsigned8 1\nEndExtUserPrmData\nModule=\"f\" 0x10\nF_ParamDescCRC = 0x1234\nF_Ext_Module_Prm_Data_Len=2\n\
         F_Ext_User_Prm_Data_Const(0)=0x0E\nF_Ext_User_Prm_Data_Ref(1)=1\nExt_Module_Prm_Data_Len=1\nExt_User_Prm_Data_Ref(0)=1\nEndModule",
    );
    let module = file.device().modules.first().expect("a module");
    assert_eq!((module.safety.length, module.safety.items.len()), (Some(2), 2));
    assert_eq!((module.prm.length, module.prm.items.len()), (Some(1), 1));
    assert_eq!(module.safety.items.first().map(|item| &item.content), Some(&PrmContent::Const(vec![0x0E])));
    assert_eq!(module.others.first().map(|other| other.keyword.as_str()), Some("F_ParamDescCRC"));
    assert_eq!(problems(&file), []);
}

#[test]
fn baud_rates_keep_their_order_and_their_times() {
    let file = file("12M_supp=1\n9.6_supp=1\nMaxTsdr_9.6=60\nMaxTsdr_12M=800\n45.45_supp=0\n6M_supp=1\n6M_supp=0");
    let rates: Vec<_> = file.device().rates.iter().map(|rate| (rate.name, rate.supported, rate.max_tsdr)).collect();
    let expected = [
        ("9.6", Some(true), Some(60)),
        ("45.45", Some(false), None),
        ("6M", Some(false), None),
        ("12M", Some(true), Some(800)),
    ];
    assert_eq!(rates, expected);
    assert_eq!(problems(&file), [(9, Fault::Repeated)]);
}

#[test]
fn keywords_of_dp_v1_and_of_the_bus_cycle_have_fields() {
    let file = file(
        "GSD_Revision=5\nDPV1_Slave=1\nC2_Max_Data_Len=80\nWD_Base_1ms_supp=1\nTBASE_DP=1500\nSlave_Family=3@Digital@24V ; I/O",
    );
    let general = &file.device().general;
    assert_eq!((general.gsd_revision, general.dpv1_slave, general.c2_max_data_len), (Some(5), Some(true), Some(80)));
    assert_eq!((general.wd_base_1ms_supp, general.tbase_dp), (Some(true), Some(1500)));
    assert_eq!(general.slave_family.as_deref(), Some("3@Digital@24V"));
    assert_eq!(problems(&file), []);
}

#[test]
fn the_last_octet_of_user_parameters_is_236() {
    let file = file("Ext_User_Prm_Data_Const(236)=1\nExt_User_Prm_Data_Const(237)=1");
    assert_eq!(problems(&file), [(4, Fault::OutOfRange)]);
}

#[test]
fn a_range_of_a_slot_needs_its_last_module_too() {
    let file = file(
        "Module=\"a\" 0x10\n1\nEndModule\nModule=\"b\" 0x10\n2\nEndModule\nSlotDefinition\nSlot(1)=\"s\" 1 1-3\nEndSlotDefinition",
    );
    assert_eq!(problems(&file), [(10, Fault::UnknownModule)]);
}

/// The keywords of alarms stand in modules too, and the station keeps its own.
#[test]
fn alarms_of_a_module_belong_to_it_and_a_required_one_is_a_warning() {
    let file = file(
        "DPV1_Slave=1\nDiagnostic_Alarm_required=0\nExt_User_Prm_Data_Const(0)=0x80,0x40,0x00\nModule=\"m\" 0x10\nDiagnostic_Alarm_supp=1\n\
         Diagnostic_Alarm_required=1\nProcess_Alarm_required=1\nUpdate_Alarm_required=0\nEndModule",
    );
    assert_eq!(problems(&file), []);
    let device = file.device();
    assert_eq!(device.general.diagnostic_alarm_required, Some(false));
    let alarms = &device.modules[0].alarms;
    assert_eq!(alarms.supported.iter().copied().collect::<Vec<_>>(), [Alarm::Diagnostic]);
    assert_eq!(alarms.required.iter().copied().collect::<Vec<_>>(), [Alarm::Diagnostic, Alarm::Process]);
    let warnings = Configuration::preset(device).expect("one module").warnings();
    let words: Vec<_> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        words,
        ["slot 1: 1 (m) requires diagnostic alarms, which the second user parameter does not enable; set its bit 20"]
    );
    let again = GsdFile::read(text(device).as_bytes());
    assert_eq!(again.device().modules[0].alarms, *alarms);
}

#[test]
fn a_required_alarm_of_the_station_is_a_warning_on_a_dp_v1_slave_only() {
    let words = |lines: &str| {
        let file = file(&format!("Pull_Plug_Alarm_required=1\nModule=\"m\" 0x10\nEndModule\n{lines}"));
        let warnings = Configuration::preset(file.device()).expect("one module").warnings();
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let text =
        "the station requires pull and plug alarms, which the second user parameter does not enable; set its bit 80";
    assert_eq!(words("DPV1_Slave=1"), [text]);
    assert_eq!(words("DPV1_Slave=1\nExt_User_Prm_Data_Const(0)=0,0x80,0"), [""; 0]);
    assert_eq!(words(""), [""; 0]);
}
