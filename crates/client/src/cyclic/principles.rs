//! The measuring principles of the channels of a controller, as far as the bus reports them.
//!
//! The principle of a gauge is in its tables. A controller accepts different gauges: the IMG 400 shows the transducer block
//! of the connected gauge in slots 3 and 4, and its Block Type can be read (BG 5530 4.4.5 and 4.4.6). A TPG300 or TPG500
//! does not report its measuring boards: no row of i9973ber/a 3.2 names a gauge, and Sensor On_Off exists for a Pirani
//! gauge and for a cold cathode gauge alike. Its channels therefore have no principle, and their values are not corrected
//! for a gas.

use profivac_devices::Principle;
use profivac_devices::model::{Model, Part};

/// Block Type of the transducer blocks: BG 5530 Appendix C.
const TRANSDUCERS: [(u16, Principle); 3] =
    [(13, Principle::Pirani), (14, Principle::Diaphragm), (16, Principle::HotCathode)];

/// The index of Block Type in a transducer block: BG 5530 4.4.5.
pub(crate) const BLOCK_TYPE: u8 = 101;

/// No controller has more channels that its tables leave open.
const MAX_CHANNELS: usize = 4;

/// The principles that the tables leave open and the device reports.
///
/// ```
/// use profivac_client::cyclic::{ChannelPrinciples, open_instances};
/// use profivac_devices::catalog::model_named;
///
/// let img400 = model_named("img400").ok_or("no such model")?;
/// assert_eq!(open_instances(img400), [3, 4]);
/// // Block Type 14: a diaphragm.
/// assert_ne!(ChannelPrinciples::from_block_types([(3, &[0, 14, 0, 0][..])]), ChannelPrinciples::default());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChannelPrinciples([Option<(u8, Principle)>; MAX_CHANNELS]);

impl ChannelPrinciples {
    /// The principles of the `instances`, each with the octets of its Block Type, at most four.
    #[must_use]
    pub fn from_block_types<'a>(block_types: impl IntoIterator<Item = (u8, &'a [u8])>) -> Self {
        let mut known = Self::default();
        for (entry, (instance, octets)) in known.0.iter_mut().zip(block_types) {
            *entry = principle(octets).map(|principle| (instance, principle));
        }
        known
    }

    /// The principles of the `parts` of a device whose tables leave them open and which reports them, at most four.
    #[must_use]
    pub fn of_parts(model: &Model, parts: &[Part]) -> Self {
        let open = open_instances(model);
        let mut known = Self::default();
        let parts = parts.iter().filter(|part| open.contains(&part.instance));
        known.0.iter_mut().zip(parts).for_each(|(entry, part)| *entry = Some((part.instance, part.principle)));
        known
    }

    /// The principle of an instance or channel.
    pub(super) fn principle(&self, model: &Model, instance: u8) -> Option<Principle> {
        let from_device =
            || self.0.iter().flatten().find(|(known, _)| *known == instance).map(|(_, principle)| *principle);
        in_tables(model, instance).or_else(from_device)
    }
}

/// The principle of an instance, if the tables allow only one.
fn in_tables(model: &Model, instance: u8) -> Option<Principle> {
    let mut all = model.parts.iter().filter(|spec| spec.part.instance == instance).map(|spec| spec.part.principle);
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// The instances and channels of a model whose principle the tables leave open.
#[must_use]
pub fn open_instances(model: &Model) -> Vec<u8> {
    let mut open: Vec<u8> = model.parts.iter().map(|spec| spec.part.instance).collect();
    open.dedup();
    open.retain(|instance| in_tables(model, *instance).is_none());
    open
}

/// Block Type is a number as a word, then two zeros: errata-bpg-bcg-tpg 31.
fn principle(block_type: &[u8]) -> Option<Principle> {
    let [high, low, ..] = *block_type else { return None };
    let number = u16::from_be_bytes([high, low]);
    TRANSDUCERS.iter().find(|(known, _)| *known == number).map(|(_, principle)| *principle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::{bcg450, img400, tpg};

    #[test]
    fn the_tables_determine_a_principle_without_alternatives() {
        let none = ChannelPrinciples::default();
        let of = |model, instance| none.principle(model, instance);
        assert_eq!(of(&bcg450::table::MODEL, 1), Some(Principle::Pirani));
        assert_eq!(of(&img400::table::MODEL, 2), Some(Principle::HotCathode), "Bayard-Alpert or extractor");
        assert_eq!(of(&img400::table::MODEL, 3), None, "Pirani or diaphragm");
        assert!((1..=4).all(|channel| of(&tpg::table::TPG300, channel).is_none()));
    }

    #[test]
    fn the_block_type_determines_the_other_principles() {
        let known = ChannelPrinciples([Some((3, principle(&[0, 14, 0, 0]).unwrap())), None, None, None]);
        assert_eq!(known.principle(&img400::table::MODEL, 3), Some(Principle::Diaphragm));
        assert_eq!(known.principle(&img400::table::MODEL, 4), None);
        assert_eq!((principle(&[0, 99, 0, 0]), principle(&[13])), (None, None));
    }
}
