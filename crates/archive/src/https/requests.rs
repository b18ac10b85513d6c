//! Requests of users to stations without NATS: the station polls for a request, and posts its reply.
//!
//! | Request | Answer |
//! |---|---|
//! | `GET /v1/PLANT/STATION/request` | 200 with a request as JSON and its id in the header `Profivac-Request`; 204 when none came within 20 s |
//! | `POST /v1/PLANT/STATION/request/ID` with the reply as JSON | 204; 410 when no user waits for it; 413 when it is too long |

use super::{Shared, refuse};
use axum::body::to_bytes;
use axum::extract::{Path, Request, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use profivac_archive_protocol::request::REQUEST_HEADER;
use std::sync::Arc;

/// The most octets of a reply: a trend of 4,000 entries has a third of it, and a server of NATS passes on no more.
pub const MAX_REPLY: usize = 1 << 20;

/// Waits for a request to the station.
pub(super) async fn next(
    State(shared): State<Arc<Shared>>,
    Path((plant, station)): Path<(String, String)>,
    request: Request,
) -> Response {
    if let Err(refusal) = shared.authorise(&plant, &station, &request) {
        return *refusal;
    }
    match shared.pending.next(&plant, &station).await {
        Some(handed) => ([(REQUEST_HEADER, handed.id.reveal().to_owned())], handed.body).into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

/// Takes the reply to a request. One for which no user waits is refused before it is read, or as soon as the user has gone.
pub(super) async fn reply(
    State(shared): State<Arc<Shared>>,
    Path((plant, station, id)): Path<(String, String, String)>,
    request: Request,
) -> Response {
    if let Err(refusal) = shared.authorise(&plant, &station, &request) {
        return *refusal;
    }
    let Some(mut replying) = shared.pending.replying(&plant, &station, &id) else {
        return no_user_waits();
    };
    let read = tokio::select! {
        read = to_bytes(request.into_body(), MAX_REPLY) => read,
        () = replying.closed() => return no_user_waits(),
    };
    match read {
        Ok(reply) => {
            // The user may have gone in this moment.
            replying.send(reply.to_vec()).ok();
            StatusCode::NO_CONTENT.into_response()
        }
        Err(_) => {
            let expected = format!("expected a whole reply of at most {MAX_REPLY} octets");
            refuse(StatusCode::PAYLOAD_TOO_LARGE, &expected)
        }
    }
}

fn no_user_waits() -> Response {
    refuse(StatusCode::GONE, "no user waits for this reply: its request is answered, or its time is over")
}
