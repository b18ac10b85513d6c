//! The tables of a device in one static value.

use super::access_error::AccessError;
use super::alarm_words::AlarmWords;
#[cfg(feature = "texts")]
use super::block::Row;
use super::block::{Location, PlacedBlock};
use super::cyclic::{Configuration, CyclicValue};
use super::fault::FaultList;
use super::part_spec::{MeasuringRange, PartSpec, Principle};
use super::pressure::{Counts, Unit};
use super::role::Role;
#[cfg(feature = "texts")]
use super::typed::TypedParameter;
use profivac_dp::slave::Features;
use profivac_wire::prm::{Dpv1Status1, Dpv1Status2};

/// Whether tables may come from a device file. A microcontroller has its own alone, which the compiler then knows.
pub(crate) const DESCRIBED: bool = cfg!(feature = "texts");

/// The end of a name on a device with PROFIBUS and switching outputs; the name in profivac does not have it.
const SUFFIX: &str = "-SP";

/// The octets of DPV1_Status_1 to 3, at the front of the user parameters.
const DPV1_STATUS_OCTETS: usize = 3;

/// These octets alone. They activate nothing.
const DPV1_STATUS: UserPrm = UserPrm { name: "", octets: &[0; DPV1_STATUS_OCTETS] };

/// The characters of a name that count: small letters, no separators.
fn letters(name: &str) -> impl Iterator<Item = char> {
    name.chars().filter(|letter| !matches!(letter, ' ' | '-' | '_')).map(|letter| letter.to_ascii_lowercase())
}

/// The properties of a device that do not change.
#[derive(Debug)]
pub struct Model {
    /// The name in profivac: `bcg450`.
    pub name: &'static str,
    /// The name on the device.
    pub title: &'static str,
    /// The manufacturer.
    pub vendor: &'static str,
    /// The manual of the tables.
    pub manual: &'static str,
    /// Ident_Number.
    pub ident: u16,
    /// The services of the slave.
    pub features: Features,
    /// The configurations, in the manual's order.
    pub configurations: &'static [Configuration],
    /// The answer to Get_Cfg before the first Chk_Cfg.
    pub default_configuration: &'static Configuration,
    /// The values of the cyclic data that are no pressures.
    pub values: &'static [CyclicValue],
    /// The pressure units, in the manual's order.
    pub units: &'static [Unit],
    /// The highest integer of its pressures.
    pub max_integer: u16,
    /// The user parameter strings that the device accepts.
    pub user_prm: &'static [UserPrm],
    /// The bits of the first user parameter octet that the device has by its manual, besides those of a printed string. Its GSD file
    /// announces them; [`free_bits`](Self::free_bits) are all that a master may add.
    pub dpv1_status: u8,
    /// The blocks and their locations.
    pub blocks: &'static [PlacedBlock],
    /// The measuring parts that have a range in the tables.
    pub parts: &'static [&'static PartSpec],
    /// The rules of its parameter channel.
    pub channel_rules: &'static ChannelRules,
    /// The words of its alarms.
    pub alarms: AlarmWords,
    /// The faults that the device can have.
    pub faults: &'static FaultList,
    /// The errata that concern its manual: the list, and the numbers of its entries.
    pub errata: &'static str,
    /// The properties that only its GSD file has.
    pub gsd: Gsd,
}

impl PartialEq for Model {
    /// Whether both are the tables of one device: a program has them once.
    fn eq(&self, other: &Self) -> bool {
        core::ptr::eq(self, other)
    }
}

impl Eq for Model {}

impl Model {
    /// Whether `name` is the name of this model in any case, or the name on the device: `bcg450`, `BCG450`, `BCG450-SP`, `IMG 400`.
    #[must_use]
    pub fn is_called(&self, name: &str) -> bool {
        let end = name.len().saturating_sub(SUFFIX.len());
        let plain = match (name.get(..end), name.get(end..)) {
            (Some(plain), Some(suffix)) if letters(suffix).eq(letters(SUFFIX)) => plain,
            _ => name,
        };
        letters(plain).eq(letters(self.name))
    }

    /// The part of this device at the instance of `part`; `part` itself where the tables have no range for it.
    #[must_use]
    pub fn part_like(&self, part: &'static PartSpec) -> &'static PartSpec {
        if !DESCRIBED {
            return part;
        }
        self.parts.iter().find(|spec| spec.part == part.part).copied().unwrap_or(part)
    }

    /// The number of this instance among those of a block, counted from the lowest: the first relay has the lowest set point.
    pub(crate) fn number_in_block(&self, block: usize, instance: u8) -> Option<usize> {
        let locations = self.blocks.get(block)?.locations;
        let lower = locations.iter().filter(|location| location.instance < instance).count();
        locations.iter().any(|location| location.instance == instance).then_some(lower)
    }

    /// Whether a slot has this instance.
    pub(crate) fn has_instance(&self, slot: u8, instance: u8) -> bool {
        let mut locations = self.blocks.iter().flat_map(|placed| placed.locations);
        instance > 0 && locations.any(|location| (location.slot, location.instance) == (slot, instance))
    }

    /// The user parameter string with these octets.
    #[must_use]
    pub fn user_prm(&self, user: &[u8]) -> Option<&'static UserPrm> {
        // Two octets are too short for DPV1_Status_1 to 3: they can be the code of the unit.
        let free = if user.len() < DPV1_STATUS_OCTETS { [self.dpv1_status, 0] } else { self.free_bits() };
        let given = self.user_prm.iter().find(|prm| prm.matches(user, free));
        // A master sends these octets to each DP-V1 slave, also where its GSD file has none: the built-in devices have some.
        let is_status = DESCRIBED && self.features.dpv1 && DPV1_STATUS.matches(user, free);
        given.or_else(|| self.user_prm.iter().find(|prm| is_status && prm.octets.is_empty()))
    }

    /// The bits that a master may add to the first two octets of a printed string: those of `dpv1_status`. chosen: a DP-V1 device takes
    /// Fail_Safe and Check_Cfg_Mode too, because the manuals do not forbid them and a master may set them for each DP-V1 slave.
    /// errata-bpg-bcg-tpg 4, errata-pxg55x-img400 39.
    #[must_use]
    pub const fn free_bits(&self) -> [u8; 2] {
        if self.features.dpv1 {
            [self.dpv1_status | Dpv1Status1::FAIL_SAFE.bits(), Dpv1Status2::CHECK_CFG_MODE.bits()]
        } else {
            [self.dpv1_status, 0]
        }
    }

    /// The configuration with exactly these octets.
    #[must_use]
    pub fn configuration(&self, octets: &[u8]) -> Option<&'static Configuration> {
        self.configurations.iter().find(|configuration| configuration.octets == octets)
    }

    /// Whether this configuration fits the user parameters: a device with TTR compatibility mode enters it with the string without a
    /// unit, and exchanges its telegram only then. errata-pxg55x-img400 49.
    #[must_use]
    pub fn fits(&self, prm: &UserPrm, configuration: &Configuration) -> bool {
        !self.configurations.iter().any(Configuration::is_ttr)
            || configuration.is_ttr() == self.unit(prm.unit_code()).is_none()
    }

    /// The values of the inputs or outputs of a configuration that are no pressures.
    pub fn values_of(
        &self,
        configuration: &Configuration,
        is_output: bool,
    ) -> impl Iterator<Item = &'static CyclicValue> {
        let telegram = if is_output { configuration.outputs } else { configuration.inputs };
        let number = telegram.map(|telegram| telegram.number);
        self.values.iter().filter(move |value| value.is_output == is_output && Some(value.telegram) == number)
    }

    /// The unit with this code.
    #[must_use]
    pub fn unit(&self, code: u16) -> Option<&'static Unit> {
        self.units.iter().find(|unit| unit.code == code)
    }

    /// The row of this model that `P` names at `location`; `None` if the model has no such parameter there.
    ///
    /// A row of another device is found as well if index, name, data type and codes are the same.
    #[cfg(feature = "texts")]
    #[must_use]
    pub fn typed_row<P: TypedParameter>(&self, location: &Location) -> Option<&'static Row> {
        let blocks = self.blocks.iter().filter(|placed| placed.locations.iter().any(|own| own.is_at(location)));
        blocks.filter_map(|placed| placed.block.row(P::ROW.index)).find(|row| row.is_like(P::ROW))
    }

    /// The parts that measure the pressure of this location: one for an instance, every gauge that a channel accepts for a
    /// channel, none for a relay.
    pub fn parts_at(&self, location: &Location) -> impl Iterator<Item = &'static PartSpec> + '_ {
        let has_value = self.has_process_value(location);
        let instance = if location.instance > 0 { location.instance } else { location.slot };
        self.parts.iter().copied().filter(move |spec| has_value && spec.part.instance == instance)
    }

    /// The parts that measure the chamber, not the ambient air.
    fn chamber_parts(&self) -> impl Iterator<Item = &'static PartSpec> + '_ {
        self.parts.iter().copied().filter(|spec| spec.part.principle != Principle::Atmosphere)
    }

    fn has_process_value(&self, location: &Location) -> bool {
        let placed = self.blocks.iter().filter(|placed| placed.locations.iter().any(|own| own.is_at(location)));
        placed.flat_map(|placed| placed.block.rows).any(|row| row.role == Some(Role::ProcessValue))
    }

    /// The COUNTS of the pressures of this location; `None` if the tables do not say.
    #[must_use]
    pub fn counts_at(&self, location: &Location) -> Option<Counts> {
        common_counts(self.parts_at(location)).or_else(|| common_counts(self.chamber_parts()))
    }

    /// The pressures that the device can measure, as far as a pressure of this location depends on it: the whole range of a gauge
    /// with several instances, that of the ambient pressure sensor for its own parameters. `None` if the tables have no ranges, or
    /// those of different gauges that may be connected.
    #[must_use]
    pub fn measuring_range_at(&self, location: &Location) -> Option<MeasuringRange> {
        let count = |instance| self.parts.iter().filter(|spec| spec.part.instance == instance).count();
        if self.parts.iter().any(|spec| count(spec.part.instance) > 1) {
            return None;
        }
        let own = || self.parts_at(location);
        let is_ambient = own().any(|spec| spec.part.principle == Principle::Atmosphere);
        if is_ambient || (location.instance == 0 && own().next().is_some()) {
            whole_range(own())
        } else {
            whole_range(self.chamber_parts())
        }
    }

    /// The unit with this name, in any case of letters.
    #[must_use]
    pub fn unit_named(&self, name: &str) -> Option<&'static Unit> {
        self.units.iter().find(|unit| unit.name.eq_ignore_ascii_case(name) || unit.alias.eq_ignore_ascii_case(name))
    }
}

/// The COUNTS of these parts, if all have the same.
fn common_counts(mut parts: impl Iterator<Item = &'static PartSpec>) -> Option<Counts> {
    let counts = parts.next()?.counts;
    parts.all(|spec| spec.counts == counts).then_some(counts)
}

/// From the lowest to the highest pressure of all these parts.
fn whole_range(parts: impl Iterator<Item = &'static PartSpec>) -> Option<MeasuringRange> {
    let ranges = parts.map(|spec| MeasuringRange {
        lowest_pa: spec.limits.under_pa,
        highest_pa: spec.limits.over_pa.max(spec.limits.full_scale_pa),
    });
    ranges.reduce(|a, b| MeasuringRange {
        lowest_pa: a.lowest_pa.min(b.lowest_pa),
        highest_pa: a.highest_pa.max(b.highest_pa),
    })
}

/// A user parameter string.
#[derive(Debug, PartialEq, Eq)]
pub struct UserPrm {
    /// The name of its choice, as printed.
    pub name: &'static str,
    /// The octets.
    pub octets: &'static [u8],
}

impl UserPrm {
    /// Whether `user` is this string, apart from the `free` bits that its first octets may have besides their own.
    fn matches(&self, user: &[u8], free: [u8; 2]) -> bool {
        let mut free = free.into_iter();
        let mut pairs = self.octets.iter().zip(user);
        self.octets.len() == user.len() && pairs.all(|(own, user)| *own == *user & !(free.next().unwrap_or(0) & !*own))
    }

    /// The last two octets: the code of the unit.
    #[must_use]
    pub const fn unit_code(&self) -> u16 {
        match self.octets {
            [.., high, low] => u16::from_be_bytes([*high, *low]),
            _ => 0,
        }
    }
}

/// The rules of the parameter channel of a device.
#[derive(Debug, PartialEq, Eq)]
pub struct ChannelRules {
    /// The tasks, by their AK. AK 0 means no task.
    pub tasks: &'static [(u8, TaskKind)],
    /// The device starts a new task only after AK 0: errata-bpg-bcg-tpg 25 (yes) and 153 (no).
    pub needs_idle_between: bool,
    /// Error codes that differ from [`AccessError::channel_code`].
    pub error_codes: &'static [(AccessError, u8)],
}

/// A kind of task of the parameter channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskKind {
    /// Read a parameter.
    Read,
    /// Write a parameter of one of these lengths.
    Write(&'static [usize]),
}

impl ChannelRules {
    /// The task with this AK.
    #[must_use]
    pub fn task(&self, ak: u8) -> Option<TaskKind> {
        self.tasks.iter().find(|(own, _)| *own == ak).map(|(_, task)| *task)
    }

    /// The code of an error.
    #[must_use]
    pub fn error_code(&self, error: AccessError) -> u8 {
        let own = self.error_codes.iter().find(|(other, _)| *other == error).map(|(_, code)| *code);
        own.unwrap_or(error.channel_code())
    }
}

/// Properties that only the GSD file has.
#[derive(Debug, PartialEq, Eq)]
pub struct Gsd {
    /// Revision of the file.
    pub revision: u8,
    /// Hardware release, as parameter Hardware Revision Level.
    pub hardware: &'static str,
    /// Software release.
    pub software: &'static str,
    /// Octets of the longest diagnosis.
    pub max_diag_octets: u8,
    /// Set_Slave_Add is supported.
    pub set_slave_add: bool,
}

#[cfg(test)]
mod tests {
    use super::UserPrm;
    use crate::catalog::model_named;
    use crate::model::{Counts, Location};

    fn range(device: &str, slot: u8, instance: u8) -> Option<(f64, f64)> {
        let location = Location { slot, instance, name: "" };
        let range = model_named(device).unwrap().measuring_range_at(&location)?;
        Some((range.lowest_pa / 100.0, range.highest_pa / 100.0))
    }

    /// A string of a device file can have DPV1_Enable, Fail_Safe or Check_Cfg_Mode itself.
    #[test]
    fn a_master_may_add_free_bits_to_a_string_and_leaves_the_bits_that_it_has() {
        let matches = |own: &'static [u8], user: &[u8]| UserPrm { name: "", octets: own }.matches(user, [0x40, 0x01]);
        assert!(matches(&[0x80, 0, 0], &[0x80, 0, 0]) && matches(&[0x80, 0, 0], &[0xC0, 1, 0]));
        assert!(matches(&[0xC0, 1, 0], &[0xC0, 1, 0]));
        assert!(!matches(&[0xC0, 1, 0], &[0x80, 1, 0]) && !matches(&[0xC0, 1, 0], &[0xC0, 0, 0]));
        assert!(!matches(&[0x80, 0, 0], &[0x84, 0, 0]) && !matches(&[0x80, 0, 0], &[0x80, 0, 1]));
        assert!(!matches(&[0x80, 0, 0], &[0x80, 0]));
    }

    #[test]
    fn a_combined_gauge_has_one_range_of_all_its_parts_and_a_controller_none() {
        let close = |found: Option<(f64, f64)>, (low, high): (f64, f64)| {
            let (found_low, found_high) = found.unwrap();
            assert!((found_low / low - 1.0).abs() < 1e-9 && (found_high / high - 1.0).abs() < 1e-9, "{found_low}");
        };
        close(range("bcg450", 1, 1), (5e-10, 1500.0));
        close(range("bcg450", 1, 2), (5e-10, 1500.0));
        // Different gauges may be connected; a relay may watch any channel.
        assert_eq!([1, 3, 5].map(|slot| range("img400", slot, 0)), [None; 3]);
        // The ambient pressure sensor.
        let (_, highest) = range("pcg550", 1, 3).unwrap();
        assert!(highest < 1500.0, "{highest}");
        assert_eq!(range("tpg300", 1, 0), None);
    }

    /// A trip point in slot 3 has nothing to do with instance 3, the ambient pressure sensor.
    #[test]
    fn the_counts_of_a_trip_point_are_those_of_the_chamber() {
        let counts =
            |device, slot, instance| model_named(device).unwrap().counts_at(&Location { slot, instance, name: "" });
        assert!(matches!(counts("pcg550", 3, 0), Some(Counts::Log { .. })));
        assert!(matches!(counts("pcg550", 1, 3), Some(Counts::Linear { .. })));
        assert!(matches!(counts("img400", 11, 0), Some(Counts::Log { .. })));
        assert_eq!(counts("tpg500", 5, 0), None);
    }
}
