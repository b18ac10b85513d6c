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

/// The model with this name, such as `bcg450`.
#[must_use]
pub fn model_named(name: &str) -> Option<&'static Model> {
    MODELS.into_iter().find(|model| model.name == name)
}

/// The models with this Ident_Number; related devices share one.
pub fn models_with_ident(ident: u16) -> impl Iterator<Item = &'static Model> {
    MODELS.into_iter().filter(move |model| model.ident == ident)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_found_by_its_name_and_by_its_ident_number() {
        for model in MODELS {
            assert!(model_named(model.name).is_some_and(|found| core::ptr::eq(found, model)), "{}", model.name);
            assert!(models_with_ident(model.ident).any(|found| core::ptr::eq(found, model)), "{}", model.name);
        }
        assert!(model_named("bcg451").is_none());
    }
}
