//! The samples of an outage: pressures and values of points of all series in the record, in the order of their times.

use profivac_gateway::Subject;
use profivac_recorder::{DatabaseError, Micros, Point, PointSample, Reader, Sample};
use std::collections::{HashSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

/// The samples of one batch: a payload of some 50 kB.
const BATCH: usize = 500;

/// The samples that are read from one series at once.
const PAGE: u32 = 500;

/// The time after which a sample is in the record: the recorder writes once a second.
const LATE: Duration = Duration::from_secs(2);

/// The end of the backlog that is close enough to the present.
const CLOSE: Duration = Duration::from_secs(1);

/// A series of the record.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Series {
    /// The pressures of a gauge, or of a channel of a controller.
    Pressures(Arc<str>),
    /// The values of a point of a slave, in its present unit.
    Point(Arc<Point>),
}

impl Series {
    /// The series that has the history of a point; `None` for a point that is not recorded.
    #[must_use]
    pub fn of(point: &profivac_gateway::Point) -> Option<Self> {
        match &point.subject {
            Subject::Reading { series, .. } => Some(Self::Pressures(Arc::clone(series))),
            _ => point.recorded.as_ref().map(|recorded| Self::Point(Arc::clone(recorded))),
        }
    }

    /// The first `limit` samples of the series from `from` to `to`.
    fn page(&self, reader: &Reader, from: Micros, to: Micros, limit: u32) -> Result<Vec<Recorded>, DatabaseError> {
        Ok(match self {
            Self::Pressures(name) => reader.page(name, from, to, limit)?.into_iter().map(Recorded::Pressure).collect(),
            Self::Point(point) => reader.point_page(point, from, to, limit)?.into_iter().map(Recorded::Point).collect(),
        })
    }
}

/// A sample of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Recorded {
    /// A pressure.
    Pressure(Sample),
    /// A value of a point.
    Point(PointSample),
}

impl Recorded {
    /// When it was measured.
    #[must_use]
    pub const fn at(&self) -> Micros {
        match self {
            Self::Pressure(sample) => sample.at,
            Self::Point(sample) => sample.at,
        }
    }
}

/// A part of the backlog.
#[derive(Clone, Debug, PartialEq)]
pub enum Batch {
    /// Samples of several series, in the order of their times.
    Samples(Vec<(Series, Recorded)>),
    /// The record will have the next samples soon.
    Wait,
    /// The record has no more samples up to this time, which is the present.
    CaughtUp(Micros),
}

/// The samples of one series that were read and not taken.
struct Queue {
    series: Series,
    samples: VecDeque<Recorded>,
    /// The series has no more samples up to the end.
    is_complete: bool,
    /// Where the next page begins.
    next: Micros,
}

/// The backlog of all series.
pub struct Backlog {
    reader: Reader,
    queues: Vec<Queue>,
    until: Micros,
    /// The births: the backlog reaches at least to them.
    born: Micros,
}

impl Backlog {
    /// The backlog of these series after `delivered`, for births at `now`.
    #[must_use]
    pub fn new(reader: Reader, series: Vec<Series>, delivered: Micros, now: Micros) -> Self {
        let next = Micros(delivered.0.saturating_add(1));
        let queue = |series| Queue { series, samples: VecDeque::new(), is_complete: false, next };
        let until = now.before(LATE).max(delivered);
        Self { reader, queues: series.into_iter().map(queue).collect(), until, born: now }
    }

    /// The series that have samples in the backlog.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn series(&mut self) -> Result<HashSet<Series>, DatabaseError> {
        self.fill()?;
        let queues = self.queues.iter().filter(|queue| !queue.samples.is_empty());
        Ok(queues.map(|queue| queue.series.clone()).collect())
    }

    /// The next batch.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn next(&mut self, now: Micros) -> Result<Batch, DatabaseError> {
        let mut batch = Vec::new();
        while batch.len() < BATCH {
            self.fill()?;
            let Some(sample) = self.take_first() else { break };
            batch.push(sample);
        }
        if !batch.is_empty() {
            return Ok(Batch::Samples(batch));
        }
        let complete = now.before(LATE);
        if complete <= self.until.after(CLOSE) && self.until >= self.born {
            return Ok(Batch::CaughtUp(self.until));
        }
        if complete <= self.until {
            return Ok(Batch::Wait);
        }
        self.extend(complete);
        Ok(Batch::Wait)
    }

    /// The backlog reaches to `until` now: what was recorded meanwhile belongs to it.
    fn extend(&mut self, until: Micros) {
        self.until = until;
        for queue in &mut self.queues {
            queue.is_complete = false;
        }
    }

    /// Reads a page for each series that has none.
    fn fill(&mut self) -> Result<(), DatabaseError> {
        for queue in self.queues.iter_mut().filter(|queue| queue.samples.is_empty() && !queue.is_complete) {
            let page = queue.series.page(&self.reader, queue.next, self.until, PAGE)?;
            queue.is_complete = page.len() < PAGE as usize;
            if let Some(last) = page.last() {
                queue.next = Micros(last.at().0.saturating_add(1));
            }
            queue.samples = page.into();
        }
        Ok(())
    }

    fn take_first(&mut self) -> Option<(Series, Recorded)> {
        let filled = self.queues.iter_mut().filter(|queue| !queue.samples.is_empty());
        let first = filled.min_by_key(|queue| queue.samples.front().map(Recorded::at))?;
        let sample = first.samples.pop_front()?;
        Some((first.series.clone(), sample))
    }
}
