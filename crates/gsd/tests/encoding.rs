use profivac_gsd::{Encoding, GsdFile};

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
    assert!(GsdFile::read(&octets).text().starts_with("#Profibus_DP"));
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
