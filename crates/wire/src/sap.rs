//! Which DP service a destination service access point stands for. profibus-wire 2.1.

/// The destination service access point of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sap {
    /// No extension at all: Data_Exchange.
    Default,
    /// 0 to 48: connections of class 2 masters, as the resource manager hands them out.
    Ms2(u8),
    /// 49: the resource manager, which opens MS2 connections.
    ResourceManager,
    /// 50: alarm acknowledge on an access point of its own.
    Alarm,
    /// 51: read and write by the class 1 master.
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
    /// Any other extension octet, also one that is no access point (bits 7 and 6).
    Other(u8),
}

/// The source access point a class 1 master uses for all DP-V0 services.
pub const MASTER_MS0: u8 = 62;
/// The source access point a class 1 master uses for MS1.
pub const MASTER_MS1: u8 = 51;
/// The source access point a class 2 master uses for MS2.
pub const MASTER_MS2: u8 = 50;

impl Sap {
    /// The service behind an extension octet, or behind none.
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
    fn every_access_point_survives_parse_and_emit() {
        assert_eq!(Sap::from_octet(None).to_octet(), None);
        for octet in 0..=0xFF {
            assert_eq!(Sap::from_octet(Some(octet)).to_octet(), Some(octet));
        }
    }
}
