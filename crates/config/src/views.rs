//! `[[view]]`: a filter of the overview, or a group of trends, under a name.

use super::alarms;
use super::error::{ConfigProblem, Located, NamedItem};
use super::labels::MAX_NAME;
use super::names;
use super::segments::SegmentToml;
use profivac_client::suggestion::closest;
use profivac_station::directory::{Directory, SavedView, ViewState};
use serde::Deserialize;
use std::collections::HashSet;
use toml::Spanned;

/// `[[view]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewToml {
    /// The name, unique among the views.
    name: Spanned<String>,
    /// A word in the names that the overview shows.
    search: Option<Spanned<String>>,
    /// A group of gauges.
    group: Option<Spanned<String>>,
    /// A tag of gauges.
    tag: Option<Spanned<String>>,
    /// A location of gauges.
    location: Option<Spanned<String>>,
    /// `problems`, `alarms`, `fault`, `no-data` or `calibration-overdue`.
    state: Option<Spanned<String>>,
    /// Gauges, or `NAME.N` for a channel, that are a group of trends; without the other keys.
    #[serde(default)]
    series: Vec<Spanned<String>>,
}

/// The views of a file whose gauges have the labels of `directory`.
pub fn views(given: &[ViewToml], segments: &[SegmentToml], directory: &Directory) -> Result<Vec<SavedView>, Located> {
    names::unique(NamedItem::View, given.iter().map(|view| &view.name))?;
    given.iter().map(|given| view(given, segments, directory)).collect()
}

fn view(given: &ViewToml, segments: &[SegmentToml], directory: &Directory) -> Result<SavedView, Located> {
    names::check_length(NamedItem::View, &given.name, MAX_NAME)?;
    let labels = || directory.gauges.values();
    known(NamedItem::Group, given.group.as_ref(), labels().filter_map(|it| it.group.as_deref()))?;
    known(NamedItem::Tag, given.tag.as_ref(), labels().flat_map(|it| &it.tags).map(String::as_str))?;
    known(NamedItem::Location, given.location.as_ref(), labels().filter_map(|it| it.location.as_deref()))?;
    if let Some(search) = &given.search {
        names::check_length(NamedItem::Search, search, MAX_NAME)?;
    }
    let mut seen = HashSet::new();
    for series in &given.series {
        alarms::series(series, segments)?;
        if !seen.insert(series.get_ref()) {
            return Err(Located::new(series.span(), ConfigProblem::RepeatedGauge(series.get_ref().clone())));
        }
    }
    let text = |value: &Option<Spanned<String>>| value.as_ref().map(|value| value.get_ref().clone());
    let view = SavedView {
        name: given.name.get_ref().clone(),
        search: text(&given.search),
        group: text(&given.group),
        tag: text(&given.tag),
        location: text(&given.location),
        state: given.state.as_ref().map(state).transpose()?,
        series: given.series.iter().map(|series| series.get_ref().clone()).collect(),
    };
    let is_filter =
        [&given.search, &given.group, &given.tag, &given.location, &given.state].iter().any(|it| it.is_some());
    if is_filter == view.series.is_empty() {
        return Ok(view);
    }
    Err(Located::new(given.name.span(), ConfigProblem::ViewContent(view.name)))
}

fn state(word: &Spanned<String>) -> Result<ViewState, Located> {
    let found = ViewState::ALL.into_iter().find(|state| state.word() == word.get_ref());
    found.ok_or_else(|| Located::new(word.span(), ConfigProblem::UnknownViewState { found: word.get_ref().clone() }))
}

/// A label that no gauge has would show nothing.
fn known<'a>(
    item: NamedItem,
    value: Option<&Spanned<String>>,
    labels: impl Iterator<Item = &'a str>,
) -> Result<(), Located> {
    let Some(value) = value else { return Ok(()) };
    let labels: HashSet<_> = labels.collect();
    let name = value.get_ref();
    if labels.contains(name.as_str()) {
        return Ok(());
    }
    let suggestion = closest(name, labels).map(str::to_owned);
    Err(Located::new(value.span(), ConfigProblem::UnknownLabel { item, name: name.clone(), suggestion }))
}
