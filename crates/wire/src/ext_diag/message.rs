//! Alarms and status messages: device-related blocks of a DP-V1 device. profibus-wire 2.3.2.

use crate::octets::{Reader, TooLong, TooShort, Writer};
use core::fmt::{self, Display, Formatter};

/// The content of a device-related block of a DP-V1 device: an alarm, which the master acknowledges, or a status.
///
/// ```
/// use profivac_wire::ext_diag::Message;
///
/// let message = Message::parse(&[0x02, 3, 0x09, 0x50])?;
/// assert_eq!(message.to_string(), "process alarm of slot 3, sequence number 1, appears: 50");
/// # Ok::<(), profivac_wire::TooShort>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Message<'a> {
    /// Alarm or status, with its type.
    pub kind: MessageKind,
    /// Slot_Number.
    pub slot: u8,
    /// Sequence number and change.
    pub specifier: Specifier,
    /// Diagnosis_User_Data, at most 59 octets.
    pub data: &'a [u8],
}

impl<'a> Message<'a> {
    /// Reads the content of a device-related block.
    ///
    /// # Errors
    /// [`TooShort`] if type, slot and specifier are incomplete.
    pub fn parse(content: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(content);
        Ok(Self {
            kind: MessageKind::from_octet(reader.octet()?),
            slot: reader.octet()?,
            specifier: Specifier(reader.octet()?),
            data: reader.rest(),
        })
    }

    /// Writes the content of a device-related block to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octets(&[self.kind.to_octet(), self.slot, self.specifier.0])?;
        writer.octets(self.data)?;
        Ok(writer.written())
    }
}

/// Alarm_Type or Status_Type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MessageKind {
    /// Alarm_Type, 0 to 127.
    Alarm(u8),
    /// Status_Type, 0 to 127.
    Status(u8),
}

impl MessageKind {
    /// Module_Status: two bits of [`ModuleState`] per module.
    pub const MODULE_STATUS: Self = Self::Status(2);

    /// Whether the standard gives the type neither a meaning nor to the manufacturer.
    #[must_use]
    pub const fn is_reserved(self) -> bool {
        matches!(self, Self::Alarm(0 | 7..=31 | 127..) | Self::Status(0 | 4..=29 | 127..))
    }

    pub(super) const fn from_octet(octet: u8) -> Self {
        if octet & 0x80 == 0 { Self::Alarm(octet) } else { Self::Status(octet & 0x7F) }
    }

    const fn to_octet(self) -> u8 {
        match self {
            Self::Alarm(kind) => kind & 0x7F,
            Self::Status(kind) => kind | 0x80,
        }
    }
}

/// The name of the type in English. A type without a name, reserved or of the manufacturer, keeps its number.
impl Display for MessageKind {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Alarm(1) => "diagnostic alarm",
            Self::Alarm(2) => "process alarm",
            Self::Alarm(3) => "pull alarm",
            Self::Alarm(4) => "plug alarm",
            Self::Alarm(5) => "status alarm",
            Self::Alarm(6) => "update alarm",
            Self::Alarm(kind @ 32..=126) => return write!(f, "manufacturer specific alarm {kind}"),
            Self::Alarm(kind) => return write!(f, "reserved alarm {kind}"),
            Self::Status(1) => "status message",
            Self::Status(2) => "module status",
            Self::Status(3) => "DXB link status",
            Self::Status(30) => "PrmCmdAck",
            Self::Status(31) => "Red_State",
            Self::Status(kind @ 32..=126) => return write!(f, "manufacturer specific status {kind}"),
            Self::Status(kind) => return write!(f, "reserved status {kind}"),
        })
    }
}

/// The specifier of an alarm or a status.
///
/// ```
/// use profivac_wire::ext_diag::{Specifier, SpecifierChange};
///
/// let specifier = Specifier(0x0D);
/// assert_eq!((specifier.seq_nr(), specifier.add_ack()), (1, true));
/// assert_eq!(specifier.change(), SpecifierChange::Appears);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Specifier(pub u8);

impl Specifier {
    /// The specifier of an alarm: its Seq_Nr, of which the lowest five bits count, and the change. Add_Ack is not set.
    ///
    /// ```
    /// use profivac_wire::ext_diag::{Specifier, SpecifierChange};
    ///
    /// assert_eq!(Specifier::new(2, SpecifierChange::None), Specifier(0x10));
    /// ```
    #[must_use]
    pub const fn new(seq_nr: u8, change: SpecifierChange) -> Self {
        let change = match change {
            SpecifierChange::None => 0,
            SpecifierChange::Appears => 1,
            SpecifierChange::Disappears => 2,
            SpecifierChange::DisappearsOthersRemain => 3,
        };
        Self(seq_nr << 3 | change)
    }

    /// Seq_Nr of an alarm, 0 to 31.
    #[must_use]
    pub const fn seq_nr(self) -> u8 {
        self.0 >> 3
    }

    /// Add_Ack: the application needs an acknowledgement in addition to Alarm_Ack.
    #[must_use]
    pub const fn add_ack(self) -> bool {
        self.0 & 4 != 0
    }

    /// The change of the cause.
    #[must_use]
    pub const fn change(self) -> SpecifierChange {
        match self.0 & 3 {
            0 => SpecifierChange::None,
            1 => SpecifierChange::Appears,
            2 => SpecifierChange::Disappears,
            _ => SpecifierChange::DisappearsOthersRemain,
        }
    }
}

/// The change of the cause of an alarm or a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpecifierChange {
    /// No information.
    None,
    /// The cause appeared; the slot has an error.
    Appears,
    /// The cause disappeared; the slot has no error.
    Disappears,
    /// The cause disappeared, other causes remain. Alarms only.
    DisappearsOthersRemain,
}

/// The state of a module: two bits of Module_Status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ModuleState {
    /// Valid data.
    Valid,
    /// Invalid data: the module is faulty.
    Invalid,
    /// Wrong module: it differs from the configuration.
    Wrong,
    /// No module.
    Missing,
}

/// The states in Module_Status, the first in bits 1 and 0 of the first octet. The last octet may hold more states than the
/// device has modules.
pub fn module_states(data: &[u8]) -> impl Iterator<Item = ModuleState> {
    let pairs = data.iter().flat_map(|octet| [0, 2, 4, 6].map(|shift| octet >> shift & 3));
    pairs.map(|pair| match pair {
        0 => ModuleState::Valid,
        1 => ModuleState::Invalid,
        2 => ModuleState::Wrong,
        _ => ModuleState::Missing,
    })
}
