//! The measuring principles and ranges of the channels of a controller, as far as the bus reports them.
//!
//! The range of a gauge is in its tables. BG 5530 refers to the manuals of the connected gauges; the IMG 400 reports the range of
//! each as Underrange and Overrange. A TPG300 or TPG500 shows the end of the range in place of the pressure.
//!
//! The principle of a gauge is in its tables. A controller accepts different gauges: the IMG 400 shows the transducer block
//! of the connected gauge in slots 3 and 4, and its Block Type can be read (BG 5530 4.4.5 and 4.4.6). A TPG300 or TPG500
//! does not report its measuring boards: no row of i9973ber/a 3.2 names a gauge, and Sensor On_Off exists for a Pirani
//! gauge and for a cold cathode gauge alike. Its channels therefore have no principle, and their values are not corrected
//! for a gas.

use profivac_devices::Principle;
use profivac_devices::model::{MeasuringRange, Model, Part};

/// Block Type of the transducer blocks: BG 5530 Appendix C.
const TRANSDUCERS: [(u16, Principle); 3] =
    [(13, Principle::Pirani), (14, Principle::Diaphragm), (16, Principle::HotCathode)];

/// The index of Block Type in a transducer block: BG 5530 4.4.5.
pub(crate) const BLOCK_TYPE: u8 = 101;

/// No controller has more channels that its tables leave open.
const MAX_CHANNELS: usize = 4;

/// The principles and ranges that a device reports of the channels that its tables leave open.
///
/// ```
/// use profivac_client::cyclic::{ReportedChannels, open_instances};
/// use profivac_devices::Principle;
/// use profivac_devices::catalog::model_named;
/// use profivac_devices::model::{MeasuringRange, Part};
///
/// let img400 = model_named("img400").ok_or("no such model")?;
/// assert_eq!(open_instances(img400), [3, 4]);
/// // Block Type 14: a diaphragm.
/// let reported = ReportedChannels::from_block_types([(3, &[0, 14, 0, 0][..])]);
/// // Its range, 1e-2 Pa to 133 Pa.
/// let range = MeasuringRange { lowest_pa: 1e-2, highest_pa: 133.0 };
/// let reported = reported.with_range(3, range);
/// let part = Part { instance: 3, principle: Principle::Diaphragm };
/// assert_eq!(ReportedChannels::of_parts(img400, [(part, range)]), reported);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReportedChannels([ReportedChannel; MAX_CHANNELS]);

/// The principle and the range that a device reports of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ReportedChannel {
    /// The channel; 0 for an entry that is free.
    instance: u8,
    principle: Option<Principle>,
    range: Option<MeasuringRange>,
}

impl ReportedChannels {
    /// The `instances`, each with the octets of its Block Type, at most four.
    #[must_use]
    pub fn from_block_types<'a>(block_types: impl IntoIterator<Item = (u8, &'a [u8])>) -> Self {
        let mut reported = Self::default();
        for (instance, octets) in block_types {
            reported.set(instance, |channel| channel.principle = principle(octets));
        }
        reported
    }

    /// The `parts` of a simulated device, of which it reports what its tables leave open.
    #[must_use]
    pub fn of_parts(model: &Model, parts: impl IntoIterator<Item = (Part, MeasuringRange)>) -> Self {
        let mut reported = Self::default();
        let (open, unranged) = (open_instances(model), unranged_instances(model));
        for (part, range) in parts {
            if open.contains(&part.instance) {
                reported.set(part.instance, |channel| channel.principle = Some(part.principle));
            }
            if unranged.contains(&part.instance) {
                reported = reported.with_range(part.instance, range);
            }
        }
        reported
    }

    /// The same with the range of a channel.
    #[must_use]
    pub fn with_range(mut self, instance: u8, range: MeasuringRange) -> Self {
        self.set(instance, |channel| channel.range = Some(range));
        self
    }

    fn set(&mut self, instance: u8, change: impl FnOnce(&mut ReportedChannel)) {
        let at = self.0.iter().position(|channel| channel.instance == instance);
        let at = at.or_else(|| self.0.iter().position(|channel| channel.instance == 0));
        if let Some(channel) = at.and_then(|at| self.0.get_mut(at)) {
            channel.instance = instance;
            change(channel);
        }
    }

    fn get(&self, instance: u8) -> Option<&ReportedChannel> {
        self.0.iter().find(|channel| channel.instance == instance && instance > 0)
    }

    /// The principle of an instance or channel.
    pub(super) fn principle(&self, model: &Model, instance: u8) -> Option<Principle> {
        in_tables(model, instance).or_else(|| self.get(instance)?.principle)
    }

    /// The range of an instance or channel. A manual that leaves open which gauge is connected has no ranges of the gauges either
    /// (errata-pxg55x-img400 133), so only what the device reports counts there.
    pub(super) fn range(&self, model: &Model, instance: u8) -> Option<MeasuringRange> {
        if unranged_instances(model).contains(&instance) {
            return self.get(instance)?.range;
        }
        let spec = model.parts.iter().find(|spec| spec.part.instance == instance)?;
        Some(MeasuringRange { lowest_pa: spec.limits.under_pa, highest_pa: spec.limits.over_pa })
    }
}

/// The range of a gauge whose telegram does not name the active instance: from the lowest to the highest end of its parts. The sensor of
/// the atmosphere never delivers the process value.
pub(crate) fn whole_range(model: &Model) -> Option<MeasuringRange> {
    let parts = model.parts.iter().filter(|spec| spec.part.principle != Principle::Atmosphere);
    let ranges = parts.map(|spec| MeasuringRange { lowest_pa: spec.limits.under_pa, highest_pa: spec.limits.over_pa });
    ranges.reduce(|one, other| MeasuringRange {
        lowest_pa: one.lowest_pa.min(other.lowest_pa),
        highest_pa: one.highest_pa.max(other.highest_pa),
    })
}

/// The instances and channels of a model to which different gauges may be connected, so that their range is not in the tables.
///
/// ```
/// use profivac_client::cyclic::unranged_instances;
/// use profivac_devices::catalog::model_named;
///
/// assert_eq!(unranged_instances(model_named("img400").ok_or("no such model")?), [1, 2, 3, 4]);
/// assert!(unranged_instances(model_named("bcg450").ok_or("no such model")?).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn unranged_instances(model: &Model) -> Vec<u8> {
    let count = |instance| model.parts.iter().filter(|spec| spec.part.instance == instance).count();
    let mut instances: Vec<u8> = model.parts.iter().map(|spec| spec.part.instance).collect();
    instances.dedup();
    instances.retain(|instance| count(*instance) > 1);
    instances
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
        let none = ReportedChannels::default();
        let of = |model, instance| none.principle(model, instance);
        assert_eq!(of(&bcg450::table::MODEL, 1), Some(Principle::Pirani));
        assert_eq!(of(&img400::table::MODEL, 2), Some(Principle::HotCathode), "Bayard-Alpert or extractor");
        assert_eq!(of(&img400::table::MODEL, 3), None, "Pirani or diaphragm");
        assert!((1..=4).all(|channel| of(&tpg::table::TPG300, channel).is_none()));
    }

    #[test]
    fn the_block_type_determines_the_other_principles() {
        let known = ReportedChannels::from_block_types([(3, &[0, 14, 0, 0][..])]);
        assert_eq!(known.principle(&img400::table::MODEL, 3), Some(Principle::Diaphragm));
        assert_eq!(known.principle(&img400::table::MODEL, 4), None);
        assert_eq!((principle(&[0, 99, 0, 0]), principle(&[13])), (None, None));
    }
    /// The ranges in the tables of a controller are those of the virtual device.
    #[test]
    fn a_channel_has_the_range_that_the_device_reports_and_no_other() {
        let img400 = &img400::table::MODEL;
        assert_eq!(unranged_instances(img400), [1, 2, 3, 4]);
        assert!(unranged_instances(&bcg450::table::MODEL).is_empty());
        let range = MeasuringRange { lowest_pa: 1e-2, highest_pa: 133.0 };
        let known = ReportedChannels::default().with_range(4, range);
        assert_eq!((known.range(img400, 4), known.range(img400, 3)), (Some(range), None));
        let pirani = known.range(&bcg450::table::MODEL, 1).unwrap();
        assert!((pirani.lowest_pa / 0.55 - 1.0).abs() < 1e-9);
    }
}
