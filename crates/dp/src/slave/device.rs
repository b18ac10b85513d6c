//! The interface between a DP slave and the device behind it.

use crate::link::Baud;
use core::fmt;
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;
use profivac_wire::acyclic::{AlarmAck, ErrorCode};
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;
use profivac_wire::ident::Ident;

/// The protocol features of a device. They are fixed for the life of the device; the GSD file says the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Features {
    /// Sync is supported.
    pub sync: bool,
    /// Freeze is supported.
    pub freeze: bool,
    /// A DP-V1 device: the user parameters begin with the three DPV1_Status octets, the slave checks reserved bits, and class
    /// 2 masters may connect (MS2).
    pub dpv1: bool,
    /// MS1 read and write once DPV1_Enable was set and data exchange has begun.
    pub ms1: bool,
}

/// The device does not accept the user parameters: Prm_Fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PrmFault;

impl fmt::Display for PrmFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the device does not accept the user parameters")
    }
}

impl core::error::Error for PrmFault {}

/// The device does not have this configuration: Cfg_Fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CfgFault;

impl fmt::Display for CfgFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the device does not have this configuration")
    }
}

impl core::error::Error for CfgFault {}

/// Outputs for the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outputs<'a> {
    /// The master's data, exactly as long as the configuration says.
    Data(&'a [u8]),
    /// No data, the device enters its safe state: Clear, fail-safe, watchdog, and before the first exchange.
    Safe,
}

/// The device-dependent part of a diagnosis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Diagnosis<'a> {
    /// Ext_Diag: the blocks report an event and not a status.
    pub event: bool,
    /// Stat_Diag: no valid process data yet.
    pub static_diag: bool,
    /// Ext_Diag_Data, at most 238 octets. Longer ones are refused with UE, and the diagnosis stays pending.
    pub blocks: &'a [u8],
}

/// The relation through which an acyclic access comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Relation {
    /// The class 1 master that owns the slave.
    Ms1,
    /// A class 2 master, on the connection with this number (0 for the first).
    Ms2(u8),
}

/// A negative DP-V1 response: Error_Code_1 and Error_Code_2; Error_Decode is always 128. profibus-wire 4.1.2 and 4.1.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dpv1Error {
    /// Error_Code_1: Error_Class and Error_Code.
    pub code_1: ErrorCode,
    /// Defined by the device.
    pub code_2: u8,
}

impl Dpv1Error {
    /// The application does not have the feature.
    pub const FEATURE_NOT_SUPPORTED: Self = Self::new(ErrorCode::FEATURE_NOT_SUPPORTED);
    /// The index does not exist.
    pub const INVALID_INDEX: Self = Self::new(ErrorCode::INVALID_INDEX);
    /// The data are longer or shorter than the parameter.
    pub const WRITE_LENGTH: Self = Self::new(ErrorCode::WRITE_LENGTH);
    /// The slot does not exist.
    pub const INVALID_SLOT: Self = Self::new(ErrorCode::INVALID_SLOT);
    /// The request contradicts itself.
    pub const TYPE_CONFLICT: Self = Self::new(ErrorCode::TYPE_CONFLICT);
    /// The access is not possible in this state.
    pub const STATE_CONFLICT: Self = Self::new(ErrorCode::STATE_CONFLICT);
    /// The requester has no access, or not in this direction.
    pub const ACCESS_DENIED: Self = Self::new(ErrorCode::ACCESS_DENIED);
    /// The value is not allowed.
    pub const INVALID_RANGE: Self = Self::new(ErrorCode::INVALID_RANGE);
    /// A field of the request is not allowed.
    pub const INVALID_PARAMETER: Self = Self::new(ErrorCode::INVALID_PARAMETER);

    /// An error with this Error_Code_1 and an Error_Code_2 of 0.
    #[must_use]
    pub const fn new(code_1: ErrorCode) -> Self {
        Self { code_1, code_2: 0 }
    }

    /// The same with the device's own Error_Code_2.
    #[must_use]
    pub const fn with(self, code_2: u8) -> Self {
        Self { code_2, ..self }
    }
}

impl fmt::Display for Dpv1Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the device refuses the access: {}, error code 2 is {}", self.code_1, self.code_2)
    }
}

impl core::error::Error for Dpv1Error {}

/// The device behind a slave. It sees no telegrams, bit times or master addresses, only what follows from them.
pub trait Device {
    /// Ident_Number.
    fn ident_number(&self) -> u16;

    /// The protocol features.
    fn features(&self) -> Features;

    /// Whether class 2 masters may connect (MS2). By default to every DP-V1 device.
    fn has_ms2(&self) -> bool {
        self.features().dpv1
    }

    /// Whether outputs of length zero mean Clear although no bit of Set_Prm says so: Fail_Safe of a DP-V0 device.
    fn is_fail_safe(&self) -> bool {
        false
    }

    /// The longest time until the device answers, in bit times: a greater min T_SDR of the master is lowered to it.
    fn max_tsdr_tbit(&self, baud: Baud) -> u16 {
        baud.max_tsdr_tbit()
    }

    /// Takes over the user parameters of a Set_Prm that is valid otherwise.
    ///
    /// # Errors
    /// [`PrmFault`] when the device does not accept them; nothing has changed then.
    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault>;

    /// Takes over the configuration of the master and returns the lengths of inputs and outputs. Not called for the present
    /// configuration during data exchange: that changes nothing.
    ///
    /// # Errors
    /// [`CfgFault`] when the device does not have this configuration; nothing has changed then.
    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault>;

    /// The present configuration for Get_Cfg, before the first Chk_Cfg the default one.
    fn get_cfg(&self) -> &[u8];

    /// Cyclic exchange begins (`true`) or has ended.
    fn set_exchanging(&mut self, _running: bool) {}

    /// New outputs.
    fn outputs(&mut self, outputs: Outputs<'_>);

    /// Writes the inputs into `inputs`, which is exactly as long as the configuration says.
    fn inputs(&mut self, inputs: &mut [u8]);

    /// Whether the inputs and Stat_Diag stay as they are when the outputs `before`, which the device has, are followed by `outputs`. Then
    /// the slave may encode the answer to a Data_Exchange before the request comes, and answers sooner. Otherwise, as by default, it
    /// collects the inputs for each answer, after the outputs of the request.
    ///
    /// The slave asks with the same outputs twice before it prepares an answer. A device that returns `true` then changes its inputs and
    /// its diagnosis only in calls of the slave, or behind [`Slave::device_mut`](super::Slave::device_mut), which drops the prepared
    /// answer; and it bears that [`inputs`](Self::inputs) is called without an answer being sent. A device whose inputs may follow the
    /// outputs of the exchange before, as with a chip that answers from a buffer, always returns `true`.
    fn keeps_inputs(&self, _before: &[u8], _outputs: &[u8]) -> bool {
        false
    }

    /// The device-dependent part of the diagnosis.
    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis::default()
    }

    /// Whether [`diagnosis`](Self::diagnosis) has changed since the last call. If so, the slave announces it.
    fn take_diagnosis_change(&mut self) -> bool {
        false
    }

    /// The owner has fetched the diagnosis. A device with several alarms may report the next one from now on, because each is in a
    /// diagnosis of its own. profibus-wire 4.5.
    fn diagnosis_fetched(&mut self) {}

    /// The owner acknowledges an alarm of the diagnosis. `false`, as by default, if no such alarm waits: the slave then leaves data
    /// exchange. profibus-wire 4.3 and 4.5.
    fn acknowledge_alarm(&mut self, _alarm: AlarmAck) -> bool {
        false
    }

    /// Whether the owner may acknowledge alarms over access point 50 too: Extra_Alarm_SAP_supp. profibus-wire 2.1.
    fn has_alarm_access_point(&self) -> bool {
        false
    }

    /// Whether the device accepts Set_Slave_Add.
    fn address_is_settable(&self) -> bool {
        false
    }

    /// Stores a new station address, if the device agrees. The ident number matches and the address is at most 125.
    /// Returns the address that is valid from now on, `None` if nothing changed.
    fn set_address(&mut self, _request: &SetSlaveAdd<'_>) -> Option<u8> {
        None
    }

    /// Reads a parameter into `record` and returns its whole length, at most 240 and at most `record.len()`.
    ///
    /// # Errors
    /// A [`Dpv1Error`] with the code of the manual.
    fn read(&mut self, _via: Relation, _slot: u8, _index: u8, _record: &mut [u8]) -> Result<usize, Dpv1Error> {
        Err(Dpv1Error::INVALID_SLOT)
    }

    /// Writes a parameter. After `Ok` a nonvolatile one is stored.
    ///
    /// # Errors
    /// A [`Dpv1Error`] with the code of the manual; nothing has changed then.
    fn write(&mut self, _via: Relation, _slot: u8, _index: u8, _record: &[u8]) -> Result<(), Dpv1Error> {
        Err(Dpv1Error::INVALID_SLOT)
    }

    /// Whether the device still executes what [`read`](Self::read) or [`write`](Self::write) began for this relation: a store takes
    /// time, or the values are in another context. Their result counts for nothing then. The slave acknowledges the request and
    /// every poll until this is `false`, and then calls [`complete`](Self::complete) once, unless the relation has ended.
    ///
    /// A new request of the relation may come earlier only after the relation has ended. It replaces the old one.
    fn is_executing(&self, _via: Relation) -> bool {
        false
    }

    /// The result of an access that took time: as [`read`](Self::read), or 0 for a write.
    ///
    /// # Errors
    /// As [`read`](Self::read) and [`write`](Self::write).
    fn complete(&mut self, _via: Relation, _record: &mut [u8]) -> Result<usize, Dpv1Error> {
        Err(Dpv1Error::STATE_CONFLICT)
    }

    /// I&M0, which a master reads after a Call to slot 0. `None` refuses index 255. profibus-wire 5.
    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        None
    }

    /// The answer to the identification service of layer 2. `None` closes the service. profibus-wire 1.11.
    fn ident(&self) -> Option<Ident<'_>> {
        None
    }
}
