//! Recorded traffic, explained.

use crate::devices;
use crate::failure::Failure;
use crate::whole::Whole;
use profivac_devices::catalog::KnownDevices;
use profivac_dp::link::Baud;
use profivac_explain::frame::PieceKind;
use profivac_explain::gsd::Files;
use profivac_explain::input::Capture;
use profivac_explain::note::Note;
use profivac_explain::{Decoder, ExplainedPiece};
use profivac_host::clock::duration_of;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// Station, subject, sentence.
type NoteRow = (Option<u8>, &'static str, String);

/// Time in s, octets, kind, meaning, notes.
type PieceRow = (Option<f64>, Py<PyBytes>, &'static str, String, Vec<NoteRow>);

/// Decodes a capture, a trace, a log or the octets of a line.
#[pyfunction]
pub fn decode(py: Python<'_>, file: Vec<u8>, baud: Whole<u32>, device_files: Vec<PathBuf>) -> PyResult<Vec<PieceRow>> {
    let Whole(baud) = baud;
    let baud = Baud::from_bits_per_second(baud)
        .ok_or_else(|| Failure::usage(format!("expected a PROFIBUS rate in bit/s, such as 19200, got {baud}")))?;
    let known = devices::known(&device_files)?;
    let (clock, explained) = py.detach(|| explain(&file, baud, known))?;
    Ok(explained.into_iter().map(|it| piece_row(py, clock, it)).collect())
}

/// The rate whose bit times the times are, and the pieces.
fn explain(file: &[u8], baud: Baud, known: KnownDevices) -> Result<(Baud, Vec<ExplainedPiece>), Failure> {
    let capture = Capture::read(file, baud).map_err(Failure::usage)?;
    let line = capture.baud.unwrap_or(baud);
    let decoder = Decoder::new(capture.clock, capture.times).with_line_rate(line);
    let (mut decoder, mut explained) = (decoder.with_gsd(Files::default().with_devices(known)), Vec::new());
    for chunk in &capture.chunks {
        decoder.push(chunk, &mut explained);
    }
    decoder.end(&mut explained);
    if decoder.explainer().summary().telegrams == 0 {
        return Err(Failure::usage(format!(
            "expected telegrams, none of {} octets belongs to a valid one",
            capture.octets
        )));
    }
    match capture.damage {
        Some(damage) => Err(Failure::usage(damage)),
        None => Ok((capture.clock, explained)),
    }
}

fn piece_row(py: Python<'_>, clock: Baud, explained: ExplainedPiece) -> PieceRow {
    let ExplainedPiece { piece, meaning, notes, .. } = explained;
    let kind = match piece.kind {
        PieceKind::Valid => "telegram",
        PieceKind::Doubtful => "doubtful",
        PieceKind::Damaged => "damaged",
    };
    let seconds = piece.start.map(|start| duration_of(clock, start.0).as_secs_f64());
    let notes = notes.into_iter().map(|Note { station, kind, text, .. }| (station, kind.name(), text)).collect();
    (seconds, PyBytes::new(py, &piece.octets).unbind(), kind, meaning, notes)
}
