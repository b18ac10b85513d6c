//! Lists in messages, and texts in files.

/// At most this many things are listed.
const MOST: usize = 20;

/// The things with commas; what is beyond twenty is counted.
pub(crate) fn list(things: impl Iterator<Item = String>) -> String {
    let things: Vec<_> = things.collect();
    let shown = things.get(..MOST.min(things.len())).unwrap_or_default().join(", ");
    match things.len().saturating_sub(MOST) {
        0 if things.is_empty() => "none".to_owned(),
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Octets in hexadecimal: `80 00`.
pub(crate) fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

/// A text in quotation marks, on one line. A quotation mark within it becomes an apostrophe, because it would end the text.
pub(crate) fn quoted(text: &str) -> String {
    let line: String = text
        .chars()
        .map(|one| {
            if one.is_control() {
                ' '
            } else if one == '"' {
                '\''
            } else {
                one
            }
        })
        .collect();
    format!("\"{line}\"")
}
