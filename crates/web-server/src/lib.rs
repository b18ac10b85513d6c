//! HTTP as the station and the archive serve it: a server with TLS, users, sessions and limits, and what their APIs share.
//!
//! ```text
//! connection ─ permit ─ TLS ─ middleware: rate, host, origin, session, token, body ─ router of the program
//!    server     auth             middleware, authenticator, headers
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`server`] | the listener, TLS, connections and their limits |
//! | [`middleware`] | the checks before every handler |
//! | [`authenticator`] | logins and sessions |
//! | [`auth`] | users, roles, passwords, sessions, OpenID, rate limits |
//! | [`session`] | the paths for login, logout and passwords |
//! | [`headers`] | security headers, requested hosts |
//! | [`problem`] | problem documents |
//! | [`body`], [`query`] | bodies and query parameters |
//! | [`live_source`], [`compression`] | a state and its changes as a stream, and their compression |
//! | [`tables`] | tables that the files of a station and of an archive share |
//! | [`scrape`], [`exposition`] | `/metrics` for Prometheus, and its text |
//! | [`client_tls`], [`http_client`] | TLS and HTTP requests to servers of others |
//! | [`host_name`], [`visible_text`] | host names; names, reasons and comments that users type |

// The types and handlers keep the attributes of the description, which expand to nothing then (DESIGN 426).
#[cfg(not(feature = "openapi"))]
extern crate profivac_no_openapi as utoipa;

pub mod auth;
pub mod authenticator;
pub mod body;
pub mod client_tls;
pub mod compression;
pub mod exposition;
pub mod headers;
pub mod host_name;
pub mod http_client;
pub mod live_source;
pub mod middleware;
pub mod problem;
pub mod query;
pub mod scrape;
pub mod server;
pub mod session;
pub mod tables;
pub mod visible_text;
