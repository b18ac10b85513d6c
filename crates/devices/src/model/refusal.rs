//! Why a device refuses an access, and the two codes that say so.

/// A refused access. The order is the order of the checks: errata-bpg-bcg-tpg 23, errata-pxg55x-img400 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// There is no such slot.
    Slot,
    /// The slot has no such index, or not for the selected instance.
    Index,
    /// Not for reading, or not for this master.
    NotReadable,
    /// Not for writing, or not for this master.
    NotWritable,
    /// A text, which the parameter channel cannot carry.
    Text,
    /// Another length than the parameter's, or one the parameter channel cannot carry.
    Length,
    /// The operating mode forbids it.
    Mode,
    /// Already in the requested state.
    AlreadyThere,
    /// Not in this state.
    Conflict,
    /// Outside the range or the enumeration.
    Range,
    /// The nonvolatile memory took nothing; nothing has changed.
    Storage,
    /// No such instruction in the parameter channel.
    Instruction,
}

impl Refusal {
    /// Code of the parameter channel and Error_Code_1 of DP-V1, which carries the first as Error_Code_2.
    ///
    /// Parameter channel: errata-bpg-bcg-tpg 23; a device that knows fewer or other codes names them in its
    /// [`Dialect`](crate::model::Dialect). DP-V1: errata-bpg-bcg-tpg 121 and profibus-wire 4.1.3.
    const fn codes(self) -> (u8, u8) {
        match self {
            Self::Slot => (0, 0xB2),
            Self::Index => (3, 0xB0),
            Self::NotReadable => (18, 0xB6),
            Self::NotWritable => (1, 0xB6),
            Self::Text | Self::Length => (5, 0xB1),
            Self::Mode => (17, 0xB5),
            Self::AlreadyThere => (201, 0xB5),
            Self::Conflict => (202, 0xB5),
            Self::Range => (2, 0xB7),
            // free choice: the manuals know no code for a memory that fails; "other errors" and "write error" are nearest.
            Self::Storage => (18, 0xA1),
            Self::Instruction => (18, 0xA9),
        }
    }

    /// The code of the parameter channel, unless the device's dialect has another.
    #[must_use]
    pub const fn channel_code(self) -> u8 {
        self.codes().0
    }
}

impl From<Refusal> for profivac_dp::slave::Refusal {
    fn from(refusal: Refusal) -> Self {
        let (channel, code_1) = refusal.codes();
        Self::new(code_1).with(channel)
    }
}
