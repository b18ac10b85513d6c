//! The OpenAPI description: the handlers, the answers that the middleware may give to every request, and the content type of
//! problem documents.

use super::{
    alarm_settings, alarms, audit, backup, bus, control, history, identify, live, notes, plant_states, pump_downs,
    report, snapshot,
};
use profivac_web_server::problem::PROBLEM_JSON;
use profivac_web_server::session;
use serde_json::Value;
use std::collections::HashSet;
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::{ContentBuilder, OpenApi, Ref, RefOr, Response, ResponseBuilder, Schema};
use utoipa::{Modify, OpenApi as _};

/// The description of the API.
#[derive(utoipa::OpenApi)]
#[openapi(
    info(
        title = "profivac station",
        description = "Readings, records, alarms and control of a vacuum station. Pressures are in Pa, times in milliseconds since 1970 (UTC)."
    ),
    modifiers(&CommonResponses),
    paths(
        snapshot::station,
        snapshot::segments,
        bus::bus,
        bus::captures,
        bus::capture,
        bus::trigger,
        snapshot::gauges,
        snapshot::gauge,
        snapshot::blocks,
        snapshot::gateways,
        snapshot::plant,
        snapshot::directory,
        history::trend,
        history::events,
        notes::make,
        history::rise,
        identify::identify,
        report::report,
        pump_downs::pump_downs,
        history::export,
        history::export_parquet,
        history::points,
        history::point_trend,
        history::export_points,
        history::export_points_parquet,
        alarms::alarms,
        alarms::history,
        alarms::performance,
        alarms::acknowledge,
        alarms::acknowledge_all,
        alarms::shelve,
        alarms::unshelve,
        alarms::out_of_service,
        alarms::return_to_service,
        alarm_settings::settings,
        alarm_settings::change,
        alarm_settings::defaults,
        alarm_settings::change_default,
        plant_states::plant_states,
        plant_states::declare,
        plant_states::extend,
        plant_states::end,
        alarms::webhooks,
        live::live,
        session::session,
        session::login,
        session::openid_begin,
        session::openid_login,
        session::logout,
        session::password,
        control::commands,
        control::arm,
        control::execute,
        control::disarm,
        control::authority,
        control::request,
        control::release,
        control::grant,
        control::take_over,
        audit::audit,
        audit::csv,
        backup::backup,
        backup::download
    )
)]
struct Description;

/// The description of the API as JSON.
#[must_use]
pub fn description() -> String {
    Description::openapi().to_pretty_json().unwrap_or_default()
}

/// Answers to every request.
const COMMON: [(&str, &str); 4] = [
    ("401", "The user has not logged in"),
    ("403", "The user has no permission, or the request comes from a foreign page"),
    ("421", "The request is meant for another computer"),
    ("429", "The client is above a rate limit; the header Retry-After gives the time to wait in seconds"),
];

/// Answers to every request with a body.
const WITH_BODY: [(&str, &str); 3] = [
    ("408", "The body does not arrive in time"),
    ("413", "The body is longer than 64 KiB"),
    ("415", "The body is not JSON"),
];

/// Adds the answers of the middleware to every path, sets the content type of problem documents, and marks the properties of
/// answers as required.
struct CommonResponses;

impl Modify for CommonResponses {
    fn modify(&self, description: &mut OpenApi) {
        for PathItem { get, post, delete, .. } in description.paths.paths.values_mut() {
            for operation in [&mut *get, &mut *post, &mut *delete].into_iter().flatten() {
                add(operation, &COMMON);
            }
            for operation in [&mut *post, &mut *delete].into_iter().flatten() {
                add(operation, &WITH_BODY);
            }
            for operation in [get, post, delete].into_iter().flatten() {
                set_problem_type(operation);
            }
        }
        require_properties(description);
    }
}

/// An answer has all properties of its schema: a property without a value is `null`.
fn require_properties(description: &mut OpenApi) {
    let Some(components) = &mut description.components else { return };
    let schemas = serde_json::to_value(&components.schemas).unwrap_or_default();
    let mut answers = HashSet::new();
    for PathItem { get, post, delete, .. } in description.paths.paths.values() {
        for operation in [get, post, delete].into_iter().flatten() {
            let responses = serde_json::to_value(&operation.responses).unwrap_or_default();
            references(&responses, &schemas, &mut answers);
        }
    }
    for (name, schema) in &mut components.schemas {
        if answers.contains(name) {
            require_all(schema);
        }
    }
}

fn require_all(schema: &mut RefOr<Schema>) {
    match schema {
        RefOr::T(Schema::Object(object)) => object.required = object.properties.keys().cloned().collect(),
        RefOr::T(Schema::AllOf(parts)) => parts.items.iter_mut().for_each(require_all),
        _ => {}
    }
}

/// Collects the names of all schemas that `part` refers to, directly or through other schemas.
fn references(part: &Value, schemas: &Value, found: &mut HashSet<String>) {
    match part {
        Value::Array(items) => items.iter().for_each(|item| references(item, schemas, found)),
        Value::Object(properties) => {
            let reference = properties.get("$ref").and_then(Value::as_str).and_then(|path| path.rsplit('/').next());
            if let Some(name) = reference.filter(|name| found.insert((*name).to_owned())) {
                references(schemas.get(name).unwrap_or(&Value::Null), schemas, found);
            }
            properties.values().for_each(|value| references(value, schemas, found));
        }
        _ => {}
    }
}

fn add(operation: &mut Operation, responses: &[(&str, &str)]) {
    for (status, description) in responses {
        operation.responses.responses.entry((*status).to_owned()).or_insert_with(|| problem(description).into());
    }
}

/// Every answer from 400 on is a problem document.
fn set_problem_type(operation: &mut Operation) {
    for (status, response) in &mut operation.responses.responses {
        if let RefOr::T(response) = response
            && status.as_str() >= "400"
            && let Some(content) = response.content.shift_remove("application/json")
        {
            response.content.insert(PROBLEM_JSON.to_owned(), content);
        }
    }
}

fn problem(description: &str) -> Response {
    let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
    ResponseBuilder::new().description(description).content(PROBLEM_JSON, content).build()
}
