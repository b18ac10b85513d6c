//! `decode`: any file, and octets of a line in any pieces.
//!
//! A file is read at once and in small portions with the same result, and its telegrams are explained. The sentences of a
//! line do not depend on the pieces in which its octets come.

use crate::script::Script;
use profivac_dp::link::{Baud, BitTime};
use profivac_explain::frame::{Chunk, TimeSource};
use profivac_explain::input::{Capture, InputError, Source, SourceKind};
use profivac_explain::{Decoder, ExplainedPiece};
use std::io::Read;

const BAUD: Baud = Baud::B500000;

/// Explains chunks.
fn explain(chunks: &[Chunk], times: TimeSource) -> Vec<ExplainedPiece> {
    let (mut decoder, mut explained) = (Decoder::new(BAUD, times), Vec::new());
    chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    decoder.end(&mut explained);
    for piece in &explained {
        assert!(!piece.piece.octets.is_empty(), "an empty piece");
    }
    explained
}

/// A reader that returns a few octets each time.
struct Slowly<'a>(&'a [u8], usize);

impl Read for Slowly<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.1.min(buffer.len());
        self.0.read(&mut buffer[..count])
    }
}

/// The octets of all chunks, and the damage of the file.
fn read(source: Result<Source<impl Read>, InputError>) -> Result<(Vec<Chunk>, String), InputError> {
    let (mut source, mut chunks) = (source?, Vec::new());
    while source.read(&mut chunks)? {}
    Ok((chunks, format!("{:?} {:?}", source.kind, source.damage)))
}

/// The octets of chunks.
fn octets(chunks: &[Chunk]) -> Vec<u8> {
    chunks.iter().flat_map(|chunk| chunk.octets.iter().copied()).collect()
}

/// A file of any kind.
pub fn file(file: &[u8]) {
    if let Ok(capture) = Capture::read(file, BAUD) {
        let count: usize = capture.chunks.iter().map(|chunk| chunk.octets.len()).sum();
        assert_eq!(capture.octets, count as u64, "the number of octets");
        explain(&capture.chunks, capture.times);
    }
    let size = 1 + file.len() % 7;
    let whole = read(Source::open(file, BAUD)).map(|(chunks, damage)| (octets(&chunks), damage));
    let slowly = read(Source::open(Slowly(file, size), BAUD)).map(|(chunks, damage)| (octets(&chunks), damage));
    assert_eq!(whole, slowly, "at once, and {size} octets each time");
}

/// A text, and a file of octets, whatever the octets look like.
pub fn known_kind(file: &[u8]) {
    for kind in [SourceKind::Text, SourceKind::Octets] {
        if let Ok((chunks, _)) = read(Source::open_as(file, BAUD, kind)) {
            explain(&chunks, TimeSource::Exact);
        }
    }
}

/// Octets of a line with times, pauses and character errors, in pieces of any size.
pub fn line(octets: &[u8]) {
    let mut script = Script::new(octets);
    let (times, mut now) = (script.choice(), BitTime(0));
    let mut chunks = Vec::new();
    while let Some(kind) = script.octet() {
        if kind & 0x40 != 0 {
            now = now + script.pause_tbit();
        }
        let octets = script.piece(100).to_vec();
        let errors = if kind & 0x38 == 0x38 { vec![usize::from(kind & 7)] } else { Vec::new() };
        let errors = errors.into_iter().filter(|error| *error < octets.len()).collect();
        let start = (times & 1 == 0).then_some(now);
        now = now + 11 * octets.len() as u64;
        chunks.push(Chunk { start, octets, errors, is_continued: kind & 0x80 != 0 });
    }
    let all: usize = chunks.iter().map(|chunk| chunk.octets.len()).sum();
    let explained = explain(&chunks, TimeSource::Exact);
    let found: usize = explained.iter().map(|piece| piece.piece.octets.len()).sum();
    assert_eq!(found, all, "every octet is in one piece");
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_telegram_passes() {
        super::file(b"10 08 02 49 53 16\n");
        super::line(&[0, 0x40, 40, 6, 0x10, 8, 2, 0x49, 0x53, 0x16]);
    }
}
