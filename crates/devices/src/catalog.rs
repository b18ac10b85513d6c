//! The twelve device models, in the order of their manuals, and the devices that a program knows.

use crate::model::Model;
use crate::{bcg450, img400, pxg55x, tpg, xpg400};

/// All built-in device models.
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

/// The devices that a program knows: the twelve, and those that device files describe.
///
/// A file is the word of the user: where it has the Ident_Number of a built-in device, its device is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KnownDevices {
    described: &'static [&'static Model],
}

impl KnownDevices {
    /// The twelve alone.
    pub const BUILT_IN: Self = Self { described: &[] };

    /// The twelve and these.
    #[must_use]
    pub const fn with(described: &'static [&'static Model]) -> Self {
        Self { described }
    }

    /// The devices of files.
    #[must_use]
    pub const fn described(self) -> &'static [&'static Model] {
        self.described
    }

    /// The twelve, and `model` alone of those of files: what is known where a file names the device.
    #[must_use]
    pub fn narrowed_to(self, model: &Model) -> Self {
        let position = self.described.iter().position(|described| *described == model);
        Self { described: position.and_then(|position| self.described.get(position..=position)).unwrap_or_default() }
    }

    /// All devices: the twelve, then those of files.
    pub fn iter(self) -> impl Iterator<Item = &'static Model> {
        MODELS.iter().chain(self.described).copied()
    }

    /// The model with this name in any case, or with this name on the device: `bcg450`, `BCG450-SP`.
    #[must_use]
    pub fn named(self, name: &str) -> Option<&'static Model> {
        self.iter().find(|model| model.is_called(name))
    }

    /// The models with this Ident_Number; related devices share one.
    pub fn with_ident(self, ident: u16) -> impl Iterator<Item = &'static Model> {
        let is_described = self.described.iter().any(|model| model.ident == ident);
        let built_in = MODELS.iter().filter(move |_| !is_described);
        built_in.chain(self.described).copied().filter(move |model| model.ident == ident)
    }

    /// The names of the devices with this Ident_Number, in a list.
    pub fn names_with_ident(self, ident: u16) -> impl Iterator<Item = &'static str> {
        self.with_ident(ident).map(|model| model.name)
    }

    /// Whether a device has this Ident_Number.
    #[must_use]
    pub fn knows(self, ident: u16) -> bool {
        self.with_ident(ident).next().is_some()
    }

    /// The model of a device of which only the Ident_Number is known: where several models have it, the first of a series, or
    /// the common one of TPG300 and TPG500, which nothing on the bus tells apart.
    #[must_use]
    pub fn assumed_with_ident(self, ident: u16) -> Option<&'static Model> {
        let first = self.with_ident(ident).next()?;
        let is_common = tpg::table::TPG.ident == ident && MODELS.contains(&first);
        Some(if is_common { &tpg::table::TPG } else { first })
    }
}

/// Whether these tables are compiled in, those of a variant and of the model that stands for two devices too. The others come from a file.
#[must_use]
pub fn is_built_in(model: &Model) -> bool {
    let variants = pxg55x::table::VARIANTS.iter().map(|variant| &variant.model);
    MODELS.iter().copied().chain(variants).chain([&tpg::table::TPG]).any(|known| known == model)
}

/// The built-in model with this name in any case, or with this name on the device: `bcg450`, `BCG450-SP`.
#[must_use]
pub fn model_named(name: &str) -> Option<&'static Model> {
    KnownDevices::BUILT_IN.named(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_found_by_its_name_and_by_its_ident_number() {
        for model in MODELS {
            assert!(model_named(model.name).is_some_and(|found| core::ptr::eq(found, model)), "{}", model.name);
            assert!(model_named(model.title).is_some_and(|found| core::ptr::eq(found, model)), "{}", model.title);
            assert!(
                KnownDevices::BUILT_IN.with_ident(model.ident).any(|found| core::ptr::eq(found, model)),
                "{}",
                model.name
            );
        }
        for other in ["bcg451", "", "-sp", "bcg450-spx", "bcg450\u{e9}", "\u{e9}sp"] {
            assert!(model_named(other).is_none(), "{other}");
        }
        assert!(KnownDevices::BUILT_IN.assumed_with_ident(0xFFFF).is_none());
    }

    #[test]
    fn devices_that_the_bus_does_not_tell_apart_have_a_name_for_both() {
        for model in MODELS {
            let found = KnownDevices::BUILT_IN.assumed_with_ident(model.ident).unwrap();
            assert!(core::ptr::eq(found.blocks, model.blocks) || model.features.dpv1, "{}", model.name);
            for other in KnownDevices::BUILT_IN.with_ident(model.ident).filter(|other| !other.features.dpv1) {
                assert!(found.name.contains(other.name) && found.title.contains(other.title), "{}", other.name);
            }
        }
    }

    /// A file that describes a gauge with the ident of a built-in one is about the gauge that the user has.
    #[test]
    fn a_described_device_is_known_by_name_and_stands_for_its_ident_number() {
        let described = &pxg55x::table::PCG550.model;
        static DESCRIBED: [&Model; 2] = [&pxg55x::table::PCG550.model, &tpg::table::TPG];
        let devices = KnownDevices::with(&DESCRIBED);
        assert_eq!((devices.iter().count(), devices.described().len()), (14, 2));
        assert!(devices.assumed_with_ident(described.ident).is_some_and(|found| core::ptr::eq(found, described)));
        assert!(devices.names_with_ident(described.ident).eq([described.name]));
        assert!(devices.assumed_with_ident(bcg450::table::MODEL.ident).is_some() && devices.knows(0x0947));
        assert!(devices.named(tpg::table::TPG.name).is_some() && model_named(tpg::table::TPG.name).is_none());
        // Where a file names the device, the others of its Ident_Number do not count.
        assert_eq!(devices.narrowed_to(described).described(), [described]);
        assert_eq!(devices.narrowed_to(&bcg450::table::MODEL), KnownDevices::BUILT_IN);
        assert!(!devices.knows(0x0C86) && KnownDevices::BUILT_IN.names_with_ident(0x0C85).count() == 6);
    }
}
