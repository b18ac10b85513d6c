//! The output of all segments: rows, or one screen.

use super::plan::Plan;
use super::row::{self, Row};
use super::{Arguments, table};
use crate::failure::Failure;
use crate::output::{notice, out};
use ratatui::Frame;
use std::fmt::Display;
use std::sync::{Mutex, Once, PoisonError};

/// The form of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Csv,
    Json,
    Table,
    Screen,
}

/// The latest state of a segment.
struct SegmentView {
    /// Its port, or its last notice.
    title: String,
    rows: Vec<Row>,
}

/// Shows all segments; the thread of each segment calls it.
pub struct MonitorView<'a> {
    plans: &'a [Plan],
    form: Form,
    header: Once,
    /// The state of each segment, for a screen.
    views: Vec<Mutex<SegmentView>>,
}

impl<'a> MonitorView<'a> {
    /// Makes a view in the form that the command line selects.
    pub fn new(plans: &'a [Plan], is_screen: bool, arguments: &Arguments) -> Self {
        let form = match (arguments.csv, arguments.json) {
            (true, _) => Form::Csv,
            (_, true) => Form::Json,
            (false, false) if is_screen => Form::Screen,
            (false, false) => Form::Table,
        };
        let view = |plan: &Plan| {
            Mutex::new(SegmentView { title: with_segment_name(plan, &plan.bus.port()), rows: Vec::new() })
        };
        Self { plans, form, header: Once::new(), views: plans.iter().map(view).collect() }
    }

    /// Whether the output is a screen.
    pub fn is_screen(&self) -> bool {
        self.form == Form::Screen
    }

    /// Prints the header before the first row of any segment.
    pub fn print_header(&self) {
        let with_segment = self.plans.iter().any(|plan| plan.name.is_some());
        self.header.call_once(|| match self.form {
            Form::Csv => out(&row::csv_columns(with_segment)),
            Form::Table => out(&row::header(with_segment)),
            Form::Json | Form::Screen => {}
        });
    }

    /// Shows the rows of a segment.
    pub fn rows(&self, number: usize, rows: Vec<Row>) {
        let line: fn(&Row) -> String = match self.form {
            Form::Csv => Row::csv,
            // Strings and numbers always have a JSON form.
            Form::Json => |row| serde_json::to_string(row).unwrap_or_default(),
            Form::Table => Row::line,
            Form::Screen => return self.change(number, |view| view.rows = rows),
        };
        rows.iter().for_each(|row| out(&line(row)));
    }

    /// Shows a notice about a segment; on a screen it is in the title.
    pub fn notice(&self, number: usize, text: &impl Display) {
        let Some(plan) = self.plans.get(number) else { return };
        let text = with_segment_name(plan, text);
        match self.form {
            Form::Screen => self.change(number, |view| view.title = text),
            Form::Csv | Form::Json | Form::Table => notice(&text),
        }
    }

    /// Shows that a segment has ended. A single segment ends the command, which prints the failure itself.
    pub fn ended(&self, number: usize, failure: &Failure) {
        if self.plans.len() > 1 && !failure.is_quiet() {
            self.notice(number, failure);
            self.change(number, |view| view.rows.clear());
        }
    }

    /// Fills the screen.
    pub fn draw(&self, frame: &mut Frame<'_>) {
        let mut titles = Vec::new();
        let mut rows = Vec::new();
        for view in &self.views {
            let view = view.lock().unwrap_or_else(PoisonError::into_inner);
            titles.push(view.title.clone());
            rows.extend(view.rows.iter().cloned());
        }
        table::draw(frame, &titles, &rows);
    }

    /// The result of the command: that of its segment, or the first failure of several.
    pub fn combine(&self, verdicts: Vec<Result<(), Failure>>) -> Result<(), Failure> {
        let ended = self.plans.iter().zip(verdicts).filter_map(|(plan, verdict)| Some((plan, verdict.err()?)));
        let mut ended: Vec<_> = ended.collect();
        if self.is_screen() {
            // The screen has been closed, and its titles with it.
            ended.iter().skip(1).for_each(|(plan, failure)| notice(&with_segment_name(plan, failure)));
        }
        if ended.is_empty() {
            return Ok(());
        }
        let (plan, failure) = ended.swap_remove(0);
        Err(match &plan.name {
            _ if failure.is_quiet() => failure,
            None => failure,
            Some(_) if self.is_screen() => failure.with_sentence(&with_segment_name(plan, &failure)),
            Some(name) => failure.with_sentence(&format!("the segment {name:?} ended early")),
        })
    }

    fn change(&self, number: usize, change: impl FnOnce(&mut SegmentView)) {
        if let Some(view) = self.views.get(number) {
            change(&mut view.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}

/// A sentence about a segment, beginning with its name if there are several.
fn with_segment_name(plan: &Plan, text: &impl Display) -> String {
    match &plan.name {
        Some(name) => format!("{name}: {text}"),
        None => text.to_string(),
    }
}
