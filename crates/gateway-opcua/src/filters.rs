//! Filters of events, as far as they may be evaluated.
//!
//! An element of a `ContentFilter` refers to others by index. The library looks for loops along every path between the elements when a
//! client makes or changes a monitored item, and follows every path again for each event. With two operands in each element the paths
//! double from one element to the next, so a filter of fifty elements occupies the thread of the gateway for ever. This loader of types
//! stands before that of the library, and refuses such a filter while its message is decoded, and one that is too long.

use opcua_types::{
    BinaryDecodable, ContentFilter, Context, DynEncodable, ElementOperand, EncodingResult, Error, EventFilter,
    FallbackTypeLoader, GeneratedTypeLoader, NodeId, ObjectId, TypeLoader, TypeLoaderCollection, TypeLoaderPriority,
};
use std::io::{self, Read};

/// The most elements that one evaluation of a filter may visit, each as often as paths lead to it. chosen: a client that selects
/// alarms by type, severity and source has some ten; and the library calls itself for each of a chain.
const MAX_VISITS: usize = 100;

/// The longest filter of events in octets. chosen: some 500 fields; a client selects some 50.
const MAX_FILTER: u64 = 32 << 10;

/// Decodes filters of events, and refuses those that cost too much.
///
/// Elsewhere it refuses operands that refer to elements: a query has the same filter, and the station has no queries.
#[derive(Default)]
pub struct Filters(TypeLoaderCollection);

/// The loaders of the server: this one, then those of the library. A loader that is added to those of the library comes after them, and is
/// not asked about their types.
#[must_use]
pub fn loaders() -> TypeLoaderCollection {
    let mut all = TypeLoaderCollection::new_empty();
    all.add_type_loader(Filters::default());
    all.add_type_loader(GeneratedTypeLoader);
    all.add_type_loader(FallbackTypeLoader);
    all
}

impl TypeLoader for Filters {
    fn load_from_binary(
        &self,
        node_id: &NodeId,
        stream: &mut dyn Read,
        context: &Context<'_>,
        _length: Option<usize>,
    ) -> Option<EncodingResult<Box<dyn DynEncodable>>> {
        match node_id.as_object_id().ok()? {
            ObjectId::EventFilter_Encoding_DefaultBinary => {
                // Inside of the filter the loaders of the library decode alone.
                let inner = Context::new(context.namespaces(), &self.0, context.options().clone());
                // The length that the message names may be wrong.
                Some(event_filter(&mut stream.take(MAX_FILTER), &inner).map(|filter| Box::new(filter) as _))
            }
            ObjectId::ElementOperand_Encoding_DefaultBinary => {
                Some(Err(Error::decoding("operands that refer to elements are permitted in filters of events alone")))
            }
            _ => None,
        }
    }

    fn priority(&self) -> TypeLoaderPriority {
        TypeLoaderPriority::Core
    }
}

fn event_filter(stream: &mut io::Take<&mut dyn Read>, context: &Context<'_>) -> EncodingResult<EventFilter> {
    let filter = EventFilter::decode(stream, context).map_err(|error| {
        let is_too_long = stream.limit() == 0;
        if is_too_long { Error::decoding(format!("the filter has more than {MAX_FILTER} octets")) } else { error }
    })?;
    check(&filter.where_clause)?;
    Ok(filter)
}

/// Checks the references between the elements of a filter. OPC 10000-4, 7.7.4.2: a reference leads to a later element.
fn check(filter: &ContentFilter) -> Result<(), Error> {
    let elements = filter.elements.as_deref().unwrap_or_default();
    // How many elements an evaluation visits from each element on.
    let mut visits = vec![1_usize; elements.len()];
    for (index, element) in elements.iter().enumerate().rev() {
        let operands = element.filter_operands.iter().flatten();
        for operand in operands.filter_map(|operand| operand.inner_as::<ElementOperand>()) {
            let target = usize::try_from(operand.index).unwrap_or(usize::MAX);
            let behind = visits.get(target).filter(|_| target > index).copied().ok_or_else(|| {
                let elements = elements.len();
                Error::decoding(format!("element {index} of {elements} refers to {target}; expected a later element"))
            })?;
            if let Some(own) = visits.get_mut(index) {
                *own = own.saturating_add(behind);
            }
        }
    }
    match visits.first() {
        Some(visits) if *visits > MAX_VISITS => {
            Err(Error::decoding(format!("the filter visits {visits} elements; expected at most {MAX_VISITS}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use opcua_types::{
        BinaryEncodable, ContentFilterElement, ContextOwned, DecodingOptions, ExtensionObject, FilterOperator,
        LiteralOperand, NamespaceMap, SimpleAttributeOperand,
    };

    /// A filter whose elements refer to these elements each.
    fn filter(references: &[&[u32]]) -> EventFilter {
        let element = |references: &&[u32]| {
            let literal = ExtensionObject::from_message(LiteralOperand::from(true));
            let operands =
                references.iter().map(|index| ExtensionObject::from_message(ElementOperand { index: *index }));
            ContentFilterElement {
                filter_operator: FilterOperator::InList,
                filter_operands: Some(std::iter::once(literal).chain(operands).collect()),
            }
        };
        let where_clause = ContentFilter { elements: Some(references.iter().map(element).collect()) };
        EventFilter { select_clauses: None, where_clause }
    }

    /// What the server makes of an extension object in a message.
    fn received(object: &ExtensionObject) -> Result<ExtensionObject, String> {
        let context = ContextOwned::new(NamespaceMap::default(), loaders(), DecodingOptions::default());
        let octets = object.encode_to_vec(&context.context());
        ExtensionObject::decode(&mut octets.as_slice(), &context.context()).map_err(|error| error.to_string())
    }

    fn refusal(references: &[&[u32]]) -> String {
        received(&ExtensionObject::from_message(filter(references))).unwrap_err()
    }

    #[test]
    fn a_filter_of_a_client_passes() {
        // A client combines two conditions, one of which it names twice.
        let usual = ExtensionObject::from_message(filter(&[&[1, 2], &[3, 3], &[], &[]]));
        assert_eq!(received(&usual).unwrap(), usual);
        let none = ExtensionObject::from_message(EventFilter::default());
        assert_eq!(received(&none).unwrap(), none);
    }

    #[test]
    fn a_filter_whose_paths_double_is_refused() {
        let references: Vec<[u32; 2]> = (1..50).map(|index| [index; 2]).collect();
        let mut references: Vec<&[u32]> = references.iter().map(|it| &it[..]).collect();
        references.push(&[]);
        let refusal = refusal(&references);
        assert!(refusal.ends_with("the filter visits 1125899906842623 elements; expected at most 100"), "{refusal}");
    }

    #[test]
    fn a_chain_has_an_end() {
        let chain: Vec<[u32; 1]> = (1..=100).map(|index| [index]).collect();
        let of = |length: usize| {
            let links = chain.iter().take(length - 1).map(|it| &it[..]);
            received(&ExtensionObject::from_message(filter(&links.chain([&[][..]]).collect::<Vec<_>>())))
        };
        assert!(of(MAX_VISITS).is_ok());
        assert!(of(MAX_VISITS + 1).is_err());
    }

    #[test]
    fn a_filter_with_too_many_fields_is_refused() {
        let with_fields = |count| {
            let field = SimpleAttributeOperand { browse_path: Some(vec!["Severity".into(); 3]), ..Default::default() };
            let filter = EventFilter { select_clauses: Some(vec![field; count]), ..EventFilter::default() };
            received(&ExtensionObject::from_message(filter))
        };
        assert!(with_fields(500).is_ok());
        let refusal = with_fields(900).unwrap_err();
        assert!(refusal.ends_with("the filter has more than 32768 octets"), "{refusal}");
    }

    #[test]
    fn a_reference_leads_to_a_later_element() {
        for references in [&[&[0][..]][..], &[&[1], &[0]], &[&[], &[1]], &[&[], &[9]]] {
            let refusal = refusal(references);
            assert!(refusal.ends_with("expected a later element"), "{refusal}");
        }
    }

    #[test]
    fn the_filter_of_a_query_refers_to_no_elements() {
        let operand = ExtensionObject::from_message(ElementOperand { index: 1 });
        assert!(received(&operand).is_err());
        let literal = ExtensionObject::from_message(LiteralOperand::from(true));
        assert_eq!(received(&literal).unwrap(), literal);
    }
}
