//! Service access points and their DP services. profibus-wire 2.1.

/// The service behind a destination service access point.
///
/// ```
/// use profivac_wire::Sap;
///
/// assert_eq!(Sap::from_octet(Some(60)), Sap::SlaveDiag);
/// assert_eq!(Sap::from_octet(None), Sap::Default);
/// assert_eq!(Sap::SetPrm.to_octet(), Some(61));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Sap {
    /// No access point: Data_Exchange.
    Default,
    /// 0 to 48: MS2 connections, assigned by the resource manager.
    Ms2(u8),
    /// 49: the resource manager, which opens MS2 connections.
    ResourceManager,
    /// 50: acknowledgement of alarms on a separate access point.
    Alarm,
    /// 51: MS1, read and write by the class 1 master.
    Ms1,
    /// 53: Set_Ext_Prm, DP-V2.
    SetExtPrm,
    /// 55: Set_Slave_Add.
    SetSlaveAdd,
    /// 56: RD_Inp.
    RdInp,
    /// 57: RD_Outp.
    RdOutp,
    /// 58: Global_Control.
    GlobalControl,
    /// 59: Get_Cfg.
    GetCfg,
    /// 60: Slave_Diag.
    SlaveDiag,
    /// 61: Set_Prm.
    SetPrm,
    /// 62: Chk_Cfg.
    ChkCfg,
    /// Any other extension octet, including those with bits 7 or 6 set.
    Other(u8),
}

/// The source access point of a class 1 master for all DP-V0 services.
pub const MASTER_MS0: u8 = 62;
/// The source access point of a class 1 master for MS1.
pub const MASTER_MS1: u8 = 51;
/// The source access point of a class 2 master for MS2.
pub const MASTER_MS2: u8 = 50;

impl Sap {
    /// The service of an extension octet, or of none.
    #[must_use]
    #[inline]
    pub const fn from_octet(dsap: Option<u8>) -> Self {
        match dsap {
            None => Self::Default,
            Some(connection @ 0..=48) => Self::Ms2(connection),
            Some(49) => Self::ResourceManager,
            Some(50) => Self::Alarm,
            Some(51) => Self::Ms1,
            Some(53) => Self::SetExtPrm,
            Some(55) => Self::SetSlaveAdd,
            Some(56) => Self::RdInp,
            Some(57) => Self::RdOutp,
            Some(58) => Self::GlobalControl,
            Some(59) => Self::GetCfg,
            Some(60) => Self::SlaveDiag,
            Some(61) => Self::SetPrm,
            Some(62) => Self::ChkCfg,
            Some(other) => Self::Other(other),
        }
    }

    /// The extension octet that addresses this service.
    #[must_use]
    pub const fn to_octet(self) -> Option<u8> {
        match self {
            Self::Default => None,
            Self::Ms2(connection) => Some(connection),
            Self::ResourceManager => Some(49),
            Self::Alarm => Some(50),
            Self::Ms1 => Some(51),
            Self::SetExtPrm => Some(53),
            Self::SetSlaveAdd => Some(55),
            Self::RdInp => Some(56),
            Self::RdOutp => Some(57),
            Self::GlobalControl => Some(58),
            Self::GetCfg => Some(59),
            Self::SlaveDiag => Some(60),
            Self::SetPrm => Some(61),
            Self::ChkCfg => Some(62),
            Self::Other(other) => Some(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_access_point_is_unchanged_after_decoding_and_encoding() {
        assert_eq!(Sap::from_octet(None).to_octet(), None);
        for octet in 0..=0xFF {
            assert_eq!(Sap::from_octet(Some(octet)).to_octet(), Some(octet));
        }
    }
}
