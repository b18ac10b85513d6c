//! Parameterisation of a slave (SAP 61). profibus-wire 2.4.

use crate::octets::{Reader, TooLong, TooShort, Writer};

bitflags::bitflags! {
    /// Station_Status, the first octet of Set_Prm.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct PrmStatus: u8 {
        /// Bits 0 to 2, reserved: 0.
        const RESERVED = 0x07;
        /// Activate the response watchdog.
        const WD_ON = 1 << 3;
        /// The master uses Freeze.
        const FREEZE_REQ = 1 << 4;
        /// The master uses Sync.
        const SYNC_REQ = 1 << 5;
        /// Release the slave for other masters.
        const UNLOCK_REQ = 1 << 6;
        /// Lock the slave for other masters.
        const LOCK_REQ = 1 << 7;
    }
}

bitflags::bitflags! {
    /// DPV1_Status_1, the first octet of the user parameters of a DP-V1 slave.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Dpv1Status1: u8 {
        /// Disable start bit monitoring (ASIC specific, otherwise reserved).
        const DIS_START_CONTROL = 1 << 0;
        /// Disable stop bit monitoring (ASIC specific, otherwise reserved).
        const DIS_STOP_CONTROL = 1 << 1;
        /// The watchdog base is 1 ms instead of 10 ms.
        const WD_BASE_1MS = 1 << 2;
        /// Bits 3 and 4, reserved: 0.
        const RESERVED = 0x18;
        /// Publisher mode of DP-V2.
        const PUBLISHER_ENABLE = 1 << 5;
        /// Fail-safe: in Clear the master sends outputs without data.
        const FAIL_SAFE = 1 << 6;
        /// Activate DP-V1 mode.
        const DPV1_ENABLE = 1 << 7;
    }
}

bitflags::bitflags! {
    /// DPV1_Status_2, the second octet of the user parameters of a DP-V1 slave.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Dpv1Status2: u8 {
        /// The slave may accept a configuration that deviates, by a rule of its own.
        const CHECK_CFG_MODE = 1 << 0;
        /// Bit 1, reserved: 0.
        const RESERVED = 0x02;
        /// Enable update alarms.
        const UPDATE_ALARM = 1 << 2;
        /// Enable status alarms.
        const STATUS_ALARM = 1 << 3;
        /// Enable alarms of the manufacturer.
        const MANUFACTURER_ALARM = 1 << 4;
        /// Enable diagnostic alarms.
        const DIAGNOSTIC_ALARM = 1 << 5;
        /// Enable process alarms.
        const PROCESS_ALARM = 1 << 6;
        /// Enable alarms when a module is pulled or plugged.
        const PULL_PLUG_ALARM = 1 << 7;
    }
}

bitflags::bitflags! {
    /// DPV1_Status_3, the third octet of the user parameters of a DP-V1 slave.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Dpv1Status3: u8 {
        /// Bits 0 to 2: 0 is one alarm of each type, other values are a total number of alarms.
        const ALARM_MODE = 0x07;
        /// Structured blocks follow instead of plain user parameters.
        const PRM_STRUCTURE = 1 << 3;
        /// Isochronous mode of DP-V2.
        const ISOM_REQ = 1 << 4;
        /// Bits 5 and 6, reserved: 0.
        const RESERVED = 0x60;
        /// A PrmCmd of DP-V2.
        const PRM_CMD = 1 << 7;
    }
}

/// The data unit of Set_Prm.
///
/// ```
/// use profivac_wire::prm::{PrmStatus, SetPrm};
///
/// let prm = SetPrm::parse(&[0x88, 10, 10, 11, 0x12, 0x34, 1])?;
/// assert_eq!(prm.status, PrmStatus::LOCK_REQ | PrmStatus::WD_ON);
/// assert_eq!((prm.ident, prm.min_tsdr), (0x1234, 11));
///
/// let mut out = [0; 7];
/// assert_eq!(prm.emit(&mut out)?, 7);
/// assert_eq!(out, [0x88, 10, 10, 11, 0x12, 0x34, 1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetPrm<'a> {
    /// Station_Status.
    pub status: PrmStatus,
    /// WD_Fact_1 and WD_Fact_2: the watchdog time is their product times the base (10 ms or 1 ms).
    pub wd_fact: [u8; 2],
    /// min T_SDR in bit times: earliest start of an answer; 0 keeps the present value.
    pub min_tsdr: u8,
    /// Ident_Number.
    pub ident: u16,
    /// Group_Ident: one bit for each group of Global_Control.
    pub group: u8,
    /// User_Prm_Data; on a DP-V1 slave it begins with the three DPV1_Status octets.
    pub user: &'a [u8],
}

impl<'a> SetPrm<'a> {
    /// Reads the data unit of a request.
    ///
    /// # Errors
    /// [`TooShort`] if the seven fixed octets are incomplete.
    pub fn parse(du: &'a [u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(du);
        Ok(Self {
            status: PrmStatus::from_bits_retain(reader.octet()?),
            wd_fact: [reader.octet()?, reader.octet()?],
            min_tsdr: reader.octet()?,
            ident: reader.word()?,
            group: reader.octet()?,
            user: reader.rest(),
        })
    }

    /// Writes the data unit to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let [first, second] = self.wd_fact;
        let mut writer = Writer::new(out);
        writer.octets(&[self.status.bits(), first, second, self.min_tsdr])?;
        writer.word(self.ident)?;
        writer.octet(self.group)?;
        writer.octets(self.user)?;
        Ok(writer.written())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hex;

    /// profibus-wire 2.4: lock, watchdog 1 s, min T_SDR 11, group 1, two user octets added.
    const TEXT: &str = "88 0A 0A 0B 12 34 01 C0 60";

    const EXAMPLE: SetPrm<'_> = SetPrm {
        status: PrmStatus::LOCK_REQ.union(PrmStatus::WD_ON),
        wd_fact: [10, 10],
        min_tsdr: 11,
        ident: 0x1234,
        group: 1,
        user: &[0xC0, 0x60],
    };

    #[test]
    fn parses() {
        assert_eq!(SetPrm::parse(&hex(TEXT)), Ok(EXAMPLE));
    }

    #[test]
    fn emits() {
        let mut out = [0; 9];
        assert_eq!(EXAMPLE.emit(&mut out), Ok(9));
        assert_eq!(out[..], hex(TEXT));
        assert_eq!(EXAMPLE.emit(&mut [0; 8]), Err(TooLong));
    }

    #[test]
    fn too_short() {
        for length in 0..7 {
            assert_eq!(SetPrm::parse(&hex(TEXT)[..length]), Err(TooShort));
        }
    }

    #[test]
    fn every_bit_is_unchanged_after_parse_and_emit() {
        for bit in 0..72 {
            let mut octets = hex(TEXT);
            octets[bit / 8] ^= 1 << (bit % 8);
            let mut out = [0; 9];
            assert_eq!(SetPrm::parse(&octets).unwrap().emit(&mut out), Ok(9));
            assert_eq!(out[..], octets);
        }
    }
}
