//! Where everything that is watched comes together: rows as they are made, or one screen for all segments.

use super::plan::Plan;
use super::row::{self, Row};
use super::{Arguments, table};
use crate::failure::Failure;
use crate::output::{notice, out};
use ratatui::Frame;
use std::fmt::Display;
use std::sync::{Mutex, Once, PoisonError};

/// The form of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Csv,
    Json,
    Table,
    Screen,
}

/// What is known of a segment at the moment.
struct SegmentView {
    /// Where it is, or what was said of it last.
    title: String,
    rows: Vec<Row>,
}

/// Where segments are shown. Each is served by a thread of its own; all tell it here.
pub struct MonitorView<'a> {
    plans: &'a [Plan],
    form: Form,
    header: Once,
    /// What a screen shows of each.
    views: Vec<Mutex<SegmentView>>,
}

impl<'a> MonitorView<'a> {
    /// As the command line wants it.
    pub fn new(plans: &'a [Plan], is_screen: bool, arguments: &Arguments) -> Self {
        let form = match (arguments.csv, arguments.json) {
            (true, _) => Form::Csv,
            (_, true) => Form::Json,
            (false, false) if is_screen => Form::Screen,
            (false, false) => Form::Table,
        };
        let seen = |plan: &Plan| {
            Mutex::new(SegmentView { title: with_segment_name(plan, &plan.bus.port()), rows: Vec::new() })
        };
        Self { plans, form, header: Once::new(), views: plans.iter().map(seen).collect() }
    }

    /// Whether there is a screen.
    pub fn is_screen(&self) -> bool {
        self.form == Form::Screen
    }

    /// A segment exchanges data from here on.
    pub fn print_header(&self) {
        let with_segment = self.plans.iter().any(|plan| plan.name.is_some());
        self.header.call_once(|| match self.form {
            Form::Csv => out(&row::csv_columns(with_segment)),
            Form::Table => out(&row::header(with_segment)),
            Form::Json | Form::Screen => {}
        });
    }

    /// What a segment says now.
    pub fn rows(&self, number: usize, rows: Vec<Row>) {
        let line: fn(&Row) -> String = match self.form {
            Form::Csv => Row::csv,
            // Texts and numbers always have a JSON form.
            Form::Json => |row| serde_json::to_string(row).unwrap_or_default(),
            Form::Table => Row::line,
            Form::Screen => return self.change(number, |seen| seen.rows = rows),
        };
        rows.iter().for_each(|row| out(&line(row)));
    }

    /// What somebody should know about a segment: on a screen it stands in the title.
    pub fn notice(&self, number: usize, said: &impl Display) {
        let Some(plan) = self.plans.get(number) else { return };
        let said = with_segment_name(plan, said);
        match self.form {
            Form::Screen => self.change(number, |seen| seen.title = said),
            Form::Csv | Form::Json | Form::Table => notice(&said),
        }
    }

    /// A segment is not watched any more. Where there is only one that is the end of the command, which says it itself.
    pub fn ended(&self, number: usize, failure: &Failure) {
        if self.plans.len() > 1 && !failure.is_quiet() {
            self.notice(number, failure);
            self.change(number, |seen| seen.rows.clear());
        }
    }

    /// Fills the screen.
    pub fn draw(&self, frame: &mut Frame<'_>) {
        let mut titles = Vec::new();
        let mut rows = Vec::new();
        for seen in &self.views {
            let seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
            titles.push(seen.title.clone());
            rows.extend(seen.rows.iter().cloned());
        }
        table::draw(frame, &titles, &rows);
    }

    /// How the command ends: as its segment did, or of several as the first that could not be watched.
    pub fn combine(&self, verdicts: Vec<Result<(), Failure>>) -> Result<(), Failure> {
        let ended = self.plans.iter().zip(verdicts).filter_map(|(plan, verdict)| Some((plan, verdict.err()?)));
        let mut ended: Vec<_> = ended.collect();
        if self.is_screen() {
            // What stood on the screen is gone with it.
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
            Some(name) => failure.with_sentence(&format!("the segment {name:?} was not watched to the end")),
        })
    }

    fn change(&self, number: usize, change: impl FnOnce(&mut SegmentView)) {
        if let Some(seen) = self.views.get(number) {
            change(&mut seen.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}

/// A sentence about a segment: where there are several it begins with its name.
fn with_segment_name(plan: &Plan, said: &impl Display) -> String {
    match &plan.name {
        Some(name) => format!("{name}: {said}"),
        None => said.to_string(),
    }
}
