//! Lists in messages.

/// The most things that a message lists. chosen: a folder can have thousands of files.
const MOST: usize = 20;

/// The things with commas; those beyond the first twenty are counted.
///
/// ```
/// use profivac_gsd_slave::listed;
///
/// assert_eq!(listed(["a.gsd", "b.gsd"].map(str::to_owned)), "a.gsd, b.gsd");
/// assert_eq!(listed([]), "none");
/// assert!(listed((1..=25).map(|number| number.to_string())).ends_with("19, 20 and 5 more"));
/// ```
pub fn listed(things: impl IntoIterator<Item = String>) -> String {
    let mut things = things.into_iter();
    let shown: Vec<_> = things.by_ref().take(MOST).collect();
    match things.count() {
        0 if shown.is_empty() => "none".to_owned(),
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
