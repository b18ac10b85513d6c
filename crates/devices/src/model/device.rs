//! A device in one static value.

use super::{AccessError, Configuration, PartSpec, PlacedBlock, Unit};
use profivac_dp::slave::Features;

/// Everything about a device that does not change.
#[derive(Debug)]
pub struct Model {
    /// The name in profivac: `bcg450`.
    pub name: &'static str,
    /// The name on the device.
    pub title: &'static str,
    /// Who makes it.
    pub vendor: &'static str,
    /// The manual the tables follow.
    pub manual: &'static str,
    /// Ident_Number.
    pub ident: u16,
    /// What the protocol side can do.
    pub features: Features,
    /// The configurations, in the manual's order.
    pub configurations: &'static [Configuration],
    /// The one Get_Cfg tells before the first Chk_Cfg.
    pub default_configuration: &'static Configuration,
    /// The pressure units, in the manual's order.
    pub units: &'static [Unit],
    /// The user parameter strings it accepts.
    pub user_prm: &'static [UserPrm],
    /// The bits of the first user parameter octet a master may add to a printed string.
    pub dpv1_status: u8,
    /// The blocks and their slots.
    pub blocks: &'static [PlacedBlock],
    /// The instances that measure, with their ranges.
    pub parts: &'static [&'static PartSpec],
    /// How it speaks in the parameter channel.
    pub channel_rules: &'static ChannelRules,
    /// The faults it can have.
    pub faults: &'static FaultList,
    /// The errata that concern its manual: the list, and the numbers of its entries.
    pub errata: &'static str,
    /// What only its GSD file tells.
    pub gsd: Gsd,
}

impl Model {
    /// The user parameter string that `user` is.
    #[must_use]
    pub fn user_prm(&self, user: &[u8]) -> Option<&'static UserPrm> {
        self.user_prm.iter().find(|prm| prm.is(user, self.dpv1_status))
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

    /// The unit with this name, in any case of letters.
    #[must_use]
    pub fn unit_named(&self, name: &str) -> Option<&'static Unit> {
        self.units.iter().find(|unit| unit.name.eq_ignore_ascii_case(name) || unit.alias.eq_ignore_ascii_case(name))
    }
}

/// A user parameter string of a table.
#[derive(Debug, PartialEq, Eq)]
pub struct UserPrm {
    /// What it selects, as printed.
    pub name: &'static str,
    /// The octets.
    pub octets: &'static [u8],
}

impl UserPrm {
    /// Whether `user` is this string, apart from the `free` bits of the first octet: errata-bpg-bcg-tpg 4.
    fn is(&self, user: &[u8], free: u8) -> bool {
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

/// How a device speaks in the parameter channel.
#[derive(Debug, PartialEq, Eq)]
pub struct ChannelRules {
    /// The instructions, by their signature AK. 0 means none.
    pub tasks: &'static [(u8, TaskKind)],
    /// A new instruction is started only after AK 0: errata-bpg-bcg-tpg 25 (yes) and 153 (no).
    pub needs_idle_between: bool,
    /// Codes that differ from [`Refusal::channel_code`].
    pub error_codes: &'static [(AccessError, u8)],
}

/// An instruction of the parameter channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskKind {
    /// Read a parameter.
    Read,
    /// Write a parameter of one of these lengths.
    Write(&'static [usize]),
}

impl ChannelRules {
    /// The instruction with this signature.
    #[must_use]
    pub fn task(&self, ak: u8) -> Option<TaskKind> {
        self.tasks.iter().find(|(signature, _)| *signature == ak).map(|(_, instruction)| *instruction)
    }

    /// The error code of a refusal.
    #[must_use]
    pub fn error_code(&self, refusal: AccessError) -> u8 {
        let own = self.error_codes.iter().find(|(other, _)| *other == refusal).map(|(_, code)| *code);
        own.unwrap_or(refusal.channel_code())
    }
}

/// Facts that stand in no other table.
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

/// The faults of a device, made by `faults!`.
#[derive(Debug, PartialEq, Eq)]
pub struct FaultList {
    /// The names.
    pub names: &'static [&'static str],
    /// What each does, in the same order.
    pub effects: &'static [&'static str],
}

/// The faults of a device: field, name for people, what it does.
macro_rules! faults {
    ($(#[$doc:meta])* pub $faults:ident; $($fault:ident $name:literal $effect:literal;)+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $faults {
            $(#[doc = $effect] pub $fault: bool,)+
        }

        impl $faults {
            /// All is well.
            pub const NONE: Self = Self { $($fault: false),+ };

            /// Their names and effects.
            pub const LIST: $crate::model::FaultList =
                $crate::model::FaultList { names: &[$($name),+], effects: &[$($effect),+] };

            /// The fault with this name.
            pub fn named(&mut self, name: &str) -> Option<&mut bool> {
                match name {
                    $($name => Some(&mut self.$fault),)+
                    _ => None,
                }
            }
        }
    };
}

pub(crate) use faults;
