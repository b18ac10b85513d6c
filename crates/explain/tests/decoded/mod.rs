//! The decoder over a whole capture.

use profivac_dp::link::Baud;
use profivac_explain::input::Capture;
use profivac_explain::{Decoder, ExplainedPiece};

/// The decoder behind the end of a capture, and the pieces that it has explained.
pub fn decoded(capture: &Capture, baud: Baud) -> (Decoder, Vec<ExplainedPiece>) {
    let (mut decoder, mut explained) = (Decoder::new(capture.clock, capture.times).with_line_rate(baud), Vec::new());
    capture.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    decoder.end(&mut explained);
    (decoder, explained)
}
