//! What pressures and values of points have in common: how they are thinned out, summarised and stored.

use super::quality::Quality;
use profivac_model::Micros;
use rusqlite::Row;

/// A value of a series at one time: a pressure, or the value of a point.
///
/// Each kind has tables of its own, so no query for pressures returns the number of a point.
pub trait Recorded: Copy + PartialEq {
    /// The summary of several of them.
    type Summary: Summarise;

    /// The table of the values.
    const SAMPLES: &'static str;
    /// The table of the summaries.
    const SPANS: &'static str;
    /// The column of both tables that names the series.
    const SERIES: &'static str;
    /// The column of the value.
    const VALUE: &'static str;

    /// A value. One that does not fit its quality is dropped, and makes a valid one a fault.
    fn of(at: Micros, value: Option<f64>, quality: Quality) -> Self;

    /// When it was measured.
    fn at(&self) -> Micros;

    /// The value, where it has one.
    fn value(&self) -> Option<f64>;

    /// Its quality.
    fn quality(&self) -> Quality;

    /// Where the value is on the scale on which a deadband is measured.
    fn on_scale(&self) -> Option<f64>;

    /// The summary of this value alone.
    fn summary(&self) -> Self::Summary;
}

/// A summary of values.
pub trait Summarise: Copy + Default {
    /// Its columns in the table of spans.
    const COLUMNS: &'static str;

    /// Reads the columns of a row, which begin at column `first`.
    ///
    /// # Errors
    /// Any error of SQLite.
    fn read(row: &Row<'_>, first: usize) -> rusqlite::Result<Self>;

    /// Adds the summary of later values.
    fn add(&mut self, later: &Self);
}
