use profivac_gsd::{Encoding, Fault, GsdFile, Severity, Tool};

fn module(name: &[u8]) -> Vec<u8> {
    [b"#Profibus_DP\r\nIdent_Number=1\r\nModule=\"", name, b"\" 0x10\r\nEndModule\r\n"].concat()
}

fn name_and_encoding(octets: &[u8]) -> (String, Encoding) {
    let file = GsdFile::read(octets);
    assert_eq!(file.octets(), octets, "the octets stay");
    (file.device().modules.first().expect("a module").name.clone(), file.encoding())
}

#[test]
fn each_code_page_is_told_by_its_letters() {
    let cases: [(&[u8], &str, Encoding); 11] = [
        (b"Geraet", "Geraet", Encoding::Ascii),
        ("Gerät".as_bytes(), "Gerät", Encoding::Utf8),
        (b"Ger\xE4t mit \xDCberlauf", "Gerät mit Überlauf", Encoding::Cp1252),
        (b"r\xE9gulateur d\x92entr\xE9e", "régulateur d’entrée", Encoding::Cp1252),
        (b"8 sorties \xE0 relais", "8 sorties à relais", Encoding::Cp1252),
        (b"500 \xB5s", "500 µs", Encoding::Cp1252),
        (b"filter 5 \xB5", "filter 5 µ", Encoding::Cp1252),
        (b"500\xB5s", "500µs", Encoding::Cp1252),
        (b"Ger\x84t mit \x9Aberlauf", "Gerät mit Überlauf", Encoding::Cp850),
        (b"r\x82gulateur d'entr\x82e", "régulateur d'entrée", Encoding::Cp850),
        (b"20\xF8C, 500 \xE6s", "20°C, 500 µs", Encoding::Cp850),
    ];
    for (octets, name, encoding) in cases {
        let (found, detected) = name_and_encoding(&module(octets));
        assert_eq!(detected, encoding, "{octets:02X?} as {found}");
        assert_eq!(found, name);
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_text_and_stays_in_the_octets() {
    let octets = [b"\xEF\xBB\xBF".as_slice(), &module("Gerät".as_bytes())].concat();
    assert_eq!(name_and_encoding(&octets), ("Gerät".to_owned(), Encoding::Utf8Bom));
    let file = GsdFile::read(&octets);
    assert!(file.text().starts_with("#Profibus_DP"));
    let [problem, ..] = file.problems() else { panic!("no problem") };
    assert_eq!((problem.line, problem.fault), (1, Fault::MarkBeforeHeader));
    let octets = [b"\xEF\xBB\xBF; a comment\r\n".as_slice(), &module("Gerät".as_bytes())].concat();
    let file = GsdFile::read(&octets);
    assert!(
        file.problems().iter().all(|problem| problem.fault != Fault::MarkBeforeHeader),
        "tools pass over a comment"
    );
}

/// An editor saves a file as "Unicode".
#[test]
fn a_file_in_utf_16_is_read_and_is_a_remark_with_the_tools_that_object() {
    let text = String::from_utf8(module("Gerät 5 Ω".as_bytes())).unwrap();
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for (octets, encoding, name) in [
        ([b"\xFF\xFE".as_slice(), &little].concat(), Encoding::Utf16LeBom, "UTF-16LE with byte order mark"),
        ([b"\xFE\xFF".as_slice(), &big].concat(), Encoding::Utf16BeBom, "UTF-16BE with byte order mark"),
        (little.clone(), Encoding::Utf16Le, "UTF-16LE"),
        (big, Encoding::Utf16Be, "UTF-16BE"),
    ] {
        assert_eq!(name_and_encoding(&octets), ("Gerät 5 Ω".to_owned(), encoding));
        assert_eq!(encoding.to_string(), name);
        assert!(encoding.is_utf16());
        let file = GsdFile::read(&octets);
        let [problem, ..] = file.problems() else { panic!("no problem") };
        assert_eq!((problem.line, problem.fault, problem.severity()), (1, Fault::Utf16, Severity::Remark));
        assert_eq!(problem.tools(), [Tool::Pyprofibus, Tool::GsdParser]);
    }
    // A file that is cut within a character, or has half of a pair, keeps its octets in another code.
    for damaged in [&little[..little.len() - 1], &[little.as_slice(), b"\x00\xD8"].concat()] {
        let file = GsdFile::read(damaged);
        assert!(!file.encoding().is_utf16());
        assert_eq!(file.octets(), damaged);
        let marked = GsdFile::read(&[b"\xFF\xFE", damaged].concat());
        assert_eq!(marked.problems()[0].fault, Fault::DamagedUtf16);
    }
}

#[test]
fn every_octet_of_a_code_page_becomes_a_character_and_the_octet_again() {
    let all: Vec<u8> = (0..=255).collect();
    for encoding in [Encoding::Cp1252, Encoding::Cp850, Encoding::Cp437] {
        let text = encoding.decode(&all);
        assert_eq!(text.chars().count(), 256, "{encoding}");
        assert_eq!(encoding.encode(&text), Ok(all.clone()), "{encoding}");
    }
    assert_eq!(Encoding::Cp437.decode(b"\x9E\xE3\xE6"), "₧πµ");
    assert_eq!(Encoding::Cp850.decode(b"\x9E\xE3\xE6"), "×Òµ");
    assert_eq!(Encoding::Cp1252.decode(b"\x80\xA0\xFF"), "€\u{a0}ÿ");
}

#[test]
fn a_character_that_the_code_page_lacks_is_named() {
    assert_eq!(Encoding::Cp1252.encode("x → y"), Err('→'));
    assert_eq!(Encoding::Ascii.encode("é"), Err('é'));
}
