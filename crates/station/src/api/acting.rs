//! Acting on gauges: the list of commands, arming, firing, and who has the mastership.

use super::archive::stopped;
use super::body::Body;
use super::gate::Peer;
use super::problem::Problem;
use crate::act::allowed::{self, Risk};
use crate::act::draft::Wish;
use crate::act::orders::Order;
use crate::act::{self, Actor, Fired, Move, NotDone};
use crate::people::{Person, Role};
use crate::plant::Plant;
use crate::view::{Mastership, whole_milliseconds};
use axum::Json;
use axum::extract::{FromRequestParts, Path, State};
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use profivac_client::Condition;
use profivac_client::conditions::wanted;
use profivac_client::names::{Names, command_name};
use profivac_virtual::factory::entry;
use serde::Serialize;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;
use utoipa::ToSchema;

/// A command of a gauge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Command {
    /// By what it is armed: `ba.degas-on`.
    command: String,
    /// The manual's name of the parameter by which it is sent.
    name: String,
    /// Its slot and index.
    numbers: String,
    /// What must be the case.
    conditions: Vec<String>,
    /// What it risks.
    risk: Risk,
    /// Who may.
    role: Role,
    /// Why nobody may from here.
    barred: Option<String>,
}

/// A condition, and whether it holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Held {
    /// What must be the case.
    wanted: String,
    /// What is the case.
    found: String,
    /// Whether that is enough.
    holds: bool,
}

impl Held {
    fn of(conditions: &[Condition]) -> Vec<Self> {
        let held = |condition: &Condition| Self {
            wanted: condition.wanted.clone(),
            found: condition.found.clone(),
            holds: condition.unmet.is_none(),
        };
        conditions.iter().map(held).collect()
    }
}

/// Something that is armed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Armed {
    /// By what it is fired.
    order: String,
    /// The gauge.
    gauge: String,
    /// The command or the parameter.
    target: String,
    /// The manual's name and numbers.
    manual: String,
    /// Whether it is a command.
    is_command: bool,
    /// What it is now; nothing if it cannot be read.
    before: Option<String>,
    /// What it is to be.
    after: String,
    /// The octets that are sent.
    octets: String,
    /// What it risks.
    risk: Risk,
    /// All conditions; all hold.
    conditions: Vec<Held>,
    /// How much longer it is armed, in milliseconds.
    left_ms: u64,
}

impl From<Order> for Armed {
    fn from(order: Order) -> Self {
        let Order { id, gauge, choice, draft, until, .. } = order;
        Self {
            order: id,
            gauge,
            target: choice.target(),
            manual: choice.manual(),
            is_command: choice.command.is_some(),
            octets: draft.hex(),
            before: draft.before.map(|(text, _)| text),
            after: draft.after,
            risk: draft.risk,
            conditions: Held::of(&draft.conditions),
            left_ms: whole_milliseconds(until.saturating_duration_since(Instant::now())),
        }
    }
}

/// Something that was fired and done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Outcome {
    /// The order.
    order: String,
    /// The gauge.
    gauge: String,
    /// The command or the parameter.
    target: String,
    /// The octets that were sent.
    octets: String,
    /// What it was.
    before: Option<String>,
    /// What it is now, as it was read back; nothing if it cannot be read.
    after: Option<String>,
}

impl From<Fired> for Outcome {
    fn from(Fired { order, done }: Fired) -> Self {
        let octets = order.draft.hex();
        let target = order.choice.target();
        Self { order: order.id, gauge: order.gauge, target, octets, before: done.before, after: done.after }
    }
}

/// Why nothing was armed or done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Unmet {
    /// In a sentence.
    problem: String,
    /// All conditions, if one of them is the reason.
    conditions: Vec<Held>,
}

impl IntoResponse for NotDone {
    fn into_response(self) -> Response {
        let sentence = self.to_string();
        match self {
            Self::Unknown(_) => Problem::unknown(sentence).into_response(),
            Self::Bad(_) => Problem::bad(sentence).into_response(),
            Self::Forbidden(_) => Problem::forbidden(sentence).into_response(),
            Self::Disk(_) => Problem::unavailable(sentence).into_response(),
            Self::Conflict(_, conditions) => {
                let unmet = Unmet { problem: sentence, conditions: Held::of(&conditions) };
                (StatusCode::CONFLICT, Json(unmet)).into_response()
            }
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Actor {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Infallible> {
        let person = Person::from_request_parts(parts, state).await?;
        let peer = parts.extensions.get::<Peer>().map(|Peer(peer)| *peer);
        Ok(Self { person, peer })
    }
}

/// Something that waits, on a thread that may. It goes on when whoever asked has gone.
async fn waited<T: Send + 'static>(work: impl FnOnce() -> Result<T, NotDone> + Send + 'static) -> Result<T, Response> {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(error)) => Err(error.into_response()),
        Err(error) => Err(stopped(&error).into_response()),
    }
}

/// The commands of a gauge with what they ask for and risk. The gauge is not asked.
#[utoipa::path(
    get,
    path = "/api/gauges/{name}/commands",
    params(("name" = String, Path, description = "The name of the gauge")),
    responses((status = 200, body = [Command]), (status = 404, body = Problem))
)]
pub async fn commands(
    State(plant): State<Arc<Plant>>,
    Path(name): Path<String>,
) -> Result<Json<Vec<Command>>, Problem> {
    let unknown = || Problem::unknown(format!("there is no gauge {name:?}"));
    let gauge = plant.gauge(&name).ok_or_else(unknown)?;
    let names = entry(&gauge.device).ok().and_then(|entry| Names::known(entry.model));
    let Some(names) = names else { return Ok(Json(Vec::new())) };
    let command = |(named, code): (&profivac_client::names::Named, _)| {
        let row = named.parameter.row;
        Command {
            command: command_name(named, code),
            name: row.name.to_owned(),
            numbers: named.parameter.numbers(),
            conditions: wanted(names, named, code),
            risk: allowed::risk(row, Some(code)),
            role: allowed::role(row, Some(code)),
            barred: allowed::barred(row).map(str::to_owned),
        }
    };
    Ok(Json(names.commands().map(command).collect()))
}

/// The first step: the gauge is asked, and if all conditions hold it is armed for 30 seconds. Needs the mastership.
#[utoipa::path(
    post,
    path = "/api/gauges/{name}/arm",
    params(("name" = String, Path, description = "The name of the gauge")),
    request_body = Wish,
    responses(
        (status = 200, body = Armed),
        (status = 400, body = Problem),
        (status = 403, body = Problem),
        (status = 404, body = Problem),
        (status = 408, body = Problem, description = "The body did not come"),
        (status = 409, body = Unmet, description = "Not the mastership, a condition that does not hold, or a gauge that does not answer"),
        (status = 413, body = Problem, description = "The body is too long"),
        (status = 415, body = Problem, description = "The body is no JSON")
    )
)]
pub async fn arm(
    State(plant): State<Arc<Plant>>,
    Path(name): Path<String>,
    actor: Actor,
    Body(wish): Body<Wish>,
) -> Result<Json<Armed>, Response> {
    let order = waited(move || act::arm(&plant, &actor, &name, &wish)).await?;
    Ok(Json(order.into()))
}

/// The second step: what was armed is done, once, if everything is as it was then. Needs the mastership.
#[utoipa::path(
    post,
    path = "/api/orders/{id}/fire",
    params(("id" = String, Path, description = "The order")),
    responses(
        (status = 200, body = Outcome),
        (status = 403, body = Problem),
        (status = 404, body = Problem),
        (status = 409, body = Unmet, description = "Not in time, not the mastership, not the same as it was, or the gauge refused"),
        (status = 503, body = Problem, description = "The audit trail cannot be written")
    )
)]
pub async fn fire(
    State(plant): State<Arc<Plant>>,
    Path(id): Path<String>,
    actor: Actor,
) -> Result<Json<Outcome>, Response> {
    let fired = waited(move || act::fire(&plant, &actor, &id)).await?;
    Ok(Json(fired.into()))
}

/// What was armed is not armed any more.
#[utoipa::path(
    delete,
    path = "/api/orders/{id}",
    params(("id" = String, Path, description = "The order")),
    responses((status = 204), (status = 403, body = Problem), (status = 404, body = Problem), (status = 409, body = Unmet))
)]
pub async fn disarm(
    State(plant): State<Arc<Plant>>,
    Path(id): Path<String>,
    actor: Actor,
) -> Result<StatusCode, Response> {
    waited(move || act::disarm(&plant, &actor, &id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Who may act now.
#[utoipa::path(get, path = "/api/mastership", responses((status = 200, body = Mastership)))]
pub async fn mastership(State(plant): State<Arc<Plant>>) -> Json<Mastership> {
    Json(act::mastership(&plant, Instant::now()))
}

async fn passed(plant: Arc<Plant>, actor: Actor, wanted: Move) -> Result<Json<Mastership>, Response> {
    let now = waited(move || {
        act::pass(&plant, &actor, wanted, Instant::now())?;
        Ok(act::mastership(&plant, Instant::now()))
    });
    Ok(Json(now.await?))
}

/// Somebody wants the mastership: if it is free they have it, else its holder is told.
#[utoipa::path(post, path = "/api/mastership/ask", responses((status = 200, body = Mastership), (status = 403, body = Problem), (status = 409, body = Unmet)))]
pub async fn ask(State(plant): State<Arc<Plant>>, actor: Actor) -> Result<Json<Mastership>, Response> {
    passed(plant, actor, Move::Ask).await
}

/// Its holder gives the mastership back.
#[utoipa::path(post, path = "/api/mastership/release", responses((status = 200, body = Mastership), (status = 403, body = Problem), (status = 409, body = Unmet)))]
pub async fn release(State(plant): State<Arc<Plant>>, actor: Actor) -> Result<Json<Mastership>, Response> {
    passed(plant, actor, Move::Release).await
}

/// Its holder gives the mastership to who asked.
#[utoipa::path(post, path = "/api/mastership/grant", responses((status = 200, body = Mastership), (status = 403, body = Problem), (status = 409, body = Unmet)))]
pub async fn grant(State(plant): State<Arc<Plant>>, actor: Actor) -> Result<Json<Mastership>, Response> {
    passed(plant, actor, Move::Grant).await
}

/// Somebody takes the mastership from its holder: an engineer at any time, an operator 60 s after asking without a reaction.
#[utoipa::path(post, path = "/api/mastership/take-over", responses((status = 200, body = Mastership), (status = 403, body = Problem), (status = 409, body = Unmet)))]
pub async fn take_over(State(plant): State<Arc<Plant>>, actor: Actor) -> Result<Json<Mastership>, Response> {
    passed(plant, actor, Move::TakeOver).await
}
