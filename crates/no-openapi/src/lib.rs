//! The attributes of `utoipa` that expand to nothing.
//!
//! `station` imports this crate under the name `utoipa` when it is built without the feature `openapi`. Its types and handlers
//! keep their attributes then, and the compiler skips what `utoipa` makes of them.

use proc_macro::TokenStream;

/// Accepts the attributes of a schema.
#[proc_macro_derive(ToSchema, attributes(schema))]
pub fn to_schema(_type: TokenStream) -> TokenStream {
    TokenStream::new()
}

/// Accepts the attributes of the parameters of a request.
#[proc_macro_derive(IntoParams, attributes(into_params, param))]
pub fn into_params(_type: TokenStream) -> TokenStream {
    TokenStream::new()
}

/// Accepts the description of a handler, and leaves the handler as it is.
#[proc_macro_attribute]
pub fn path(_description: TokenStream, handler: TokenStream) -> TokenStream {
    handler
}
