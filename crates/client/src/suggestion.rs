//! Suggestions for mistyped names, and lists of the names that exist.

/// The least similarity of a suggestion: half of the letters are in place. chosen.
const MIN_SIMILARITY: f64 = 0.5;

/// The similarity of two names, 0 to 1: insertions, deletions, exchanges and swaps of neighbours count. Upper and lower case are
/// equal.
///
/// ```
/// use profivac_client::suggestion::similarity;
///
/// assert!(similarity("Pirani", "pirani") > similarity("piranni", "pirani"));
/// ```
#[must_use]
pub fn similarity(one: &str, other: &str) -> f64 {
    strsim::normalized_damerau_levenshtein(&one.to_lowercase(), &other.to_lowercase())
}

/// The candidate that is most similar to `name`, if one is similar enough. Upper and lower case are equal.
///
/// ```
/// use profivac_client::suggestion::closest;
///
/// assert_eq!(closest("chambre", ["chamber", "lock"]), Some("chamber"));
/// assert_eq!(closest("thermometer", ["chamber", "lock"]), None);
/// ```
#[must_use]
pub fn closest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let ranked = candidates.into_iter().map(|candidate| (similarity(name, candidate), candidate));
    let best = ranked.max_by(|one, two| one.0.total_cmp(&two.0))?;
    (best.0 >= MIN_SIMILARITY).then_some(best.1)
}

/// The message of the TOML reader; an unknown key gets the most similar key that it lists, as the errors of a scenario do.
///
/// ```
/// use profivac_client::suggestion::with_suggestion;
///
/// let message = "unknown field `opne`, expected one of `at`, `open`";
/// assert_eq!(with_suggestion(message), format!("{message}; did you mean `open`?"));
/// assert_eq!(with_suggestion("invalid string"), "invalid string");
/// ```
#[must_use]
pub fn with_suggestion(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let near = match (message.starts_with("unknown field"), quoted.next()) {
        (true, Some(found)) => closest(found, quoted),
        _ => None,
    };
    near.map_or_else(|| message.to_owned(), |near| format!("{message}; did you mean `{near}`?"))
}

/// The most names of a list in a message. chosen.
pub const MAX_LISTED: usize = 20;

/// A list of names: at most [`MAX_LISTED`], and how many more there are.
///
/// ```
/// use profivac_client::suggestion::list;
///
/// assert_eq!(list(&["chamber", "lock"]), "chamber, lock");
/// assert!(list(&["gauge"; 480]).ends_with(", gauge and 460 more"));
/// ```
#[must_use]
pub fn list(names: &[impl AsRef<str>]) -> String {
    let shown = names.iter().take(MAX_LISTED).map(AsRef::as_ref).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MAX_LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The end of a message about a wrong name: the names of this kind that exist, in the plural, and the most similar one.
///
/// ```
/// use profivac_client::suggestion::known;
///
/// assert_eq!(known("gauges", "chambre", &["chamber", "lock"]), "the gauges are chamber, lock; did you mean \"chamber\"?");
/// assert_eq!(known("gauges", "attic", &["chamber"]), "the gauges are chamber");
/// assert_eq!(known("gauges", "attic", &[""; 0]), "there are no gauges");
/// ```
#[must_use]
pub fn known(kind: &str, name: &str, names: &[impl AsRef<str>]) -> String {
    if names.is_empty() {
        return format!("there are no {kind}");
    }
    let near = closest(name, names.iter().map(AsRef::as_ref));
    let near = near.map_or_else(String::new, |near| format!("; did you mean {near:?}?"));
    format!("the {kind} are {}{near}", list(names))
}

#[cfg(test)]
mod tests {
    use super::closest;

    #[test]
    fn a_mistyped_name_has_a_suggestion_and_another_word_has_none() {
        let names = ["chamber", "Lock", "tpg"];
        assert_eq!(closest("Chambre", names), Some("chamber"));
        assert_eq!(closest("lock", names), Some("Lock"));
        assert_eq!(closest("thermometer", names), None);
        assert_eq!(closest("chamber", []), None);
    }
}
