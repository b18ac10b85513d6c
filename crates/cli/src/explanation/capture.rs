//! The capture file that is written beside the explanation.

use super::PrintOptions;
use crate::failure::Failure;
use profivac_dp::link::{Baud, BitTime, T_SYN_TBIT};
use profivac_explain::ExplainedPiece;
use profivac_sim::trace::Entry;
use profivac_sim::trace::pcapng::{self, Times};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A capture file that grows with every telegram.
pub struct Capture {
    path: PathBuf,
    file: File,
    /// The rate whose bit times the times of the pieces are.
    clock: Baud,
    /// The end of the last packet.
    end: BitTime,
}

impl Capture {
    /// Creates the capture file if the options name one. Times are bit times of `clock`; `line` is the rate of the line, if it is known.
    pub fn begin(options: &PrintOptions, clock: Baud, line: Option<Baud>) -> Result<Option<Self>, Failure> {
        let Some(path) = options.out.clone() else { return Ok(None) };
        let file = File::create(&path).map_err(|error| write_failure(&path, &error))?;
        let mut capture = Self { path, file, clock, end: BitTime(0) };
        capture.write(&pcapng::file_header(line, options.link_type))?;
        Ok(Some(capture))
    }

    /// Adds pieces. Pieces without a time follow each other at a distance of T_SYN, and are marked: their times are invented.
    pub fn add(&mut self, explained: &[ExplainedPiece]) -> Result<(), Failure> {
        let mut packets = Vec::new();
        for explained in explained {
            let (start, times) = match explained.piece.start {
                Some(start) => (start, Times::Measured),
                None => (self.end + T_SYN_TBIT, Times::Invented),
            };
            let entry = Entry::new(start, explained.piece.octets.as_slice(), explained.piece.errors.clone());
            self.end = entry.end();
            packets.extend(pcapng::packet(&entry, times, self.clock));
        }
        self.write(&packets)
    }

    fn write(&mut self, octets: &[u8]) -> Result<(), Failure> {
        self.file.write_all(octets).map_err(|error| write_failure(&self.path, &error))
    }
}

fn write_failure(path: &Path, error: &std::io::Error) -> Failure {
    Failure::usage(format!("{} cannot be written: {error}", path.display()))
}
