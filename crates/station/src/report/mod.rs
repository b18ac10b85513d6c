//! A report about a pump-down: what a vacuum engineer hands to a customer or keeps with the chamber.
//!
//! | Module | Holds |
//! |---|---|
//! | [`series`] | what a record has of a gauge in a span, and the pump-downs in it |
//! | [`figures`] | the numbers |
//! | [`page`] | the page |
//! | `pictures` | which curves it has |
//! | `plot` | how a curve is drawn |
//! | `tables` | its tables |
//! | [`words`] | numbers and times as people read them |

mod charts;
pub mod figures;
pub mod format;
pub mod page;
mod plot;
pub mod series;
mod tables;

pub use figures::{GaugeInfo, Report, ReportRequest, TargetPressure};
pub use format::Unit;
