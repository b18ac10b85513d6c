//! Tests of the framer.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use super::*;
use profivac_sim::Random;
use profivac_sim::dialogue::hex;
use profivac_wire::{DataTelegram, Telegram};

fn chunk(octets: &[u8]) -> Chunk {
    Chunk { octets: octets.to_vec(), ..Chunk::default() }
}

fn framed(chunks: &[&[u8]]) -> Vec<Piece> {
    let (mut framer, mut out) = (Framer::default(), Vec::new());
    chunks.iter().for_each(|octets| framer.push(&chunk(octets), &mut out));
    framer.flush(&mut out);
    out
}

fn kinds_and_octets(pieces: &[Piece]) -> Vec<(PieceKind, String)> {
    pieces.iter().map(|piece| (piece.kind, profivac_sim::describe::Hex(&piece.octets).to_string())).collect()
}

fn random_telegram(random: &mut Random, checked: bool) -> Vec<u8> {
    let du: Vec<u8> = (0..random.below(30)).map(|_| random.octet()).collect();
    let (da, sa) = (random.octet() & 0x7F, random.octet() & 0x7F);
    let sap = |random: &mut Random| (random.below(2) == 0).then(|| random.octet());
    let telegram = match random.below(if checked { 6 } else { 8 }) {
        0 => Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc: 0x49, du: &[] }),
        6 => Telegram::ShortAck,
        7 => Telegram::Token { da: da.min(126), sa: sa.min(126) },
        _ => Telegram::Data(DataTelegram { da, sa, dsap: sap(random), ssap: sap(random), fc: random.octet(), du: &du }),
    };
    let mut out = [0; MAX_TELEGRAM];
    let length = telegram.emit(&mut out).unwrap();
    out[..length].to_vec()
}

/// Damaged octets: noise, a telegram with a flipped bit, one with an octet lost or inserted, or one that was cut off.
fn damaged_octets(random: &mut Random) -> Vec<u8> {
    let mut octets = random_telegram(random, true);
    let index = random.below(octets.len() as u64) as usize;
    match random.below(5) {
        0 => octets = (0..random.below(20)).map(|_| random.octet()).collect(),
        1 => octets[index] ^= 1 << random.below(8),
        2 => drop(octets.remove(index)),
        3 => octets.insert(index, random.octet()),
        _ => octets.truncate(index),
    }
    octets
}

/// The position of a telegram, and its octets.
type Placed = (usize, Vec<u8>);

/// Valid telegrams with damaged octets between them, and the positions of the valid ones.
fn line(random: &mut Random) -> (Vec<Vec<u8>>, Vec<Placed>) {
    let (mut line, mut valid, mut at) = (Vec::new(), Vec::new(), 0);
    for _ in 0..10 {
        let damaged = if random.below(2) == 0 { damaged_octets(random) } else { Vec::new() };
        let telegram = random_telegram(random, false);
        valid.push((at + damaged.len(), telegram.clone()));
        at += damaged.len() + telegram.len();
        line.extend([damaged, telegram]);
    }
    (line, valid)
}

/// The pieces of a line and their positions: with the time of each chunk, or in random chunks without times.
fn pieces(random: &mut Random, line: &[Vec<u8>], timed: bool) -> Vec<(usize, Piece)> {
    let (mut framer, mut pieces, octets) = (Framer::default(), Vec::new(), line.concat());
    if timed {
        for (number, octets) in (0..).zip(line) {
            framer.push(&Chunk { start: Some(BitTime(number * 10_000)), ..chunk(octets) }, &mut pieces);
            framer.flush(&mut pieces);
        }
    } else {
        let mut rest = &octets[..];
        while !rest.is_empty() {
            let (octets, more) = rest.split_at(rest.len().min(1 + random.below(40) as usize));
            framer.push(&chunk(octets), &mut pieces);
            rest = more;
        }
        framer.flush(&mut pieces);
    }
    assert_eq!(
        pieces.iter().flat_map(|piece| piece.octets.clone()).collect::<Vec<_>>(),
        octets,
        "the pieces have all octets of the line"
    );
    let mut at = 0;
    let begins = pieces.into_iter().map(|piece| {
        at += piece.octets.len();
        (at - piece.octets.len(), piece)
    });
    begins.collect()
}

#[test]
fn with_times_the_framer_finds_every_valid_telegram_between_damaged_octets() {
    let mut random = Random::new(8);
    for _ in 0..4_000 {
        let (line, valid) = line(&mut random);
        let pieces = pieces(&mut random, &line, true);
        for (at, telegram) in valid {
            let found = |(from, piece): &(usize, Piece)| {
                *from == at && piece.octets == telegram && piece.kind == PieceKind::Valid
            };
            assert!(pieces.iter().any(found), "{telegram:02X?} in {line:02X?}");
        }
    }
}

/// Without times two divisions are possible for a token whose last octet completes a damaged telegram, and for an SD1 at the
/// announced end of a telegram that was cut off. The framer finds every longer telegram.
#[test]
fn without_times_the_framer_misses_only_telegrams_of_six_octets_or_less_inside_longer_ones() {
    let (mut random, mut missed) = (Random::new(9), 0);
    for _ in 0..4_000 {
        let (line, valid) = line(&mut random);
        let pieces = pieces(&mut random, &line, false);
        for (at, telegram) in valid {
            let found = |(from, piece): &(usize, Piece)| {
                *from == at && piece.octets == telegram && piece.kind != PieceKind::Damaged
            };
            if pieces.iter().any(found) {
                continue;
            }
            let overlaps = |(from, piece): &&(usize, Piece)| {
                piece.kind == PieceKind::Valid && *from < at + telegram.len() && at < from + piece.octets.len()
            };
            let longer = pieces.iter().find(|piece| overlaps(piece) && piece.1.octets.len() > telegram.len());
            assert!(telegram.len() <= 6 && longer.is_some(), "{telegram:02X?} in {line:02X?}");
            missed += 1;
        }
    }
    assert!(missed < 10, "{missed} of 40000");
}

#[test]
fn the_framer_takes_telegrams_inside_the_data_of_a_valid_one_for_data() {
    // FDL_Status, SC and a token in the data of a Data_Exchange.
    let outer = hex("68 0D 0D 68 08 02 7D 10 08 02 49 53 16 E5 DC 02 02 18 16");
    assert_eq!(
        kinds_and_octets(&framed(&[&outer])),
        [(PieceKind::Valid, profivac_sim::describe::Hex(&outer).to_string())]
    );
    // If the outer telegram is damaged, the inner ones are pieces: valid with a check octet, doubtful without one.
    let mut damaged = outer;
    damaged[17] ^= 1;
    let expected = [
        (PieceKind::Damaged, "68 0D 0D 68 08 02 7D"),
        (PieceKind::Valid, "10 08 02 49 53 16"),
        (PieceKind::Doubtful, "E5"),
        (PieceKind::Doubtful, "DC 02 02"),
        (PieceKind::Damaged, "19 16"),
    ];
    assert_eq!(kinds_and_octets(&framed(&[&damaged])), expected.map(|(kind, text)| (kind, text.to_owned())));
}

#[test]
fn the_framer_finds_an_sd3_but_prefers_two_other_telegrams() {
    let sd3 = hex("A2 08 02 7D 01 02 03 04 05 06 07 08 AB 16");
    assert_eq!(framed(&[&sd3])[0].kind, PieceKind::Valid);
    // The check octet and the end delimiter of the SD3 fit by chance.
    let octets = hex("A2 DE 10 1A 13 49 76 16 10 42 24 49 AF 16");
    let expected = [
        (PieceKind::Damaged, "A2 DE"),
        (PieceKind::Valid, "10 1A 13 49 76 16"),
        (PieceKind::Valid, "10 42 24 49 AF 16"),
    ];
    assert!(Telegram::parse(&octets).is_ok());
    assert_eq!(
        kinds_and_octets(&framed(&[&[0], &octets])[1..]),
        expected[1..].iter().map(|(kind, text)| (*kind, (*text).to_owned())).collect::<Vec<_>>()
    );
}

#[test]
fn the_framer_prefers_a_telegram_with_a_check_octet_to_a_token_that_overlaps_it() {
    let octets = hex("DC 10 08 02 49 53 16");
    let expected = [(PieceKind::Damaged, "DC"), (PieceKind::Valid, "10 08 02 49 53 16")];
    assert_eq!(kinds_and_octets(&framed(&[&octets])), expected.map(|(kind, text)| (kind, text.to_owned())));
}

#[test]
fn the_framer_puts_an_octet_with_a_character_error_into_a_damaged_piece() {
    let (mut framer, mut out) = (Framer::default(), Vec::new());
    let octets = chunk(&hex("10 08 02 49 53 16 E5"));
    framer.push(&Chunk { start: Some(BitTime(100)), errors: vec![2], ..octets }, &mut out);
    framer.flush(&mut out);
    assert_eq!(
        kinds_and_octets(&out),
        [(PieceKind::Damaged, "10 08 02 49 53 16".to_owned()), (PieceKind::Doubtful, "E5".to_owned())]
    );
    assert_eq!((out[0].errors.as_slice(), out[1].start), (&[2][..], Some(BitTime(166))));
}

#[test]
fn the_framer_returns_a_complete_telegram_at_once_and_damaged_octets_with_the_next_telegram() {
    let (mut framer, mut out) = (Framer::default(), Vec::new());
    framer.push(&chunk(&hex("68 05 05 68 88 82 6D")), &mut out);
    assert!(out.is_empty());
    framer.push(&chunk(&hex("3C 3E F1 16")), &mut out);
    assert_eq!(out.len(), 1);
    framer.push(&chunk(&hex("68 05 05 68 88")), &mut out);
    framer.push(&chunk(&hex("10 08 02 49 53 16")), &mut out);
    let kinds: Vec<_> = out.iter().map(|piece| piece.kind).collect();
    assert_eq!(kinds, [PieceKind::Valid, PieceKind::Damaged, PieceKind::Valid]);
}

/// The noise of which each octet or each few octets may begin a telegram.
fn periodic_noise() -> Vec<Vec<u8>> {
    let every = |octet: u8, period: usize| [&[octet][..], &vec![0; period - 1]].concat();
    let mut noise = vec![every(0x10, 6), every(0xA2, 14), every(0xDC, 3), every(0x68, 4)];
    noise.extend([vec![0x68], vec![0x10], vec![0], vec![0xE5], vec![0xDC], vec![0xFF], vec![0xDC, 1, 2]]);
    // Headers of the longest telegram, telegrams inside telegrams, and a telegram without end.
    noise.extend([hex("68 F9 F9 68"), hex("68 03 03 68 10 00 00 00 00 16 16"), hex("68 68 68 68 16")]);
    // Valid SD3 telegrams without end, each of which overlaps the next one by two octets.
    noise.push(hex("A2 16 02 49 41 00 00 00 00 00 00 00"));
    noise
}

#[test]
fn the_work_is_proportional_to_the_octets_of_any_noise_and_few_octets_are_held() {
    for noise in periodic_noise() {
        for portion in [1, 7, 4096] {
            let (mut framer, mut out, mut work) = (Framer::default(), Vec::new(), Vec::new());
            let mut octets = noise.iter().copied().cycle();
            for _ in 0..4 {
                for _ in 0..40_960 / portion {
                    let octets: Vec<u8> = octets.by_ref().take(portion).collect();
                    framer.push(&Chunk { is_continued: true, ..chunk(&octets) }, &mut out);
                    out.clear();
                    let longest = MAX_DAMAGED + MAX_CHAIN + MAX_TELEGRAM;
                    assert!(framer.held() <= longest, "{noise:02X?}: {}", framer.held());
                }
                work.push(framer.work());
            }
            // The last quarter is not more work than the second one; the first octets of each wait for those behind.
            assert!(work[3] - work[2] <= work[1] - work[0] + 10_000, "{noise:02X?} in {portion}: {work:?}");
            assert!(work[3] <= 4 * 40_960 * 2 * MAX_TELEGRAM as u64, "{noise:02X?} in {portion}: {work:?}");
        }
    }
}

/// Chunks that continue each other have the pieces of one chunk.
#[test]
fn the_pieces_do_not_depend_on_the_sizes_of_portions() {
    let mut random = Random::new(10);
    for _ in 0..1_000 {
        let octets = line(&mut random).0.concat();
        let whole = framed(&[&octets]);
        let (mut framer, mut out, mut rest) = (Framer::default(), Vec::new(), &octets[..]);
        while !rest.is_empty() {
            let (part, more) = rest.split_at(rest.len().min(1 + random.below(40) as usize));
            framer.push(&Chunk { is_continued: !more.is_empty(), ..chunk(part) }, &mut out);
            rest = more;
        }
        framer.flush(&mut out);
        assert_eq!(out, whole, "{octets:02X?}");
    }
}

#[test]
fn the_framer_gives_up_a_telegram_that_began_too_early() {
    let (mut framer, mut out) = (Framer::new(TimeSource::Platform), Vec::new());
    framer.push(&Chunk { start: Some(BitTime(100)), ..chunk(&hex("00 68 05 05 68 88")) }, &mut out);
    framer.push(&Chunk { start: Some(BitTime(200)), ..chunk(&hex("68 05 05 68")) }, &mut out);
    framer.give_up(BitTime(100), &mut out);
    assert!(out.is_empty());
    framer.give_up(BitTime(101), &mut out);
    assert_eq!(kinds_and_octets(&out), [(PieceKind::Damaged, "00 68 05 05 68 88".to_owned())]);
    framer.push(&Chunk { start: Some(BitTime(300)), ..chunk(&hex("88 82 6D 3C 3E F1 16")) }, &mut out);
    assert_eq!((out.len(), out[1].kind, out[1].start), (2, PieceKind::Valid, Some(BitTime(200))));
}
