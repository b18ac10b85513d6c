//! One property of real files in each test.

use crate::support::{file, problems};
use profivac_gsd::{Device, Fault, GsdFile, PrmContent, Severity, Tool};

fn constants(device: &Device) -> Vec<(u8, Vec<u8>)> {
    let constant = |item: &profivac_gsd::PrmItem| match &item.content {
        PrmContent::Const(octets) => Some((item.offset, octets.clone())),
        PrmContent::Ref(_) => None,
    };
    device.prm.items.iter().filter_map(constant).collect()
}

fn is_constant(file: &GsdFile, octets: &[u8]) {
    assert_eq!(constants(file.device()), [(0, octets.to_vec())], "{:?}", file.problems());
}

#[test]
fn text_behind_the_header_is_a_remark_with_the_tools_that_object() {
    for header in ["#Profibus_DP ; a GSD file", "#Profibus_DP for all"] {
        let file = GsdFile::read(format!("{header}\nIdent_Number=7\nModule=\"m\" 0x10\nEndModule\n").as_bytes());
        assert_eq!(file.device().general.ident_number, Some(7));
        let [problem] = file.problems() else { panic!("{:?}", file.problems()) };
        assert_eq!((problem.line, problem.fault, problem.severity()), (1, Fault::TextBehindHeader, Severity::Remark));
        assert_eq!(problem.tools(), [Tool::Pyprofibus, Tool::GsdParser]);
        let words = "line 1: text behind #Profibus_DP; move the comment to the next line; not read as meant by pyprofibus 1.13, gsd-parser 0.6.0";
        assert_eq!(problem.to_string(), words);
    }
}

#[test]
fn the_header_may_have_other_capitals_or_be_missing() {
    let file = GsdFile::read(b"#PROFIBUS_DP\nIdent_Number=7\n");
    assert_eq!(problems(&file), [(1, Fault::HeaderCapitals)]);
    let file = GsdFile::read(b"Ident_Number=7\n");
    assert_eq!(problems(&file), [(1, Fault::NoHeader)]);
    assert_eq!(file.device().general.ident_number, Some(7));
}

#[test]
fn only_the_section_of_profibus_dp_is_read() {
    let file = GsdFile::read(
        b"; first\nIdent_Number=7\nThis is a \"file, \\\n#Profibus_DP\nIdent_Number=8\nPrmText=1\n#Other\nVendor_Name=\"x\nModel_Name=\"y\"\n",
    );
    let general = &file.device().general;
    assert_eq!(
        (general.ident_number, general.vendor_name.as_deref(), general.model_name.as_deref()),
        (Some(8), None, None)
    );
    assert_eq!(problems(&file), [(2, Fault::TextBeforeHeader), (7, Fault::SectionEnd)]);
    assert!(file.device().others.is_empty());
    let file = GsdFile::read(b"#Profibus_DP\nIdent_Number=7\n#profibus_dp\nMax_Module=2\n");
    assert_eq!((file.device().general.ident_number, file.device().general.max_module), (Some(7), Some(2)));
    let file = GsdFile::read(b"Max_Module=2\n#Other\nIdent_Number=7\n");
    assert_eq!((file.device().general.ident_number, file.device().general.max_module), (Some(7), Some(2)), "no header");
}

#[test]
fn a_list_goes_on_behind_a_backslash_with_blanks_and_comments() {
    is_constant(&file("Ext_User_Prm_Data_Const(0)=0x80,\\\n0x01,0x02"), &[0x80, 1, 2]);
    let with_comment = file("Ext_User_Prm_Data_Const(0)=0x80,\\  ; status\n0x01,\\\t\n0x02 ; end");
    is_constant(&with_comment, &[0x80, 1, 2]);
    let expected = [(3, Fault::CommentBehindContinuation), (4, Fault::BlankBehindContinuation)];
    assert_eq!(problems(&with_comment), expected);
    is_constant(&file("Ext_User_Prm_Data_Const(0)=0x80\\\r\n,0x01"), &[0x80, 1]);
}

#[test]
fn comments_stand_between_the_lines_of_a_list() {
    is_constant(&file("Ext_User_Prm_Data_Const(0)=0x80,\\\n; 0x07,\\\n  ; more\n0x02"), &[0x80, 2]);
}

#[test]
fn a_commented_list_that_ends_with_a_backslash_takes_no_line_with_it() {
    let file = file(";Ext_User_Prm_Data_Const(0)=0x80,\\\n;  0x01,\\\nExt_User_Prm_Data_Const(0)=0x02");
    is_constant(&file, &[2]);
    assert_eq!(problems(&file), []);
}

#[test]
fn a_backslash_in_front_of_a_keyword_ends_nothing() {
    let file = file("Ext_User_Prm_Data_Const(0)=0x80,0x01\\\nMax_Module=3\nModule=\"m\" 0x10 \\\nEndModule");
    is_constant(&file, &[0x80, 1]);
    assert_eq!(file.device().general.max_module, Some(3));
    assert_eq!(file.device().modules.len(), 1);
    assert_eq!(problems(&file), [(3, Fault::ContinuationOfNothing), (5, Fault::ContinuationOfNothing)]);
}

#[test]
fn a_list_goes_on_behind_a_comma_without_a_backslash() {
    let file = file("Ext_User_Prm_Data_Const(0)=0x80,\n0x01,0x02\nMax_Module=3");
    is_constant(&file, &[0x80, 1, 2]);
    assert_eq!(problems(&file), [(4, Fault::ListWithoutContinuation)]);
}

#[test]
fn a_list_that_ends_with_a_comma_takes_no_keyword_that_starts_with_a_digit() {
    for keyword in ["9.6_supp=1", "500_supp = 1", "12M_supp=1", "24V_Pins=2"] {
        let file = file(&format!("Ext_User_Prm_Data_Const(0)=0x80,\n{keyword}"));
        is_constant(&file, &[0x80]);
        let (rates, pins) = (file.device().rates.len(), file.device().general.pins_24v);
        assert!(rates == 1 || pins == Some(2), "{keyword}");
        assert_eq!(problems(&file), [], "{keyword}");
    }
}

#[test]
fn a_number_alone_behind_a_module_that_ends_with_a_comma_is_its_number() {
    let module = |lines: &str| {
        let file = file(&format!("Module=\"m\" 0x10,\n{lines}\nEndModule"));
        file.device().modules.first().map(|module| (module.config.clone(), module.number, module.numbered))
    };
    assert_eq!(module("7"), Some((vec![0x10], 7, true)));
    assert_eq!(module("7 ; number"), Some((vec![0x10], 7, true)));
    assert_eq!(module("0x20\n7"), Some((vec![0x10, 0x20], 7, true)));
    assert_eq!(module("32,33\n7"), Some((vec![0x10, 32, 33], 7, true)));
}

#[test]
fn a_text_goes_on_in_the_next_line() {
    let marked = file("Info_Text=\"one \\\ntwo; three \\ \nfour\" ; comment\nMax_Module=3");
    assert_eq!(marked.device().general.info_text.as_deref(), Some("one two; three four"));
    assert_eq!(problems(&marked), []);
    let unmarked = file("Info_Text=\"one\n two\"\nMax_Module=3");
    assert_eq!(unmarked.device().general.info_text.as_deref(), Some("one  two"));
    assert_eq!(problems(&unmarked), [(3, Fault::StringWithoutContinuation)]);
    assert_eq!((marked.device().general.max_module, unmarked.device().general.max_module), (Some(3), Some(3)));
}

#[test]
fn a_text_without_its_closing_mark_takes_no_line_without_a_mark() {
    let file = file("Module=\"one\n7\nEndModule\nVendor_Name=\"two\"");
    let module = file.device().modules.first().expect("a module");
    assert_eq!((module.name.as_str(), module.number), ("one", 7));
    assert_eq!(problems(&file), [(3, Fault::OpenString)]);
}

#[test]
fn a_text_without_its_closing_mark_ends_with_the_line() {
    let file = file("Vendor_Name=\"one\nModel_Name=\"two\"");
    assert_eq!(file.device().general.vendor_name.as_deref(), Some("one"));
    assert_eq!(file.device().general.model_name.as_deref(), Some("two"));
    assert_eq!(problems(&file), [(3, Fault::OpenString)]);
}

#[test]
fn semicolons_and_quotation_marks_stand_in_texts() {
    let file = file(
        "Vendor_Name=\"a; b\" ; c\nModel_Name=\"a \"big\" one\"\nModule=\"pipe 4\" wide\" 0x10,0x20 ; in \"inches\"\nEndModule",
    );
    assert_eq!(file.device().general.vendor_name.as_deref(), Some("a; b"));
    assert_eq!(file.device().general.model_name.as_deref(), Some("a \"big\" one"));
    let module = file.device().modules.first().expect("a module");
    assert_eq!((module.name.as_str(), module.config.as_slice()), ("pipe 4\" wide", [0x10, 0x20].as_slice()));
    assert_eq!(problems(&file), [(4, Fault::QuoteInText), (5, Fault::ModuleName), (5, Fault::QuoteInText)]);
}

#[test]
fn names_that_a_tool_leaves_out_are_one_remark() {
    let file =
        file("Module=\"a.b/c <1>\" 0x10\nEndModule\nModule=\"d'e\" 0x10\nEndModule\nModule=\"f;g\" 0x10\nEndModule");
    assert_eq!(problems(&file), [(5, Fault::ModuleName)]);
    assert_eq!(file.problems().first().map(|problem| problem.found.as_str()), Some("d'e, and 1 more"));
}

#[test]
fn words_behind_a_text_are_ignored() {
    let file = file("Vendor_Name=\"one\" two\nModel_Name=\"three\"");
    assert_eq!(file.device().general.vendor_name.as_deref(), Some("one"));
    assert_eq!(problems(&file), [(3, Fault::TextBehindString)]);
}

#[test]
fn the_octets_before_a_wrong_value_count_and_the_rest_is_a_problem() {
    let module = |octets: &str| file(&format!("Module=\"m\" {octets}\nEndModule"));
    let config = |file: &GsdFile| file.device().modules.first().map(|module| module.config.clone());
    for (octets, kept, fault) in [
        ("0x10 valve", vec![0x10], Fault::BadOctet),
        ("0x10,0x100,0x20", vec![0x10], Fault::BadOctet),
        ("valve", vec![], Fault::BadOctet),
        ("0x10,,0x20", vec![0x10, 0x20], Fault::RepeatedComma),
        ("0x10,,0x20 valve", vec![0x10, 0x20], Fault::BadOctet),
    ] {
        let file = module(octets);
        assert_eq!(config(&file), Some(kept), "{octets}");
        let faults: Vec<_> =
            problems(&file).into_iter().filter(|(_, fault)| *fault != Fault::TextBehindString).collect();
        assert_eq!(faults, [(3, fault)], "{octets}");
    }
    let constant = file("Ext_User_Prm_Data_Const(0)=0x80,,0x00");
    is_constant(&constant, &[0x80, 0x00]);
    assert_eq!(problems(&constant), [(3, Fault::RepeatedComma)]);
    let plain = file("User_Prm_Data=1,2 three");
    assert_eq!(plain.device().user_prm_data, Some(vec![1, 2]));
    assert_eq!(problems(&plain), [(3, Fault::BadOctet)]);
    let none = file("Ext_User_Prm_Data_Const(0)=all");
    assert_eq!(problems(&none), [(3, Fault::BadValue)], "no octet, so the line is kept as it is");
}

#[test]
fn blanks_may_be_missing() {
    let file = file("ExtUserPrmData=1\"p\"\nBitArea(1-2)1 0-3\nEndExtUserPrmData\nModule=\"m\"0x10,0x20\nEndModule");
    let parameter = file.device().parameters.get(&1).expect("a parameter");
    assert_eq!((parameter.default, parameter.allowed.as_slice()), (1, [(0, 3)].as_slice()));
    assert_eq!(file.device().modules.first().map(|module| module.config.clone()), Some(vec![0x10, 0x20]));
    assert_eq!(problems(&file), [(6, Fault::ModuleBlank)]);
}

#[test]
fn a_capital_x_is_a_number_and_a_leading_zero_is_decimal() {
    let file = file("Ext_User_Prm_Data_Const(0)=0X1F,010,08,0\nMax_Module=012");
    is_constant(&file, &[0x1F, 10, 8, 0]);
    assert_eq!(file.device().general.max_module, Some(12));
    let [(3, Fault::CapitalX)] = problems(&file)[..] else { panic!("{:?}", file.problems()) };
}

#[test]
fn keywords_have_any_capitals() {
    let file = file("MAX_MODULE=3\nMODULE=\"m\" 0x10\nPRESET=1\nENDMODULE");
    assert_eq!(file.device().general.max_module, Some(3));
    assert!(file.device().modules.first().is_some_and(|module| module.preset));
    assert_eq!(problems(&file), [3, 4, 5, 6].map(|line| (line, Fault::Capitals)));
}

#[test]
fn a_blank_in_a_keyword_stands_for_an_underscore() {
    let file = file("24V Pins\t= 2");
    assert_eq!(file.device().general.pins_24v, Some(2));
    assert_eq!(problems(&file), [(3, Fault::BlankInKeyword)]);
}

#[test]
fn unknown_keywords_and_lines_stay_with_their_lines() {
    let file = file("Colour = \"red\" ; nice\n17,18\nModule=\"m\" 0x10\nShape = 3\nEndModule");
    let others: Vec<_> = file.device().others.iter().map(|other| (other.line, other.text.as_str())).collect();
    assert_eq!(others, [(3, "Colour = \"red\""), (4, "17,18")]);
    let module = file.device().modules.first().expect("a module");
    assert_eq!(module.others.first().map(|other| (other.line, other.text.as_str())), Some((6, "Shape = 3")));
    let expected = [(3, Fault::UnknownKeyword), (4, Fault::NoKeyword), (6, Fault::UnknownKeyword)];
    assert_eq!(problems(&file), expected);
}

#[test]
fn a_value_that_cannot_be_read_refuses_only_its_line() {
    let file = file("Max_Module=many\nMax_Input_Len=99999999999\nPrmText=x\nMax_Output_Len=7");
    assert_eq!(file.device().general.max_output_len, Some(7));
    let expected = [(3, Fault::BadValue), (4, Fault::OutOfRange), (5, Fault::BadValue)];
    assert_eq!(problems(&file), expected);
}

#[test]
fn a_block_without_its_end_is_closed_by_the_next_one() {
    let file = file("Module=\"a\" 0x10\nModule=\"b\" 0x20\nEndPrmText\nEndModule");
    let names: Vec<_> = file.device().modules.iter().map(|module| module.name.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(problems(&file), [(4, Fault::MissingEnd), (5, Fault::MissingEnd), (6, Fault::StrayEnd)]);
}

#[test]
fn the_lines_together_are_the_text() {
    let text = "; top\r\n\r\n#Profibus_DP\rModule=\"a \\\n b\" 1,\\ ; c\n; d\n2\n\x1a";
    let file = GsdFile::read(text.as_bytes());
    assert_eq!(file.lines().map(|(_, line)| line).collect::<String>(), text);
    let numbers: Vec<_> = file.lines().map(|(number, _)| number).collect();
    assert_eq!(numbers, [1, 2, 3, 4, 8]);
}

/// A file of a few megabytes must not cost hours.
#[test]
fn modules_parameters_values_and_octets_beyond_the_limits_are_one_problem_each() {
    let many = |count: usize, line: &str| line.repeat(count);
    let modules = many(10_002, "Module=\"m\" 0x10\nEndModule\n");
    let read = file(&modules);
    assert_eq!(read.device().modules.len(), 10_000);
    assert_eq!(read.problems().iter().filter(|one| one.fault == Fault::TooMany).count(), 1);

    let texts: String = (0..50_000).map(|value| format!("Text({value})=\"t\"\n")).collect();
    let parameter = "ExtUserPrmData=1 \"p\"\nUnsigned16 0 0-60000\nPrm_Text_Ref=1\nEndExtUserPrmData\n";
    let items = many(50_000, "Ext_User_Prm_Data_Ref(0)=1\n");
    let read = file(&format!("PrmText=1\n{texts}EndPrmText\n{parameter}{items}"));
    assert_eq!(read.device().prm.items.len(), 2_048);
    let reading = read.device().read_station_prm(&[0xC3, 0x4F]);
    assert_eq!(reading.values.last().and_then(|value| value.text), Some("t"));

    let values = many(10_001, "1,");
    let read = file(&format!("ExtUserPrmData=1 \"p\"\nUnsigned8 0 {values}1\nEndExtUserPrmData\n"));
    assert!(read.device().parameters[&1].allowed.is_empty());
    assert!(read.problems().iter().any(|one| one.fault == Fault::TooMany));

    let octets = vec!["0x10"; 245].join(",");
    let read = file(&format!("User_Prm_Data={octets}\nModule=\"m\" {octets}\nEndModule\n"));
    assert_eq!(read.device().modules[0].config.len(), 244);
    assert_eq!(read.device().user_prm_data.as_ref().map(Vec::len), Some(244));
}

#[test]
fn of_two_texts_for_one_value_the_last_counts_and_is_a_problem() {
    let read = file("PrmText=1\nText(0)=\"first\"\nText(0)=\"second\"\nEndPrmText");
    assert!(read.device().texts[&1].texts.values().eq(["second"]));
    assert_eq!(problems(&read), [(5, Fault::Repeated)]);
}
