//! The gauges that each channel can have. BG 5530 Appendix A, errata-pxg55x-img400 155 and 156.

use super::parts::{self, CHANNELS};
use crate::model::PartSpec;
use crate::profile::Thresholds;

/// A gauge for channel 1 or 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IonGauge {
    /// BAG: Bayard-Alpert.
    Bag,
    /// EXT: extractor.
    Ext,
}

impl IonGauge {
    pub(super) const fn thresholds(self) -> &'static Thresholds {
        match self {
            Self::Bag => &parts::BAG_CATHODE,
            Self::Ext => &parts::EXT_CATHODE,
        }
    }
}

/// A gauge for channel 3 or 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherGauge {
    /// TPR: Pirani.
    Tpr,
    /// CMR: capacitance diaphragm.
    Cmr,
}

/// The gauges of the four channels. All 81 combinations work, also the four that the manual does not list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gauges {
    /// Channel 1.
    pub ch1: Option<IonGauge>,
    /// Channel 2.
    pub ch2: Option<IonGauge>,
    /// Channel 3.
    pub ch3: Option<OtherGauge>,
    /// Channel 4.
    pub ch4: Option<OtherGauge>,
}

impl Default for Gauges {
    /// One of each: BAG, EXT, TPR, CMR.
    fn default() -> Self {
        Self {
            ch1: Some(IonGauge::Bag),
            ch2: Some(IonGauge::Ext),
            ch3: Some(OtherGauge::Tpr),
            ch4: Some(OtherGauge::Cmr),
        }
    }
}

impl Gauges {
    /// The entry of the tables for the gauge of each channel; `None` for a channel without a gauge.
    pub(super) const fn parts(self) -> [Option<&'static PartSpec>; CHANNELS] {
        let ch1 = match self.ch1 {
            None => None,
            Some(IonGauge::Bag) => Some(&parts::BAG_1),
            Some(IonGauge::Ext) => Some(&parts::EXT_1),
        };
        let ch2 = match self.ch2 {
            None => None,
            Some(IonGauge::Bag) => Some(&parts::BAG_2),
            Some(IonGauge::Ext) => Some(&parts::EXT_2),
        };
        let ch3 = match self.ch3 {
            None => None,
            Some(OtherGauge::Tpr) => Some(&parts::TPR_3),
            Some(OtherGauge::Cmr) => Some(&parts::CMR_3),
        };
        let ch4 = match self.ch4 {
            None => None,
            Some(OtherGauge::Tpr) => Some(&parts::TPR_4),
            Some(OtherGauge::Cmr) => Some(&parts::CMR_4),
        };
        [ch1, ch2, ch3, ch4]
    }
}
