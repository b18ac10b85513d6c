//! Slaves on a line in simulated bit times: the virtual devices, and a small slave with every service that a rule needs.

use profivac_conform::dialogue::{Link, SlaveUnderTest};
use profivac_conform::probe::Received;
use profivac_devices::catalog::model_named;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received as Decoded, Receiver, Station, T_SYN_TBIT};
use profivac_dp::slave::{CfgFault, Device, Diagnosis, Features, Outputs, PrmFault, Slave};
use profivac_host::port::PortError;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::cfg;
use std::time::Duration;

const BAUD: Baud = Baud::B19200;

/// The address of the slave.
pub const ADDRESS: u8 = 8;

/// The address of the testing master.
pub const MASTER: u8 = 2;

/// A line with one slave.
pub struct Line<S> {
    pub slave: S,
    receiver: Receiver,
    now: BitTime,
}

impl<S: Station> Line<S> {
    pub fn new(slave: S) -> Self {
        Self { slave, receiver: Receiver::with_idle(BitTime(0), T_SYN_TBIT), now: BitTime(1000) }
    }

    /// The time in milliseconds.
    pub fn now_ms(&self) -> u64 {
        self.now.0 / BAUD.tbit_of_ms(1)
    }

    /// Sends octets to the slave. Returns its answer.
    pub fn send(&mut self, octets: &[u8]) -> Received {
        self.now = self.now + 60;
        self.slave.poll(self.now);
        let mut received = Received::Nothing;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            if let Decoded::Telegram(telegram) = self.receiver.octet(self.now, *octet)
                && let Some(answer) = self.slave.telegram(self.now, &telegram)
            {
                received = Received::Telegram(answer.octets.to_vec());
            }
        }
        let Received::Telegram(answer) = &received else {
            self.now = self.now + 100;
            return received;
        };
        self.now = self.now + 11 + CHARACTER_TBIT * answer.len() as u64;
        self.slave.sent(self.now);
        // The receiver does not get the answer of its own slave, so it starts again with an idle line.
        self.receiver = Receiver::with_idle(BitTime(0), T_SYN_TBIT);
        received
    }

    pub fn pass(&mut self, time: Duration) {
        let end = self.now + BAUD.tbit_of_ms(time.as_millis() as u64);
        while self.now < end {
            self.now = self.now + BAUD.tbit_of_ms(1);
            self.slave.poll(self.now);
        }
    }
}

impl<S: Station> Link for Line<S> {
    fn address(&self) -> u8 {
        MASTER
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        Ok(self.send(octets))
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.pass(time);
        Ok(())
    }
}

/// A virtual device with its first user parameters and its first configuration.
pub fn virtual_device(name: &str) -> (Line<VirtualDevice>, SlaveUnderTest) {
    let spec: DeviceSpec = format!("{name}@{ADDRESS}").parse().unwrap();
    let conditions = GasConditions {
        pressure: "1e-3 mbar".parse().unwrap(),
        atmosphere: "1000 mbar".parse().unwrap(),
        gas: Gas::N2,
    };
    let built = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    let model = model_named(name).unwrap();
    let prm = model.user_prm.first().map_or(&[][..], |prm| prm.octets);
    let cfg = model.configurations.first().unwrap().octets;
    let (cfg, user_prm) = (cfg.to_vec(), prm.to_vec());
    let subject = SlaveUnderTest { address: ADDRESS, ident: model.ident, cfg, user_prm, stated: None };
    (Line::new(VirtualDevice::new(built, ADDRESS, BAUD, conditions)), subject)
}

/// A device with two octets in each direction, unless it has another configuration, and with Sync, Freeze, MS1, MS2 and a status in its
/// diagnosis.
pub struct Sample {
    cfg: &'static [u8],
}

/// Its configuration: two octets of inputs, two octets of outputs.
pub const CFG: [u8; 2] = [0x11, 0x21];

/// Its user parameters: DPV1_Enable opens MS1.
const USER_PRM: [u8; 3] = [0x80, 0, 0];

pub const IDENT: u16 = 0x1234;

impl Device for Sample {
    fn ident_number(&self) -> u16 {
        IDENT
    }

    fn features(&self) -> Features {
        Features { sync: true, freeze: true, dpv1: true, ms1: true }
    }

    fn set_prm(&mut self, _user: &[u8]) -> Result<(), PrmFault> {
        Ok(())
    }

    fn chk_cfg(&mut self, octets: &[u8]) -> Result<cfg::Lengths, CfgFault> {
        if octets == self.cfg { cfg::lengths(octets).map_err(|_| CfgFault) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        self.cfg
    }

    fn outputs(&mut self, _outputs: Outputs<'_>) {}

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.iter_mut().zip([0xAA, 0x55]).for_each(|(input, value)| *input = value);
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        // An identifier-related block.
        Diagnosis { blocks: &[0x42, 0x00], ..Diagnosis::default() }
    }
}

/// The small slave.
pub type SampleSlave = Slave<Sample>;

/// The small slave, which keeps every rule.
pub fn sample() -> (Line<SampleSlave>, SlaveUnderTest) {
    sample_with(&CFG)
}

/// The small slave with another configuration.
pub fn sample_with(cfg: &'static [u8]) -> (Line<SampleSlave>, SlaveUnderTest) {
    let (octets, user_prm) = (cfg.to_vec(), USER_PRM.to_vec());
    let subject = SlaveUnderTest { address: ADDRESS, ident: IDENT, cfg: octets, user_prm, stated: None };
    (Line::new(Slave::new(Sample { cfg }, ADDRESS, BAUD)), subject)
}
