//! Suggestions for mistyped names.

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
