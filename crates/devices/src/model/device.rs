//! The tables of a device in one static value.

use super::access_error::AccessError;
use super::block::{Location, PlacedBlock, Row};
use super::cyclic::Configuration;
use super::fault::FaultList;
use super::part_spec::PartSpec;
use super::pressure::Unit;
use super::typed::TypedParameter;
use profivac_dp::slave::Features;

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
    /// The pressure units, in the manual's order.
    pub units: &'static [Unit],
    /// The user parameter strings that the device accepts.
    pub user_prm: &'static [UserPrm],
    /// The bits of the first user parameter octet that a master may add to a printed string.
    pub dpv1_status: u8,
    /// The blocks and their locations.
    pub blocks: &'static [PlacedBlock],
    /// The measuring parts that have a range in the tables.
    pub parts: &'static [&'static PartSpec],
    /// The rules of its parameter channel.
    pub channel_rules: &'static ChannelRules,
    /// The faults that the device can have.
    pub faults: &'static FaultList,
    /// The errata that concern its manual: the list, and the numbers of its entries.
    pub errata: &'static str,
    /// The properties that only its GSD file has.
    pub gsd: Gsd,
}

impl Model {
    /// The user parameter string with these octets.
    #[must_use]
    pub fn user_prm(&self, user: &[u8]) -> Option<&'static UserPrm> {
        self.user_prm.iter().find(|prm| prm.matches(user, self.dpv1_status))
    }

    /// The configuration with exactly these octets.
    #[must_use]
    pub fn configuration(&self, octets: &[u8]) -> Option<&'static Configuration> {
        self.configurations.iter().find(|configuration| configuration.octets == octets)
    }

    /// The unit with this code.
    #[must_use]
    pub fn unit(&self, code: u16) -> Option<&'static Unit> {
        self.units.iter().find(|unit| unit.code == code)
    }

    /// The row of this model that `P` names at `location`; `None` if the model has no such parameter there.
    ///
    /// A row of a sister gauge is found as well if index, name, data type and codes are the same.
    #[must_use]
    pub fn typed_row<P: TypedParameter>(&self, location: &Location) -> Option<&'static Row> {
        let blocks = self.blocks.iter().filter(|placed| placed.locations.iter().any(|own| own.is_at(location)));
        blocks.filter_map(|placed| placed.block.row(P::ROW.index)).find(|row| row.is_like(P::ROW))
    }

    /// The unit with this name, in any case of letters.
    #[must_use]
    pub fn unit_named(&self, name: &str) -> Option<&'static Unit> {
        self.units.iter().find(|unit| unit.name.eq_ignore_ascii_case(name) || unit.alias.eq_ignore_ascii_case(name))
    }
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
    /// Whether `user` is this string, apart from the `free` bits of the first octet: errata-bpg-bcg-tpg 4.
    fn matches(&self, user: &[u8], free: u8) -> bool {
        match (self.octets, user) {
            ([first, rest @ ..], [user_first, user_rest @ ..]) => *first == user_first & !free && rest == user_rest,
            (octets, user) => octets == user,
        }
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
