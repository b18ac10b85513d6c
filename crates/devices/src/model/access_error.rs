//! Why a device refuses an access, and the two codes that say so.

/// A refused access. The order is the order of the checks: errata-bpg-bcg-tpg 23, errata-pxg55x-img400 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccessError {
    /// There is no such slot.
    UnknownSlot,
    /// The slot has no such index, or not for the selected instance.
    UnknownIndex,
    /// Not for reading, or not for this master.
    NotReadable,
    /// Not for writing, or not for this master.
    NotWritable,
    /// A text, which the parameter channel cannot carry.
    NotInChannel,
    /// Another length than the parameter's, or one the parameter channel cannot carry.
    WrongLength,
    /// The operating mode forbids it.
    WrongMode,
    /// Already in the requested state.
    AlreadyInState,
    /// Not in this state.
    StateConflict,
    /// Outside the range or the enumeration.
    OutOfRange,
    /// The nonvolatile memory took nothing; nothing has changed.
    StorageFailed,
    /// No such instruction in the parameter channel.
    UnknownTask,
}

impl AccessError {
    /// Code of the parameter channel and Error_Code_1 of DP-V1, which carries the first as Error_Code_2.
    ///
    /// Parameter channel: errata-bpg-bcg-tpg 23; a device that knows fewer or other codes names them in its
    /// [`Dialect`](crate::model::Dialect). DP-V1: errata-bpg-bcg-tpg 121 and profibus-wire 4.1.3.
    const fn codes(self) -> (u8, u8) {
        match self {
            Self::UnknownSlot => (0, 0xB2),
            Self::UnknownIndex => (3, 0xB0),
            Self::NotReadable => (18, 0xB6),
            Self::NotWritable => (1, 0xB6),
            Self::NotInChannel | Self::WrongLength => (5, 0xB1),
            Self::WrongMode => (17, 0xB5),
            Self::AlreadyInState => (201, 0xB5),
            Self::StateConflict => (202, 0xB5),
            Self::OutOfRange => (2, 0xB7),
            // free choice: the manuals know no code for a memory that fails; "other errors" and "write error" are nearest.
            Self::StorageFailed => (18, 0xA1),
            Self::UnknownTask => (18, 0xA9),
        }
    }

    /// The code of the parameter channel, unless the device's dialect has another.
    #[must_use]
    pub const fn channel_code(self) -> u8 {
        self.codes().0
    }
}

impl From<AccessError> for profivac_dp::slave::Dpv1Error {
    fn from(refusal: AccessError) -> Self {
        let (channel, code_1) = refusal.codes();
        Self::new(code_1).with(channel)
    }
}
