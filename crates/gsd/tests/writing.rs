//! A model as text.

use crate::support::file;
use profivac_gsd::{Configuration, Device, GsdFile, commented_text, text};

const WHOLE: &str = "\
GSD_Revision=5
Vendor_Name=\"Vendor \"&\" Sons\"
Max_Module = 4 ; four
Modular_Station=1
12M_supp=1
9.6_supp=1
MaxTsdr_9.6=60
User_Prm_Data=1,2,3
Colour = \"red\", 3
PrmText=2
Text(1)=\"one\"
Text(0)=\"none\"
EndPrmText
ExtUserPrmData=7 \"a\"
Signed16 -5 -5--1,3-4
Prm_Text_Ref=2
Changeable=0
EndExtUserPrmData
ExtUserPrmData=8 \"b\"
BitArea(2-3) 1 1,2
Visible=0
EndExtUserPrmData
Ext_User_Prm_Data_Const(0)=0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17
Ext_User_Prm_Data_Ref(2)=7
Ext_User_Prm_Data_Const(3)=9
Unit_Diag_Bit(24)=\"bit\"
Unit_Diag_!Bit(25)=\"no bit\"
Unit_Diag_Bit_Help(24)=\"help\"
Unit_Diag_Area=26-28
Value(1)=\"v\"
Unit_Diag_Area_End
UnitDiagType=254
X_Unit_Diag_Bit(30)=\"x\"
EndUnitDiagType
Channel_Diag(17)=\"c\"
Module=\"first\" 0x10,0x20
0
Preset=1
Info_Text=\"info\"
Ext_Module_Prm_Data_Len=2
Ext_User_Prm_Data_Ref(0)=7
F_Ext_Module_Prm_Data_Len=1
F_Ext_User_Prm_Data_Const(0)=5
Channel_Diag(17)=\"own\"
Shape=\"round\"
EndModule
Module=\"second\" 0x11
EndModule
SlotDefinition
Slot(1)=\"s\" 0 0,1-2
EndSlotDefinition";

#[test]
fn the_text_of_a_model_is_read_as_the_same_model() {
    let read = file(WHOLE);
    let written = text(read.device());
    let again = GsdFile::read(written.as_bytes());
    assert_eq!(text(again.device()), written);
    assert!(written.contains("0x0F,\\\n0x10"), "a long list goes on in the next line: {written}");
    let octets = |file: &GsdFile| {
        let configuration = Configuration::new(file.device(), &[0, 2]).expect("a configuration");
        (configuration.chk_cfg(), configuration.user_prm())
    };
    assert_eq!(octets(&again), octets(&read));
    assert_eq!(again.device().diagnosis, read.device().diagnosis);
    assert_eq!(again.device().rates, read.device().rates);
    assert_eq!(
        again.device().texts.get(&2).map(|texts| &texts.texts),
        read.device().texts.get(&2).map(|texts| &texts.texts)
    );
    let parameter = again.device().parameters.get(&7).expect("a parameter");
    assert_eq!((parameter.allowed.as_slice(), parameter.changeable), ([(-5, -1), (3, 4)].as_slice(), false));
}

#[test]
fn every_line_of_the_file_is_in_the_written_text() {
    let written = text(file(WHOLE).device());
    for line in [
        "#Profibus_DP",
        "Ident_Number            = 0x1234",
        "Vendor_Name             = \"Vendor '&' Sons\"",
        "Max_Module              = 4",
        "9.6_supp                = 1",
        "User_Prm_Data           = 0x01,0x02,0x03",
        "Colour = \"red\", 3",
        "Text(1)=\"one\"",
        "Signed16 -5 -5--1,3-4",
        "BitArea(2-3) 1 1,2",
        "Changeable=0",
        "Visible=0",
        "Ext_User_Prm_Data_Ref(2)=7",
        "Unit_Diag_!Bit(25)=\"no bit\"",
        "Unit_Diag_Area=26-28",
        "X_Unit_Diag_Bit(30)=\"x\"",
        "Module=\"first\" 0x10,0x20",
        "0",
        "Preset=1",
        "F_Ext_User_Prm_Data_Const(0)=0x05",
        "Channel_Diag(17)=\"own\"",
        "Shape=\"round\"",
        "Slot(1)=\"s\" 0 0,1-2",
    ] {
        assert!(written.lines().any(|written| written == line), "{line} is missing in\n{written}");
    }
    assert!(written.lines().all(|line| line.len() <= 132), "{written}");
}

#[test]
fn the_slave_family_has_no_quotation_marks() {
    let family = |value: &str| {
        let written = text(file(&format!("Slave_Family={value}")).device());
        let again = GsdFile::read(written.as_bytes());
        let line = written.lines().find(|line| line.starts_with("Slave_Family")).map(str::to_owned);
        (line.unwrap_or_default(), again.device().general.slave_family.clone().unwrap_or_default())
    };
    for value in ["3@ET200B", "3@Digital@24V", "0@Machine Vision", "12"] {
        assert_eq!(family(value), (format!("Slave_Family            = {value}"), value.to_owned()));
    }
    assert_eq!(family("\"3@a;b\""), ("Slave_Family            = \"3@a;b\"".to_owned(), "3@a;b".to_owned()));
}

#[test]
fn a_line_that_is_not_interpreted_takes_no_line_behind_it() {
    for line in ["Colour=\"red\\", "#Other"] {
        let read = GsdFile::read(format!("Module=\"m\" 0x10\nEndModule\n{line}").as_bytes());
        assert_eq!(read.device().others.len(), 1, "{line}");
        let written = text(read.device());
        assert_eq!(GsdFile::read(written.as_bytes()).device().modules.len(), 1, "{written}");
    }
}

#[test]
fn a_comment_is_one_line_and_continues_in_no_other() {
    let written = commented_text(&Device::default(), &["two\nlines", "a folder C:\\", ""]);
    assert_eq!(written, "#Profibus_DP\n; two lines\n; a folder C:\n;\n");
}
