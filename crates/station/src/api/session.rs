//! Who asks, as they are seen from here.

use crate::people::{Person, Role};
use axum::Json;
use serde::Serialize;
use utoipa::ToSchema;

/// Who asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Session {
    /// Their name.
    name: String,
    /// What they may do.
    role: Role,
}

#[utoipa::path(get, path = "/api/session", responses((status = 200, body = Session)))]
pub async fn session(person: Person) -> Json<Session> {
    Json(Session { name: person.name.to_string(), role: person.role })
}
