//! The diagnosis of a slave (SAP 60). profibus-wire 2.3.

use crate::octets::{Reader, TooLong, TooShort, Writer};

bitflags::bitflags! {
    /// Station_Status_1 to 3: octet 1 in bits 0 to 7, octet 2 in 8 to 15, octet 3 in 16 to 23.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct StationStatus: u32 {
        /// Set by the master: the slave does not answer.
        const STATION_NON_EXISTENT = 1 << 0;
        /// Not ready for Data_Exchange.
        const STATION_NOT_READY = 1 << 1;
        /// The last Chk_Cfg did not match.
        const CFG_FAULT = 1 << 2;
        /// The extended diagnosis reports an event.
        const EXT_DIAG = 1 << 3;
        /// The slave does not support a requested function.
        const NOT_SUPPORTED = 1 << 4;
        /// Set by the master: the slave's answer is implausible.
        const INVALID_SLAVE_RESPONSE = 1 << 5;
        /// The last Set_Prm was faulty.
        const PRM_FAULT = 1 << 6;
        /// Set by the master: the slave is parameterised by another master.
        const MASTER_LOCK = 1 << 7;
        /// The slave must be parameterised.
        const PRM_REQ = 1 << 8;
        /// Static diagnosis: no valid process data yet.
        const STAT_DIAG = 1 << 9;
        /// Always 1 in the answer of a slave.
        const ALWAYS_ONE = 1 << 10;
        /// The response watchdog is on.
        const WD_ON = 1 << 11;
        /// Inputs are frozen.
        const FREEZE_MODE = 1 << 12;
        /// Outputs are synchronised.
        const SYNC_MODE = 1 << 13;
        /// Set by the master: excluded from the cycle.
        const DEACTIVATED = 1 << 15;
        /// The slave has more diagnosis data than the telegram carries.
        const EXT_DIAG_OVERFLOW = 1 << 23;
        // Reserved bits are kept as received.
        const _ = !0;
    }
}

/// The names of the bits according to profibus-wire 2.3, in the order of the bits. The bit that is always 1 has none.
const NAMES: [(StationStatus, &str); 15] = [
    (StationStatus::STATION_NON_EXISTENT, "Station_Non_Existent"),
    (StationStatus::STATION_NOT_READY, "Station_Not_Ready"),
    (StationStatus::CFG_FAULT, "Cfg_Fault"),
    (StationStatus::EXT_DIAG, "Ext_Diag"),
    (StationStatus::NOT_SUPPORTED, "Not_Supported"),
    (StationStatus::INVALID_SLAVE_RESPONSE, "Invalid_Slave_Response"),
    (StationStatus::PRM_FAULT, "Prm_Fault"),
    (StationStatus::MASTER_LOCK, "Master_Lock"),
    (StationStatus::PRM_REQ, "Prm_Req"),
    (StationStatus::STAT_DIAG, "Stat_Diag"),
    (StationStatus::WD_ON, "WD_On"),
    (StationStatus::FREEZE_MODE, "Freeze_Mode"),
    (StationStatus::SYNC_MODE, "Sync_Mode"),
    (StationStatus::DEACTIVATED, "Deactivated"),
    (StationStatus::EXT_DIAG_OVERFLOW, "Ext_Diag_Overflow"),
];

impl StationStatus {
    /// The names of the bits that are set, in the words of profibus-wire 2.3. The bit that is always 1 and reserved bits have none.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        NAMES.iter().filter(move |(bit, _)| self.contains(*bit)).map(|(_, name)| *name)
    }

    /// The set bits that have no meaning.
    #[must_use]
    pub fn reserved(self) -> Self {
        NAMES.iter().fold(self.difference(Self::ALWAYS_ONE), |rest, (bit, _)| rest.difference(*bit))
    }
}

/// Diag_Master_Add of a slave that no master has parameterised.
pub const NO_MASTER: u8 = 0xFF;

/// The answer to Slave_Diag.
///
/// ```
/// use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};
///
/// let diag = SlaveDiag::parse(&[0x02, 0x05, 0x00, 0xFF, 0x12, 0x34])?;
/// assert!(diag.status.contains(StationStatus::PRM_REQ));
/// assert_eq!((diag.master_add, diag.ident), (NO_MASTER, 0x1234));
///
/// let mut out = [0; 6];
/// assert_eq!(diag.emit(&mut out)?, 6);
/// assert_eq!(out, [0x02, 0x05, 0x00, 0xFF, 0x12, 0x34]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SlaveDiag<'a> {
    /// Station_Status_1 to 3.
    pub status: StationStatus,
    /// Diag_Master_Add: address of the master that parameterised the slave, or [`NO_MASTER`].
    pub master_add: u8,
    /// Ident_Number.
    pub ident: u16,
    /// Ext_Diag_Data: empty, or a list of blocks (see [`crate::ext_diag`]).
    pub ext_diag: &'a [u8],
}

impl<'a> SlaveDiag<'a> {
    /// Reads the data unit of an answer.
    ///
    /// # Errors
    /// [`TooShort`] if the six fixed octets are incomplete.
    pub fn parse(du: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(du);
        let status = [reader.octet()?, reader.octet()?, reader.octet()?, 0];
        Ok(Self {
            status: StationStatus::from_bits_retain(u32::from_le_bytes(status)),
            master_add: reader.octet()?,
            ident: reader.word()?,
            ext_diag: reader.rest(),
        })
    }

    /// Writes the data unit to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let [first, second, third, _] = self.status.bits().to_le_bytes();
        let mut writer = Writer::new(out);
        writer.octets(&[first, second, third, self.master_add])?;
        writer.word(self.ident)?;
        writer.octets(self.ext_diag)?;
        Ok(writer.written())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hex;

    /// profibus-wire 2.3.1, the example of the standard.
    const TEXT: &str = "08 0C 00 02 12 34 04 11 22 33";

    fn example(ext_diag: &[u8]) -> SlaveDiag<'_> {
        let status = StationStatus::EXT_DIAG | StationStatus::ALWAYS_ONE | StationStatus::WD_ON;
        SlaveDiag { status, master_add: 2, ident: 0x1234, ext_diag }
    }

    #[test]
    fn every_bit_has_a_name_or_is_reserved() {
        let all = StationStatus::all();
        assert_eq!(all.names().count(), NAMES.len());
        assert_eq!(all.reserved().bits(), 0xFF7F_4000);
        let status = StationStatus::PRM_REQ | StationStatus::PRM_FAULT | StationStatus::ALWAYS_ONE;
        assert!(status.names().eq(["Prm_Fault", "Prm_Req"]));
        assert!(status.reserved().is_empty());
    }

    #[test]
    fn parses() {
        let octets = hex(TEXT);
        assert_eq!(SlaveDiag::parse(&octets), Ok(example(&[4, 0x11, 0x22, 0x33])));
    }

    #[test]
    fn emits() {
        let mut out = [0; 10];
        assert_eq!(example(&[4, 0x11, 0x22, 0x33]).emit(&mut out), Ok(10));
        assert_eq!(out[..], hex(TEXT));
        assert_eq!(example(&[4, 0x11, 0x22, 0x33]).emit(&mut [0; 9]), Err(TooLong));
    }

    #[test]
    fn too_short() {
        for length in 0..6 {
            assert_eq!(SlaveDiag::parse(&hex(TEXT)[..length]), Err(TooShort));
        }
    }

    #[test]
    fn every_bit_of_the_fixed_octets_is_unchanged_after_parse_and_emit() {
        for bit in 0..48 {
            let mut octets = hex("02 05 00 FF 12 34");
            octets[bit / 8] ^= 1 << (bit % 8);
            let mut out = [0; 6];
            assert_eq!(SlaveDiag::parse(&octets).unwrap().emit(&mut out), Ok(6));
            assert_eq!(out[..], octets);
        }
    }
}
