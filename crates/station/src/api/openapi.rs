//! The answers that the middleware may give to every request, for the OpenAPI description.

use super::problem::PROBLEM_JSON;
use utoipa::Modify;
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::{ContentBuilder, OpenApi, Ref, Response, ResponseBuilder};

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

/// Adds the answers of the middleware to every path.
pub struct CommonResponses;

impl Modify for CommonResponses {
    fn modify(&self, description: &mut OpenApi) {
        for PathItem { get, post, delete, .. } in description.paths.paths.values_mut() {
            for operation in [&mut *get, post, delete].into_iter().flatten() {
                add(operation, &COMMON);
            }
            for operation in [post, delete].into_iter().flatten() {
                add(operation, &WITH_BODY);
            }
        }
    }
}

fn add(operation: &mut Operation, responses: &[(&str, &str)]) {
    for (status, description) in responses {
        operation.responses.responses.entry((*status).to_owned()).or_insert_with(|| problem(description).into());
    }
}

fn problem(description: &str) -> Response {
    let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
    ResponseBuilder::new().description(description).content(PROBLEM_JSON, content).build()
}
