//! The twelve device models, in the order of their manuals.

use crate::model::Model;
use crate::{bcg450, img400, pxg55x, tpg, xpg400};

/// All device models.
pub static MODELS: [&Model; 12] = [
    &pxg55x::table::PCG550_WITH_ATM.model,
    &pxg55x::table::PCG552_WITH_ATM.model,
    &pxg55x::table::PCG554_WITH_ATM.model,
    &pxg55x::table::PSG550.model,
    &pxg55x::table::PSG552.model,
    &pxg55x::table::PSG554.model,
    &xpg400::table::BPG400.model,
    &xpg400::table::HPG400.model,
    &bcg450::table::MODEL,
    &tpg::table::TPG300,
    &tpg::table::TPG500,
    &img400::table::MODEL,
];

/// The model with this name in any case, or with this name on the device: `bcg450`, `BCG450-SP`.
#[must_use]
pub fn model_named(name: &str) -> Option<&'static Model> {
    MODELS.into_iter().find(|model| model.is_called(name))
}

/// The models with this Ident_Number; related devices share one.
pub fn models_with_ident(ident: u16) -> impl Iterator<Item = &'static Model> {
    MODELS.into_iter().filter(move |model| model.ident == ident)
}

/// The model of a device of which only the Ident_Number is known: where several models have it, the first of a series, or
/// the common one of TPG300 and TPG500, which nothing on the bus tells apart.
#[must_use]
pub fn model_with_ident(ident: u16) -> Option<&'static Model> {
    if ident == tpg::table::TPG.ident { Some(&tpg::table::TPG) } else { models_with_ident(ident).next() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_found_by_its_name_and_by_its_ident_number() {
        for model in MODELS {
            assert!(model_named(model.name).is_some_and(|found| core::ptr::eq(found, model)), "{}", model.name);
            assert!(model_named(model.title).is_some_and(|found| core::ptr::eq(found, model)), "{}", model.title);
            assert!(models_with_ident(model.ident).any(|found| core::ptr::eq(found, model)), "{}", model.name);
        }
        for other in ["bcg451", "", "-sp", "bcg450-spx", "bcg450\u{e9}", "\u{e9}sp"] {
            assert!(model_named(other).is_none(), "{other}");
        }
        assert!(model_with_ident(0xFFFF).is_none());
    }

    #[test]
    fn devices_that_the_bus_does_not_tell_apart_have_a_name_for_both() {
        for model in MODELS {
            let found = model_with_ident(model.ident).unwrap();
            assert!(core::ptr::eq(found.blocks, model.blocks) || model.features.dpv1, "{}", model.name);
            for other in models_with_ident(model.ident).filter(|other| !other.features.dpv1) {
                assert!(found.name.contains(other.name) && found.title.contains(other.title), "{}", other.name);
            }
        }
    }
}
