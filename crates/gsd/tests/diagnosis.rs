//! Diagnosis in the words of the file.

use crate::support::{file, problems};
use profivac_gsd::{Fault, GsdFile};

fn words(file: &GsdFile, block: &[u8]) -> Vec<String> {
    file.device().diagnosis.device_block(block).iter().map(ToString::to_string).collect()
}

#[test]
fn bits_count_from_the_octet_behind_the_header() {
    let file = file(
        "Unit_Diag_Bit(0)=\"first\"\nUnit_Diag_Bit(0x000F)=\"last\"\nUnit_Diag_Bit_Help(15)=\"look\"\nUnit_Diag_Bit(16)=\"beyond\"",
    );
    assert_eq!(words(&file, &[0x03, 0x01, 0x80]), ["first", "last (look)"]);
    assert_eq!(words(&file, &[0x03, 0xFE, 0x7F]), [""; 0]);
    assert_eq!(problems(&file), []);
}

#[test]
fn an_inverted_bit_has_its_text_when_it_is_not_set() {
    let file = file("Unit_Diag_!Bit(3)=\"no supply\"\nUnit_Diag_Not_Bit(4)=\"no bus\"\nUnit_Diag_!Bit(8)=\"beyond\"");
    assert_eq!(words(&file, &[0x02, 0x00]), ["no supply", "no bus"]);
    assert_eq!(words(&file, &[0x02, 0x08]), ["no bus"]);
    assert_eq!(words(&file, &[0x02, 0x18]), [""; 0]);
    assert_eq!(problems(&file).first(), Some(&(3, Fault::InvertedBit)));
}

#[test]
fn an_area_is_a_number_in_several_bits() {
    let file = file(
        "Unit_Diag_Area=4-9\nValue(0)=\"none\"\nValue(17)=\"wire\"\nUnit_Diag_Area_End\nUnit_Diag_Area = 12 - 13\nValue(1)=\"hot\"\nUnit_Diag_Area_End",
    );
    assert_eq!(words(&file, &[0x03, 0x10, 0x11]), ["wire", "hot"]);
    assert_eq!(words(&file, &[0x03, 0x00, 0x00]), ["none"]);
    assert_eq!(
        words(&file, &[0x03, 0x20, 0x20]),
        [
            "bits 4 to 9 have the value 2, which has no text in the file",
            "bits 12 to 13 have the value 2, which has no text in the file",
        ]
    );
    assert_eq!(words(&file, &[0x02, 0x10]), [""; 0], "the area is not complete");
    assert_eq!(problems(&file), []);
}

#[test]
fn texts_of_a_type_count_only_for_its_blocks() {
    let file = file(
        "Unit_Diag_Bit(24)=\"general\"\nUnitDiagType=254\nX_Unit_Diag_Bit(24)=\"typed\"\nX_Unit_Diag_Bit_Help(24)=\"help\"\n\
         X_Unit_Diag_Area=25-26\nX_Value(3)=\"both\"\nX_Unit_Diag_Area_End\nEndUnitDiagType",
    );
    assert_eq!(words(&file, &[0x05, 254, 0, 1, 0x07]), ["typed (help)", "both"]);
    assert_eq!(words(&file, &[0x05, 129, 0, 1, 0x07]), ["general"]);
    assert_eq!(problems(&file), []);
}

#[test]
fn another_block_or_a_cut_block_has_no_text() {
    let file = file("Unit_Diag_Bit(0)=\"first\"");
    for block in [&[][..], &[0x00], &[0x42, 0x01], &[0x82, 0x01, 0x01], &[0x03, 0x01]] {
        assert_eq!(words(&file, block), [""; 0], "{block:02X?}");
    }
    assert_eq!(words(&file, &[0x02, 0x01, 0xFF]), ["first"], "octets behind the block are another block");
}

#[test]
fn a_channel_error_has_its_text() {
    let file = file("Channel_Diag(16)=\"parameter\"\nChannel_Diag(9)=\"defect\"\nChannel_Diag(32)=\"too high\"");
    let diagnosis = &file.device().diagnosis;
    let text = |block| diagnosis.channel_block(block).map(|words| words.text.as_str());
    assert_eq!(text(&[0x83, 0x42, 0xB0]), Some("parameter"));
    assert_eq!(text(&[0x83, 0x42, 0x29]), Some("defect"));
    assert_eq!(text(&[0x83, 0x42, 0x21]), None);
    assert_eq!(text(&[0x43, 0x42, 0xB0]), None, "another block");
    assert_eq!(problems(&file), [(5, Fault::OutOfRange)]);
}

#[test]
fn an_area_without_its_end_ends_with_the_next_one_or_with_the_file() {
    let file = file("Unit_Diag_Area=0-3\nValue(1)=\"a\"\nUnit_Diag_Area=4-7\nValue(1)=\"b\"");
    assert_eq!(words(&file, &[0x02, 0x11]), ["a", "b"]);
    assert_eq!(problems(&file), [(5, Fault::MissingEnd)]);
}

#[test]
fn values_bits_and_channels_have_the_help_of_revision_5() {
    let file = file(
        "Unit_Diag_Area=0-3\nValue(1)=\"hot\"\nValue_Help(1)=\"cool it\"\nUnit_Diag_Area_End\nUnit_Diag_!Bit(4)=\"no supply\"\n\
         Unit_Diag_!Bit_Help(4)=\"look at the fuse\"\nUnitDiagType=161\nX_Unit_Diag_Area=24-31\nX_Value(2)=\"worn\"\n\
         X_Value_Help(2)=\"replace it\"\nX_Unit_Diag_Area_End\nEndUnitDiagType\nChannel_Diag(16)=\"open\"\nChannel_Diag_Help(16)=\"close it\"",
    );
    assert_eq!(words(&file, &[0x02, 0x01]), ["hot (cool it)", "no supply (look at the fuse)"]);
    assert_eq!(words(&file, &[0x05, 161, 0, 0, 2]), ["worn (replace it)"]);
    assert_eq!(file.device().diagnosis.channel(16).and_then(|words| words.help.as_deref()), Some("close it"));
    assert_eq!(problems(&file), [(7, Fault::InvertedBit)]);
    let again = GsdFile::read(profivac_gsd::text(file.device()).as_bytes());
    assert_eq!(again.device().diagnosis, file.device().diagnosis);
}
