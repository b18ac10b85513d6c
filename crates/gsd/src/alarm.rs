//! Alarms of DP-V1 and their keywords.

use profivac_wire::prm::Dpv1Status2;
use std::collections::BTreeSet;
use std::fmt;

/// A kind of alarm, profibus-wire 2.3.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Alarm {
    /// Diagnostic_Alarm.
    Diagnostic,
    /// Process_Alarm.
    Process,
    /// Pull_Plug_Alarm: a module was pulled or plugged.
    PullPlug,
    /// Status_Alarm.
    Status,
    /// Update_Alarm.
    Update,
    /// Manufacturer_Specific_Alarm.
    Manufacturer,
}

/// The alarms of a module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Alarms {
    /// The module sends them.
    pub supported: BTreeSet<Alarm>,
    /// The master must enable them if the module is plugged.
    pub required: BTreeSet<Alarm>,
}

impl Alarm {
    /// Every kind.
    pub const ALL: [Alarm; 6] =
        [Alarm::Diagnostic, Alarm::Process, Alarm::PullPlug, Alarm::Status, Alarm::Update, Alarm::Manufacturer];

    /// The keyword without its end `_supp` or `_required`.
    #[must_use]
    pub fn keyword(self) -> &'static str {
        match self {
            Alarm::Diagnostic => "Diagnostic_Alarm",
            Alarm::Process => "Process_Alarm",
            Alarm::PullPlug => "Pull_Plug_Alarm",
            Alarm::Status => "Status_Alarm",
            Alarm::Update => "Update_Alarm",
            Alarm::Manufacturer => "Manufacturer_Specific_Alarm",
        }
    }

    /// Its bit in the second DP-V1 status octet of the user parameters, profibus-wire 2.4.
    #[must_use]
    pub fn enable_bit(self) -> Dpv1Status2 {
        match self {
            Alarm::Diagnostic => Dpv1Status2::DIAGNOSTIC_ALARM,
            Alarm::Process => Dpv1Status2::PROCESS_ALARM,
            Alarm::PullPlug => Dpv1Status2::PULL_PLUG_ALARM,
            Alarm::Status => Dpv1Status2::STATUS_ALARM,
            Alarm::Update => Dpv1Status2::UPDATE_ALARM,
            Alarm::Manufacturer => Dpv1Status2::MANUFACTURER_ALARM,
        }
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Alarm::Diagnostic => "diagnostic alarms",
            Alarm::Process => "process alarms",
            Alarm::PullPlug => "pull and plug alarms",
            Alarm::Status => "status alarms",
            Alarm::Update => "update alarms",
            Alarm::Manufacturer => "alarms of the vendor",
        })
    }
}

impl Alarms {
    /// The set that belongs to a keyword in small letters, and its alarm.
    pub(crate) fn of_keyword(&mut self, keyword: &str) -> Option<(&mut BTreeSet<Alarm>, Alarm)> {
        let (name, set) = match (keyword.strip_suffix("_supp"), keyword.strip_suffix("_required")) {
            (Some(name), _) => (name, &mut self.supported),
            (None, Some(name)) => (name, &mut self.required),
            (None, None) => return None,
        };
        let alarm = Alarm::ALL.into_iter().find(|alarm| alarm.keyword().eq_ignore_ascii_case(name))?;
        Some((set, alarm))
    }
}
