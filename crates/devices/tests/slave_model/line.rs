//! The real slave and the model on one line, in bit times.

use crate::slave_model::model::{DeviceDiagnosis, Model, State};
use crate::slave_model::process::Process;
use crate::slave_model::telegram::Receiver as NaiveReceiver;
use profivac_dp::link::{BitTime, Received, Receiver, Station};
use profivac_dp::slave::{Device, Slave, SlaveState};
use std::fmt;

const CHARACTER: u64 = 11;

/// An event on the line or in the application.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// These octets come, without a gap between them.
    Octets(Vec<u8>),
    /// The power goes and returns.
    PowerUp,
    /// The bus was lost and found.
    RateFound,
    /// The application leaves its master.
    ReturnToWaitPrm,
    /// The application has another diagnosis.
    Diagnosis(DeviceDiagnosis),
    /// Device time passes until everything is done; no bit time.
    Settle,
}

/// An event after an idle time.
#[derive(Clone, Debug)]
pub struct Step {
    /// Idle bit times before it.
    pub gap: u64,
    pub event: Event,
    /// The name for people.
    pub name: String,
}

impl Step {
    /// Bit times that it takes, without an answer.
    pub const fn duration(&self) -> u64 {
        match &self.event {
            Event::Octets(octets) => self.gap + CHARACTER * octets.len() as u64,
            _ => self.gap,
        }
    }
}

/// What a test needs of a real device besides [`Device`].
pub trait Driven: Device + Clone {
    /// The process of the model, which follows this device where the specification does not say what its octets are.
    type Process: Process;
    /// The moment of the next telegram.
    fn set_time(&mut self, now: u64);
    /// Another diagnosis.
    fn set_diagnosis(&mut self, diagnosis: DeviceDiagnosis);
    /// Lets device time pass until everything is done.
    fn settle(&mut self) {}
    /// Gives the process the device after a telegram.
    fn show(&self, process: &mut Self::Process);
}

/// A change of the answers of the slave, on purpose.
pub type Fault = fn(&mut Vec<u8>);

/// The real slave beside the model.
pub struct Line<D: Driven> {
    /// Shows that the comparison finds a fault.
    pub fault: Option<Fault>,
    slave: Slave<D>,
    receiver: Receiver,
    pub model: Model<D::Process>,
    naive: NaiveReceiver,
    pub now: u64,
}

/// A difference between both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference(pub String);

/// What a step led to.
pub struct Outcome {
    pub answer: Option<Vec<u8>>,
    pub difference: Option<Difference>,
}

/// Octets in hexadecimal.
pub fn hex(octets: &[u8]) -> String {
    octets.iter().map(|it| format!("{it:02X}")).collect::<Vec<_>>().join(" ")
}

/// An answer for people.
pub fn shown(answer: Option<&[u8]>) -> String {
    answer.map_or_else(|| "no answer".into(), hex)
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.event {
            Event::Octets(octets) => write!(f, "{:>9} | {:<44} | {}", self.gap, self.name, hex(octets)),
            other => write!(f, "{:>9} | {:<44} | {other:?}", self.gap, self.name),
        }
    }
}

impl<D: Driven> Line<D> {
    /// Both after power-up.
    pub fn new(slave: Slave<D>, model: Model<D::Process>) -> Self {
        Self { fault: None, slave, receiver: Receiver::new(BitTime(0)), model, naive: NaiveReceiver::new(), now: 0 }
    }

    /// Lets timers expire up to `now`.
    fn advance(&mut self, now: u64) {
        let mut last = None;
        while let Some(wake) = self.slave.wake_at().filter(|it| it.0 <= now) {
            assert_ne!(last, Some(wake), "the slave wants to wake at {wake:?} although it has been woken then");
            last = Some(wake);
            self.slave.device_mut().set_time(wake.0);
            self.slave.poll(wake);
        }
        self.slave.device_mut().set_time(now);
        self.model.expire(now);
    }

    /// Lets both do a step, and compares.
    pub fn step(&mut self, step: &Step) -> Outcome {
        self.now += step.gap;
        let mut answers = (None, None);
        let mut not_before = None;
        // open(1): the answer to a Set_Prm still comes after the old time.
        let min_tsdr = self.model.min_tsdr;
        match &step.event {
            Event::Octets(octets) => {
                for octet in octets {
                    self.now += CHARACTER;
                    let end = self.now;
                    let real = match self.receiver.octet(BitTime(end), *octet) {
                        Received::Telegram(telegram) => Some(telegram),
                        Received::Nothing | Received::Damaged(_) => None,
                    };
                    let naive = self.naive.character(end, *octet);
                    if real.is_none() {
                        self.slave.activity(BitTime(end));
                    }
                    if real.is_none() && naive.is_none() {
                        continue;
                    }
                    let mut last = None;
                    while let Some(wake) = self.slave.wake_at().filter(|it| it.0 <= end) {
                        assert_ne!(last, Some(wake), "the slave wants to wake at {wake:?} a second time");
                        last = Some(wake);
                        self.slave.device_mut().set_time(wake.0);
                        self.slave.poll(wake);
                    }
                    self.slave.device_mut().set_time(end);
                    // A timer that expired since the last telegram may have changed the device.
                    self.slave.device().show(&mut self.model.process);
                    self.model.expire(end);
                    if let Some(telegram) = real
                        && let Some(transmit) = self.slave.telegram(BitTime(end), &telegram)
                    {
                        not_before = Some(transmit.not_before.0 - end);
                        answers.0 = Some(transmit.octets.to_vec());
                    }
                    self.slave.device().show(&mut self.model.process);
                    answers.1 = naive.and_then(|frame| self.model.frame(end, &frame));
                }
                if let Some(answer) = &answers.0 {
                    let count = u64::try_from(answer.len()).expect("255 at most");
                    self.now += not_before.unwrap_or(0) + CHARACTER * count;
                    self.slave.sent(BitTime(self.now));
                }
            }
            other => {
                self.advance(self.now);
                match other {
                    Event::PowerUp => {
                        let address = self.slave.address();
                        self.slave.power_up(address);
                        self.model.power_up();
                    }
                    Event::RateFound => {
                        self.slave.rate_found(profivac_dp::link::Baud::B1500000);
                        self.model.rate_found();
                    }
                    Event::ReturnToWaitPrm => {
                        self.slave.return_to_wait_prm();
                        self.model.return_to_wait_prm();
                    }
                    Event::Diagnosis(diagnosis) => {
                        self.slave.device_mut().set_diagnosis(diagnosis.clone());
                        self.model.set_diagnosis(diagnosis.clone());
                    }
                    Event::Settle => {
                        self.slave.device_mut().settle();
                        self.slave.device().show(&mut self.model.process);
                        self.model.process.settle();
                    }
                    Event::Octets(_) => unreachable!(),
                }
            }
        }
        if let (Some(fault), Some(answer)) = (self.fault, &mut answers.0) {
            fault(answer);
        }
        let difference = self.difference(&answers, not_before, min_tsdr);
        Outcome { answer: answers.1, difference }
    }

    /// Answers and what the interface of the slave shows.
    fn difference(
        &self,
        answers: &(Option<Vec<u8>>, Option<Vec<u8>>),
        not_before: Option<u64>,
        min_tsdr: u8,
    ) -> Option<Difference> {
        let (slave, model) = (&self.slave, &self.model);
        if answers.0 != answers.1 {
            let (real, model) = (shown(answers.0.as_deref()), shown(answers.1.as_deref()));
            return Some(Difference(format!("the slave answers {real}\nthe model answers {model}")));
        }
        let states = match slave.state() {
            SlaveState::WaitPrm(_) => State::WaitPrm,
            SlaveState::WaitCfg(_) => State::WaitCfg,
            SlaveState::DataExch(..) => State::DataExch,
        };
        if states != model.state {
            return Some(Difference(format!("the slave is in {states:?}\nthe model is in {:?}", model.state)));
        }
        let values = [
            ("address", u64::from(slave.address()), u64::from(model.address)),
            ("min T_SDR", u64::from(slave.min_tsdr_tbit()), u64::from(model.min_tsdr)),
            ("watchdog", u64::from(slave.watchdog_is_running()), u64::from(model.watchdog.is_some())),
            ("start of the answer", not_before.unwrap_or(0), not_before.map_or(0, |_| u64::from(min_tsdr))),
        ];
        let (what, real, expected) = values.into_iter().find(|(_, real, expected)| real != expected)?;
        Some(Difference(format!("{what}: the slave has {real}\nthe model has {expected}")))
    }
}
