//! `[[segment.slave.point.alarm]]`.

use super::at;
use crate::error::{ConfigProblem, Located};
use crate::slave_problem::SlaveProblem;
use crate::time_span::TimeSpan;
use crate::values::{delay, priority};
use profivac_host::text_file::Parsed;
use profivac_station::alarm::{Condition, PointTest, Priority, Rule};
use profivac_web_server::visible_text::check_lines;
use serde::Deserialize;
use std::ops::Range;
use std::time::Duration;
use toml::Spanned;

/// Defaults. chosen: as for `[[alarm]]`.
const DELAY: Duration = Duration::from_secs(1);
const OFF_DELAY: Duration = Duration::from_secs(5);

/// `[[segment.slave.point.alarm]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PointAlarmToml {
    /// Raised above this number, in the unit of the point.
    above: Option<Spanned<f64>>,
    /// Raised below this number, in the unit of the point.
    below: Option<Spanned<f64>>,
    /// Raised while the point has this text: one of `texts`, or `on` or `off` of a bit without texts.
    is: Option<Spanned<String>>,
    /// The number at which `above` or `below` ends, in place of `hysteresis`.
    reset: Option<Spanned<f64>>,
    /// How far back the number must go, in the unit of the point, 0 or more. Default: 0.
    hysteresis: Option<Spanned<f64>>,
    /// The condition must hold for this time, up to 1 h. Default: `1 s`.
    delay: Option<Spanned<Parsed<TimeSpan>>>,
    /// The condition must be over for this time, up to 1 h. Default: `5 s`.
    off_delay: Option<Spanned<Parsed<TimeSpan>>>,
    /// `high`, `medium` or `low`. Default: `medium`.
    priority: Option<Spanned<String>>,
    /// What an operator shall do, shown with the alarm.
    message: Option<Spanned<String>>,
}

/// The point of an alarm.
pub struct AlarmedPoint<'a> {
    pub slave: &'a str,
    pub name: &'a Spanned<String>,
    pub unit: Option<&'static str>,
    /// The texts that the value may have, apart from numbers.
    pub texts: Vec<String>,
}

impl PointAlarmToml {
    /// The rule, with the place of its condition.
    pub fn rule(&self, point: &AlarmedPoint<'_>) -> Result<(Range<usize>, Rule), Located> {
        let (test, words, place) = self.test(point)?;
        if let Some(text) = &self.message {
            check_lines(text.get_ref()).map_err(|problem| Located::new(text.span(), ConfigProblem::Text(problem)))?;
        }
        let name = point.name.get_ref();
        let rule = Rule {
            name: format!("{}: {name} {words}", point.slave),
            condition: Condition::Point {
                gauge: point.slave.to_owned(),
                point: name.clone(),
                unit: point.unit.filter(|_| self.is.is_none()),
                test,
            },
            priority: priority(self.priority.as_ref(), Priority::Medium)?,
            delay: delay(self.delay.as_ref(), DELAY)?,
            off_delay: delay(self.off_delay.as_ref(), OFF_DELAY)?,
            message: self.message.as_ref().map(|text| text.get_ref().clone()),
        };
        Ok((place, rule))
    }

    /// The test, its words in the name of the alarm, and its place.
    fn test(&self, point: &AlarmedPoint<'_>) -> Result<(PointTest, String, Range<usize>), Located> {
        let unit = point.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
        let limit = |limit: &Spanned<f64>| point.number(limit);
        match (&self.above, &self.below, &self.is) {
            (Some(given), None, None) => {
                let above = limit(given)?;
                let reset = self.reset(point, above, -1.0)?;
                Ok((PointTest::Above { limit: above, reset }, format!("above {above}{unit}"), given.span()))
            }
            (None, Some(given), None) => {
                let below = limit(given)?;
                let reset = self.reset(point, below, 1.0)?;
                Ok((PointTest::Below { limit: below, reset }, format!("below {below}{unit}"), given.span()))
            }
            (None, None, Some(is)) if point.texts.contains(is.get_ref()) => {
                if let Some(surplus) = self.reset.as_ref().or(self.hysteresis.as_ref()) {
                    let expected = "reset and hysteresis with above or below only";
                    return Err(point.wrong(surplus.span(), expected, surplus.get_ref().to_string()));
                }
                Ok((PointTest::Is(is.get_ref().clone()), format!("is {}", is.get_ref()), is.span()))
            }
            (None, None, Some(is)) => {
                let (name, found) = (point.name.get_ref().clone(), is.get_ref().clone());
                let known = point.texts.clone();
                Err(at(is.span(), SlaveProblem::PointText { point: name, found, known }))
            }
            _ => {
                let expected = "alarms with one of above, below and is each";
                Err(point.wrong(point.name.span(), expected, "none or several".to_owned()))
            }
        }
    }
}

impl PointAlarmToml {
    /// The number at which a limit alarm returns to normal. `side` is -1 if that is below the limit, 1 if it is above.
    fn reset(&self, point: &AlarmedPoint<'_>, limit: f64, side: f64) -> Result<f64, Located> {
        match (&self.reset, &self.hysteresis) {
            (Some(reset), Some(_)) => Err(Located::new(reset.span(), ConfigProblem::ResetAndHysteresis)),
            (Some(given), None) => {
                let reset = point.number(given)?;
                if (reset - limit) * side >= 0.0 {
                    return Ok(reset);
                }
                let side = if side < 0.0 { "above" } else { "below" };
                let (limit, reset) = (limit.to_string(), reset.to_string());
                Err(Located::new(given.span(), ConfigProblem::ResetBeyondLimit { side, limit, reset }))
            }
            (None, Some(given)) => {
                let hysteresis = point.number(given)?;
                if hysteresis < 0.0 {
                    let expected = "a hysteresis of 0 or more, in its unit";
                    return Err(point.wrong(given.span(), expected, hysteresis.to_string()));
                }
                Ok(limit + side * hysteresis)
            }
            (None, None) => Ok(limit),
        }
    }
}

impl AlarmedPoint<'_> {
    fn number(&self, given: &Spanned<f64>) -> Result<f64, Located> {
        let number = *given.get_ref();
        if number.is_finite() { Ok(number) } else { Err(self.wrong(given.span(), "a number", number.to_string())) }
    }

    fn wrong(&self, span: Range<usize>, expected: &'static str, found: String) -> Located {
        at(span, SlaveProblem::PointValue { point: self.name.get_ref().clone(), expected, found })
    }
}
