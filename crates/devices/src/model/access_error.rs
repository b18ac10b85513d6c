//! The reasons for which a device does not carry out an access to a parameter, and the codes on the wire.

use profivac_wire::acyclic::ErrorCode;

/// An access that a device does not carry out. The order is the order of the checks: errata-bpg-bcg-tpg 23,
/// errata-pxg55x-img400 5.
///
/// On the wire it becomes a refusal: an error code in the parameter channel, a negative response in DP-V1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AccessError {
    /// The device has no such slot.
    UnknownSlot,
    /// The slot has no such index, or not for the selected instance.
    UnknownIndex,
    /// The parameter cannot be read, or not by this master.
    NotReadable,
    /// The parameter cannot be written, or not by this master.
    NotWritable,
    /// A text, which the parameter channel cannot transfer.
    NotInChannel,
    /// Another length than the parameter's, or one that the parameter channel cannot transfer.
    WrongLength,
    /// The operating mode forbids it.
    WrongMode,
    /// The device is in the requested state already.
    AlreadyInState,
    /// The command is not possible in the present state.
    StateConflict,
    /// The value is outside the range or not in the code table.
    OutOfRange,
    /// The nonvolatile memory failed; nothing has changed.
    StorageFailed,
    /// The parameter channel has no such task.
    UnknownTask,
}

impl AccessError {
    /// Code of the parameter channel and Error_Code_1 of DP-V1, which carries the first as Error_Code_2.
    ///
    /// Parameter channel: errata-bpg-bcg-tpg 23; a device with fewer or other codes names them in its
    /// [`ChannelRules`](crate::model::ChannelRules). DP-V1: errata-bpg-bcg-tpg 121 and profibus-wire 4.1.3.
    const fn codes(self) -> (u8, ErrorCode) {
        match self {
            Self::UnknownSlot => (0, ErrorCode::INVALID_SLOT),
            Self::UnknownIndex => (3, ErrorCode::INVALID_INDEX),
            Self::NotReadable => (18, ErrorCode::ACCESS_DENIED),
            Self::NotWritable => (1, ErrorCode::ACCESS_DENIED),
            Self::NotInChannel | Self::WrongLength => (5, ErrorCode::WRITE_LENGTH),
            Self::WrongMode => (17, ErrorCode::STATE_CONFLICT),
            Self::AlreadyInState => (201, ErrorCode::STATE_CONFLICT),
            Self::StateConflict => (202, ErrorCode::STATE_CONFLICT),
            Self::OutOfRange => (2, ErrorCode::INVALID_RANGE),
            // chosen: the manuals know no code for a memory that fails; "other errors" and "write error" are
            // nearest.
            Self::StorageFailed => (18, ErrorCode::WRITE_ERROR),
            Self::UnknownTask => (18, ErrorCode::FEATURE_NOT_SUPPORTED),
        }
    }

    /// The code of the parameter channel, unless the device's [`ChannelRules`](crate::model::ChannelRules) have
    /// another.
    #[must_use]
    pub const fn channel_code(self) -> u8 {
        self.codes().0
    }
}

impl core::fmt::Display for AccessError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::UnknownSlot => "the device has no such slot",
            Self::UnknownIndex => "the slot has no such index",
            Self::NotReadable => "the parameter cannot be read",
            Self::NotWritable => "the parameter cannot be written",
            Self::NotInChannel => "the parameter channel transfers no texts",
            Self::WrongLength => "the length is not that of the parameter",
            Self::WrongMode => "the operating mode forbids it",
            Self::AlreadyInState => "the device is in the requested state already",
            Self::StateConflict => "the command is not possible in the present state",
            Self::OutOfRange => "the value is out of range",
            Self::StorageFailed => "the nonvolatile memory failed",
            Self::UnknownTask => "the parameter channel has no such task",
        })
    }
}

impl core::error::Error for AccessError {}

impl From<AccessError> for profivac_dp::slave::Dpv1Error {
    fn from(error: AccessError) -> Self {
        let (channel, code_1) = error.codes();
        Self::new(code_1).with(channel)
    }
}
