//! Reports about pump-downs, for customers and for the archive of a chamber.
//!
//! | Module | Holds |
//! |---|---|
//! | [`series`] | the samples of a series in a time range, and the pump-downs in a database |
//! | [`figures`] | the numbers of a report |
//! | `calculate` | how the numbers are calculated |
//! | [`page`] | the HTML page |
//! | `charts` | the charts of the page |
//! | `plot` | a chart as SVG |
//! | `tables` | the tables of the page |
//! | [`mod@format`] | numbers, times and names as text |

mod calculate;
mod charts;
pub mod figures;
pub mod format;
pub mod page;
mod plot;
pub mod series;
mod tables;

pub use figures::{GaugeInfo, Outcome, Report, ReportRequest, TargetPressure};
pub use format::Unit;
