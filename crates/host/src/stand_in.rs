//! A stand-in until the first device is there.

use profivac_devices::{Action, Indicated, Instrument, Part, Principle, Report, Unknown};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault};
use profivac_wire::cfg::Lengths;

/// One Pirani.
pub struct StandIn {
    address: u8,
    pa: f64,
    fault: bool,
    seconds: f64,
}

impl StandIn {
    /// At an address.
    pub fn new(address: u8) -> Self {
        Self { address, pa: 0.0, fault: false, seconds: 0.0 }
    }
}

impl Device for StandIn {
    fn ident_number(&self) -> u16 {
        0x08E6
    }
    fn features(&self) -> Features {
        Features::default()
    }
    fn set_prm(&mut self, _user: &[u8]) -> Result<(), PrmFault> {
        Ok(())
    }
    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        if cfg == [0x43, 0x83, 0x08] { Ok(Lengths { inputs: 4, outputs: 0 }) } else { Err(CfgFault) }
    }
    fn get_cfg(&self) -> &[u8] {
        &[0x43, 0x83, 0x08]
    }
    fn outputs(&mut self, _outputs: Outputs<'_>) {}
    fn inputs(&mut self, inputs: &mut [u8]) {
        if let Some(place) = inputs.get_mut(..4) {
            place.copy_from_slice(&(self.pa as f32).to_be_bytes());
        }
    }
}

impl Instrument for StandIn {
    fn name(&self) -> &'static str {
        "bcg450"
    }
    fn station_address(&self) -> u8 {
        self.address
    }
    fn parts(&self) -> &[Part] {
        &[Part { instance: 1, principle: Principle::Pirani }]
    }
    fn sense(&mut self, _part: usize, pa: f64) {
        self.pa = pa;
    }
    fn advance(&mut self, seconds: f64) {
        self.seconds += seconds;
    }
    fn settle(&mut self) {}
    fn power(&mut self, _on: bool) {}
    fn faults(&self) -> &'static [&'static str] {
        &["eeprom", "sensor1"]
    }
    fn operate(&mut self, action: Action<'_>) -> Result<(), Unknown> {
        match action {
            Action::Fault { name: "eeprom" | "sensor1", present } => self.fault = present,
            Action::Fault { .. } => return Err(Unknown { expected: &["eeprom", "sensor1"] }),
            _ => return Err(Unknown { expected: &[] }),
        }
        Ok(())
    }
    fn report(&self) -> Report {
        Report {
            device_state: "EXECUTING",
            led: "none",
            indicated: [Indicated { instance: 1, value_mbar: self.pa / 100.0, valid: !self.fault }]
                .into_iter()
                .collect(),
            active_instance: 1,
            run_hours: self.seconds / 3600.0,
            ..Report::default()
        }
    }
}
