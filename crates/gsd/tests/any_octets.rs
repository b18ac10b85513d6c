//! Any octets: no panic, and the octets stay.

use profivac_gsd::{Configuration, GsdFile, text};

/// Parts of files, which follow each other in any order.
const PARTS: &[&str] = &[
    "#Profibus_DP",
    "\n",
    "\r\n",
    "\r",
    " ",
    "\t",
    ";",
    "\\",
    "\\\n",
    "\"",
    "=",
    "(",
    ")",
    ",",
    "-",
    "0x",
    "0X1F",
    "7",
    "255",
    "-5",
    "99999999999999999999",
    "Module=",
    "Module=\"m\" 0x10\n",
    "EndModule\n",
    "Modular_Station=1\n",
    "Max_Module=5\n",
    "Preset=1\n",
    "FixPresetModules=1\n",
    "PrmText=1\n",
    "Text(0)=\"t\"\n",
    "EndPrmText\n",
    "ExtUserPrmData=1 \"p\"\n",
    "BitArea(0-9) 3 1-2\n",
    "Signed32 -2147483648 -5-5\n",
    "Unsigned32 0xFFFFFFFF\n",
    "Prm_Text_Ref=1\n",
    "EndExtUserPrmData\n",
    "Ext_User_Prm_Data_Ref(0)=1\n",
    "Ext_User_Prm_Data_Ref(236)=1\n",
    "Ext_User_Prm_Data_Const(1)=1,2,3\n",
    "Ext_Module_Prm_Data_Len=65535\n",
    "F_Ext_User_Prm_Data_Const(0)=1\n",
    "User_Prm_Data=1,2\n",
    "User_Prm_Data_Len=4294967295\n",
    "SlotDefinition\n",
    "Slot(0)=\"s\" 1 0-4294967295\n",
    "Slot(1)=\"s\" 1 1,2\n",
    "EndSlotDefinition\n",
    "UnitDiagType=254\n",
    "EndUnitDiagType\n",
    "Unit_Diag_Area=0-65535\n",
    "X_Unit_Diag_Area=9 -3\n",
    "Value(18446744073709551615)=\"v\"\n",
    "Unit_Diag_Area_End\n",
    "Unit_Diag_Bit(65535)=\"b\"\n",
    "Unit_Diag_!Bit(0)=\"b\"\n",
    "Channel_Diag(31)=\"c\"\n",
    "4294967295\n",
    "9.6_supp=1\n",
    "Unknown=x\n",
    "#Other\n",
    "ExtUserPrmData=1 \"[SlotNumber]\"\n",
    "Text(-1)=\"below\"\n",
    "0x10,,0x20 valve\n",
    "65535\n",
    "é",
    "\u{a0}",
];

fn parts(random: &mut fastrand::Rng) -> Vec<u8> {
    let mut octets = Vec::new();
    for _ in 0..random.usize(..60) {
        match random.u8(..20) {
            0 => octets.push(random.u8(..)),
            _ => octets.extend(random.choice(PARTS).map(|part| part.as_bytes()).unwrap_or_default()),
        }
    }
    octets
}

/// Reads the octets and asks everything of the model.
fn try_all(octets: &[u8]) {
    let file = GsdFile::read(octets);
    assert_eq!(file.octets(), octets);
    assert_eq!(file.lines().map(|(_, line)| line).collect::<String>(), file.text());
    let lines = file.text().split(['\n', '\r']).count();
    for problem in file.problems() {
        assert!((1..=lines).contains(&problem.line), "{problem}");
    }
    let device = file.device();
    let numbers: Vec<u32> = device.modules.iter().map(|module| module.number).take(3).collect();
    for configuration in [Configuration::preset(device), Configuration::new(device, &numbers)].into_iter().flatten() {
        let _ = (configuration.chk_cfg(), configuration.user_prm(), configuration.module_of_identifier(1));
        let mut changed = configuration.clone();
        for one in configuration.parameters() {
            if changed.set(one.parameter.name.as_str(), "1").is_ok() {
                assert!(changed.parameters().iter().any(|one| one.value == 1));
            }
        }
    }
    let _ = device.diagnosis.device_block(&[0x3F; 63]);
    let written = text(device);
    assert_eq!(GsdFile::read(written.as_bytes()).device().modules.len(), device.modules.len(), "{written}");
}

#[test]
fn any_octets_are_read_without_a_panic_and_stay() {
    let mut random = fastrand::Rng::with_seed(44);
    for _ in 0..1500 {
        let octets: Vec<u8> = (0..random.usize(..80)).map(|_| random.u8(..)).collect();
        try_all(&octets);
    }
}

#[test]
fn any_octets_and_any_lines_in_utf_16_are_read_without_a_panic_and_stay() {
    let mut random = fastrand::Rng::with_seed(46);
    for round in 0..1000 {
        let text = String::from_utf8_lossy(&parts(&mut random)).into_owned();
        let mut octets = [b"\xFF\xFE".to_vec(), text.encode_utf16().flat_map(u16::to_le_bytes).collect()].concat();
        if round % 4 == 0 {
            let place = random.usize(2..octets.len().max(3));
            octets.truncate(place);
            octets.extend((0..random.usize(..5)).map(|_| random.u8(..)));
        }
        try_all(&octets);
    }
}

#[test]
fn any_order_of_lines_is_read_without_a_panic_and_stays() {
    let mut random = fastrand::Rng::with_seed(45);
    for _ in 0..2000 {
        try_all(&parts(&mut random));
    }
}
