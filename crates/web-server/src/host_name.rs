//! Host names as they occur in a `Host` header, in URLs and in the configuration file.

use axum::http::uri::Authority;
use std::net::IpAddr;

/// The host without its port, without a final dot and without the brackets of an IPv6 address. `None` if `text` is not a host
/// or contains a user name.
#[must_use]
pub fn host(text: &str) -> Option<String> {
    let authority = text.parse::<Authority>().ok().filter(|_| !text.contains('@'))?;
    Some(authority.host().trim_end_matches('.').trim_start_matches('[').trim_end_matches(']').to_owned())
}

/// Whether a host, with or without a port, is `localhost` or a loopback address.
#[must_use]
pub fn is_loopback(text: &str) -> bool {
    let is_loopback_address = |host: &str| host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback());
    // An IPv6 address without brackets is no host of a URL.
    is_loopback_address(text)
        || host(text).is_some_and(|host| host.eq_ignore_ascii_case("localhost") || is_loopback_address(&host))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_localhost_and_loopback_addresses_are_loopback() {
        for name in
            ["localhost", "LOCALHOST:8080", "127.0.0.1:8080", "127.1.2.3", "[::1]:8080", "[::1]", "::1", "localhost."]
        {
            assert!(is_loopback(name), "{name}");
        }
        for name in [
            "",
            "evil.example",
            "evil@localhost",
            "localhost.evil.example:8080",
            "10.0.0.1",
            "[fe80::1]",
            "127.0.0.1.evil.example",
        ] {
            assert!(!is_loopback(name), "{name}");
        }
    }
}
