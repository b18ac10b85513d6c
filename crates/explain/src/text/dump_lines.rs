//! Reads the lines of dumps: finds the address column, and repeats the lines that a dump omits.

use super::dump::{Column, DumpLine, Step};
use super::ignored::IgnoredKind;
use super::{Found, LeftOver, Reader, Row};

/// State of the search for an address column.
#[derive(Clone, Debug, Default)]
pub(super) enum Addresses {
    /// No line has had an address.
    #[default]
    None,
    /// This line may have one: the next line decides.
    Undecided { number: usize, line: DumpLine, text: String },
    /// First words of this form are octets.
    Refuted(DumpLine),
    /// The text is a dump.
    Column(Column),
}

/// The line with which od and hexdump replace lines that are equal to the one before.
pub const OMITTED: &str = "*";

/// The most octets of a text in the lines that a dump omits. An address of a few digits can stand for any number of octets, so what
/// is more stays left over: the work for a text then grows with its length. chosen.
pub(super) const MAX_REPEATED: u64 = 1 << 20;

impl Reader {
    /// Reads a line of a dump. Returns false for another line.
    pub(super) fn read_dump(&mut self, text: &str, found: &mut Found) -> bool {
        let number = self.line;
        if text.trim() == OMITTED && matches!(self.addresses, Addresses::Undecided { .. } | Addresses::Column(_)) {
            let undecided = std::mem::take(&mut self.addresses);
            match undecided {
                Addresses::Undecided { number, line, text } if line.has_groups_like_address() => {
                    self.refute(number, line, &text, found);
                }
                Addresses::Undecided { number, line, .. } => self.begin_dump(&line, number, found),
                decided => self.addresses = decided,
            }
            self.read_waiting(found);
            self.is_omitting = true;
            return true;
        }
        let line = DumpLine::of(text);
        let undecided = std::mem::take(&mut self.addresses);
        if let Addresses::Undecided { number, line: first, text } = undecided {
            if line.as_ref().is_some_and(|line| Column::new(&first).is_confirmed_by(line)) {
                self.begin_dump(&first, number, found);
            } else {
                self.refute(number, first, &text, found);
            }
        } else {
            self.addresses = undecided;
        }
        let Some(line) = line else { return false };
        match &self.addresses {
            Addresses::Column(column) if column.has(&line) => self.continue_dump(&line, found),
            _ if line.is_certain() => {
                self.flush(found);
                self.begin_dump(&line, number, found);
            }
            Addresses::Refuted(refuted) if refuted.is_like(&line) => return false,
            Addresses::Column(_) if line.octets.is_empty() || line.has_groups_like_address() => return false,
            _ if !line.octets.is_empty() => {
                self.read_waiting(found);
                self.emit_last_row(found);
                self.addresses = Addresses::Undecided { number, line, text: text.to_owned() };
            }
            _ => return false,
        }
        true
    }

    /// Reads the first line of a dump.
    pub(super) fn begin_dump(&mut self, line: &DumpLine, number: usize, found: &mut Found) {
        self.addresses = Addresses::Column(Column::new(line));
        self.take_dump_row(line, number, found);
    }

    /// Reads the next line of a dump. A line behind omitted ones waits for the next one, if its address alone does not show how many
    /// were omitted.
    fn continue_dump(&mut self, line: &DumpLine, found: &mut Found) {
        if let (Some((_, waiting)), Addresses::Column(column)) = (&self.waiting, &mut self.addresses) {
            column.narrow(waiting, line);
        }
        self.read_waiting(found);
        match &self.addresses {
            Addresses::Column(column) if self.is_omitting && column.gap(line).is_none() => {
                (self.waiting, self.is_omitting) = (Some((self.line, line.clone())), false);
            }
            _ => self.read_dump_line(line, self.line, found),
        }
    }

    /// Reads the line that waits for the next one.
    pub(super) fn read_waiting(&mut self, found: &mut Found) {
        if let Some((number, line)) = self.waiting.take() {
            let is_omitting = std::mem::replace(&mut self.is_omitting, true);
            self.read_dump_line(&line, number, found);
            self.is_omitting = is_omitting;
        }
    }

    fn read_dump_line(&mut self, line: &DumpLine, number: usize, found: &mut Found) {
        let Addresses::Column(column) = &mut self.addresses else { return };
        let (step, gap) = (column.step(line), column.gap(line));
        column.advance(line);
        match (step, std::mem::take(&mut self.is_omitting)) {
            (Step::Next | Step::Restart, false) => {}
            (_, true) => self.repeat_last_row(gap, number.saturating_sub(1), found),
            (Step::Padded(count), false) => {
                if let Some(row) = &mut self.last_row {
                    let length = row.octets.len() as u64;
                    row.octets.truncate(usize::try_from(length.saturating_sub(count)).unwrap_or_default());
                }
            }
            (Step::Other, false) => {
                let text = line.address.digits.clone();
                let octets = text.len().div_ceil(2);
                found.left_over.push(LeftOver { line: number, text, octets });
            }
        }
        self.take_dump_row(line, number, found);
    }

    /// Repeats the last row for the lines that the dump omits, if they have not too many octets.
    fn repeat_last_row(&mut self, gap: Option<u64>, line: usize, found: &mut Found) {
        let length = self.last_row.as_ref().map_or(0, |row| row.octets.len() as u64);
        let repeated = gap.map(|gap| (gap, self.repeated.saturating_add(gap)));
        let repeated = repeated.filter(|(_, repeated)| *repeated <= MAX_REPEATED);
        match (&mut self.last_row, repeated.and_then(|(gap, sum)| Some((gap.checked_div(length)?, sum)))) {
            (Some(row), Some((times, sum))) => {
                row.times = row.times.saturating_add(times);
                self.repeated = sum;
            }
            _ => found.left_over.push(LeftOver { line, text: OMITTED.to_owned(), octets: 0 }),
        }
    }

    fn take_dump_row(&mut self, line: &DumpLine, number: usize, found: &mut Found) {
        self.emit_last_row(found);
        self.ignored.add(IgnoredKind::Address, number, &line.address.digits);
        if let Some(characters) = &line.characters {
            self.ignored.add(IgnoredKind::Characters, number, characters);
        }
        self.last_row = Some(Row { octets: line.octets.clone(), is_continued: true, times: 1, ..Row::default() });
        let rest = line.rest.trim();
        if !rest.is_empty() {
            self.leave_over_or_ignore(rest, number, found);
        }
    }
}
