//! What every path may answer because of the gate before it, for the description of the API.

use utoipa::Modify;
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::{ContentBuilder, OpenApi, Ref, Response, ResponseBuilder};

/// What the gate may answer to everything.
const ALWAYS: [(&str, &str); 4] = [
    ("401", "Nobody has logged in"),
    ("403", "The page that asks is not ours, or whoever asks may not"),
    ("421", "This computer is called otherwise"),
    ("429", "Too often; the header Retry-After says for how long"),
];

/// And to what has a body.
const WITH_BODY: [(&str, &str); 3] =
    [("408", "The body takes too long"), ("413", "The body is too large"), ("415", "The body is no JSON")];

/// Adds what the gate may answer to all paths.
pub struct CommonResponses;

impl Modify for CommonResponses {
    fn modify(&self, description: &mut OpenApi) {
        for PathItem { get, post, delete, .. } in description.paths.paths.values_mut() {
            for operation in [&mut *get, post, delete].into_iter().flatten() {
                add(operation, &ALWAYS);
            }
            for operation in [post, delete].into_iter().flatten() {
                add(operation, &WITH_BODY);
            }
        }
    }
}

fn add(operation: &mut Operation, answers: &[(&str, &str)]) {
    for (status, words) in answers {
        operation.responses.responses.entry((*status).to_owned()).or_insert_with(|| problem(words).into());
    }
}

fn problem(words: &str) -> Response {
    let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
    ResponseBuilder::new().description(words).content("application/json", content).build()
}
