//! BPG400-SP and HPG400-SP: a Pirani with a Bayard-Alpert or a High Pressure ionisation gauge. tira36e1.
//!
//! [`table`] is the manual's tables; the rest is what they do: `adjust` moves the Pirani, CAL ADJ the ionisation part, `parameters` leads every row to its
//! value, `bench` has bus and people. Numbers in brackets are those of errata-bpg-bcg-tpg.

mod adjust;
mod codes;
mod parameters;
mod simulation;
pub mod table;

use crate::model::AccessError;
use crate::profile::{
    BlockDevice, Cathode, CathodeConditions, CommonExceptions, ExceptionDetails, ExceptionStatus, MeasuringPart,
    Presentation, ReadingCondition, SelfTestResult, SerialNumber, SetPoint, Setup, StateMachine, StatusExtension,
    exception_status,
};
use crate::store::Store;
use simulation::Faults;
use table::{Switchover, Variant};

/// A BPG400-SP or HPG400-SP with its nonvolatile memory.
pub type Xpg400<S> = BlockDevice<Xpg400Behaviour, S>;

impl<S: Store> Xpg400<S> {
    /// A gauge that has just been switched on.
    #[must_use]
    pub fn new(store: S, kind: Xpg400Model, setup: Setup) -> Self {
        Self::from_behaviour(Xpg400Behaviour::new(kind, setup.serial), store, &setup)
    }
}

/// Which of the two gauges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Xpg400Model {
    /// BPG400-SP.
    Bpg,
    /// HPG400-SP.
    Hpg,
}

impl Xpg400Model {
    /// Its tables.
    #[must_use]
    pub const fn variant(self) -> &'static Variant {
        match self {
            Self::Bpg => &table::BPG400,
            Self::Hpg => &table::HPG400,
        }
    }

    /// Where its parts take over from each other; on the HPG400-SP as LOW-HIGH says (66).
    const fn switchover(self, low_high: u8) -> &'static Switchover {
        match self {
            Self::Bpg => &table::BPG_SWITCHOVER,
            Self::Hpg => table::hpg_switchover(low_high),
        }
    }
}

/// What is particular to the two gauges.
#[derive(Clone, Debug)]
pub struct Xpg400Behaviour {
    kind: Xpg400Model,
    serial: SerialNumber,
    machine: StateMachine,
    presentation: Presentation,
    /// Channel Instance Selector.
    selector: u8,
    pirani: MeasuringPart,
    ion: MeasuringPart,
    /// The ionisation part measures, not the Pirani.
    ion_is_active: bool,
    cathode: Cathode,
    set_points: [SetPoint; 2],
    side: SideSwitches,
    /// What is left of the full scale adjustment.
    adjusting_s: f64,
    faults: Faults,
    /// What concerns all readings.
    condition: ReadingCondition,
    /// One Of N Status Extension: the range of the whole gauge, and whether its value is valid (57, 58).
    one_of_n: StatusExtension,
    seconds: f64,
}

/// The positions of the rotary switches on the side of the HPG400-SP, 0 to 9; on the BPG400-SP they stay where they are.
#[derive(Clone, Copy, Debug)]
struct SideSwitches {
    /// LOW-HIGH: the switchover.
    low_high: u8,
    /// CAL ADJ: the sensitivity (3.1.1.14).
    cal_adj: u8,
}

impl SideSwitches {
    /// 0 for LOW-HIGH (82). free choice: 0 for CAL ADJ too.
    const FACTORY: Self = Self { low_high: 0, cal_adj: 0 };

    /// What CAL ADJ multiplies the reading of the ionisation part by.
    ///
    /// free choice: the manual gives no factors. As delivered it is 1; each position one way raises it by 5 %, as far as 5,
    /// and each position the other way, from 9 down to 6, lowers it by 5 %.
    fn gain(&self) -> f64 {
        let steps = if self.cal_adj <= 5 { f64::from(self.cal_adj) } else { f64::from(self.cal_adj) - 10.0 };
        1.0 + 0.05 * steps
    }
}

impl Xpg400Behaviour {
    fn new(kind: Xpg400Model, serial: SerialNumber) -> Self {
        let version = kind.variant();
        Self {
            kind,
            serial,
            machine: StateMachine::power_up(),
            presentation: Presentation::new(table::FACTORY_UNIT),
            selector: 1,
            pirani: MeasuringPart::new(version.pirani),
            ion: MeasuringPart::new(version.ion),
            ion_is_active: false,
            cathode: Cathode::new(&kind.switchover(SideSwitches::FACTORY.low_high).emission),
            set_points: [SetPoint::new(version.potentiometer), SetPoint::new(version.potentiometer)],
            side: SideSwitches::FACTORY,
            adjusting_s: 0.0,
            faults: Faults::NONE,
            condition: ReadingCondition { executing: false, disturbed: false, alarmed: false },
            one_of_n: StatusExtension::INVALID,
            seconds: 0.0,
        }
    }

    /// The measuring part with this instance.
    const fn part(&self, instance: u8) -> Option<&MeasuringPart> {
        match instance {
            1 => Some(&self.pirani),
            2 => Some(&self.ion),
            _ => None,
        }
    }

    const fn part_mut(&mut self, instance: u8) -> Option<&mut MeasuringPart> {
        match instance {
            1 => Some(&mut self.pirani),
            2 => Some(&mut self.ion),
            _ => None,
        }
    }

    /// The part that measures: its instance is the PV Selector.
    const fn active(&self) -> &MeasuringPart {
        if self.ion_is_active { &self.ion } else { &self.pirani }
    }

    /// Instances 3 and 4.
    fn set_point(&self, instance: u8) -> Option<&SetPoint> {
        self.set_points.get(usize::from(instance).checked_sub(3)?)
    }

    /// Where the parts take over from each other.
    const fn switchover(&self) -> &'static Switchover {
        self.kind.switchover(self.side.low_high)
    }

    /// A Device Block State Command. Reset brings the volatile values back to what they are after power-up.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        if self.machine.command(number)? {
            self.cathode = Cathode::new(&self.switchover().emission);
        }
        Ok(())
    }

    /// What the self test would find.
    fn health(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), self.exception_status().intersects(ExceptionStatus::ALARM))
    }

    /// Memory faults, alike in both records (48, 49).
    fn common(&self) -> CommonExceptions {
        CommonExceptions::of_memories(self.faults.eprom, self.faults.eeprom, self.faults.ram)
    }

    /// Exception Detail Alarm: Pirani, ionisation (46).
    fn alarm(&self) -> ExceptionDetails<4> {
        let [p0, p1] = self.pirani.sensor_alarm();
        let [i0, i1] = self.ion.sensor_alarm();
        ExceptionDetails { common: self.common(), device: [p0, p1, i0, i1], manufacturer: self.faults.comm.into() }
    }

    /// Exception Detail Warning: the status extension, then Pirani, ionisation.
    fn warning(&self) -> ExceptionDetails<5> {
        let mut warning = self.defects();
        let [extension, ..] = &mut warning.device;
        *extension = self.one_of_n.bits();
        warning
    }

    /// The same without the status extension: what warns of a defect (54). Memory and internal communication as in the alarm
    /// (49).
    fn defects(&self) -> ExceptionDetails<5> {
        let [p0, p1] = self.pirani_warning();
        let [i0, i1] = Self::ION_WARNING;
        ExceptionDetails { common: self.common(), device: [0, p0, p1, i0, i1], manufacturer: self.faults.comm.into() }
    }

    /// Sensor Warning of the Pirani: badly adjusted (105).
    fn pirani_warning(&self) -> [u8; 2] {
        [0, u8::from(self.faults.pirani_adjust) << 1]
    }

    /// Sensor Warning of the ionisation part: the manual has a bit and no condition for it (3.3.3.4).
    const ION_WARNING: [u8; 2] = [0; 2];

    fn exception_status(&self) -> ExceptionStatus {
        exception_status(&self.alarm(), &self.warning())
    }

    /// Alarms make every reading invalid, and so do the warnings of defects (54).
    fn judge(&mut self) {
        let alarm = self.alarm();
        self.condition = ReadingCondition {
            executing: self.machine.is_executing(),
            disturbed: alarm.is_any() || self.defects().is_any(),
            alarmed: !alarm.common.is_empty() || alarm.manufacturer != 0,
        };
        let range = self.kind.variant().range.status_of(self.active().indicated_pa());
        self.one_of_n = StatusExtension::new(range, self.active().is_valid(&self.condition));
    }

    /// What the cathode depends on; the Pirani controls it.
    fn conditions(&self) -> CathodeConditions {
        CathodeConditions {
            able: self.machine.is_executing() && !self.pirani.failed && !self.ion.failed,
            control_pa: self.pirani.sensor.indicated_pa(),
            gauge_pa: self.active().indicated_pa(),
        }
    }

    /// Everything that follows at once: adjustment, emission, readings, relays, validity, last valid values.
    fn follow(&mut self) {
        self.pirani.failed = self.faults.sensor_1 || self.faults.electronics_1;
        self.ion.failed = self.faults.sensor_2 || self.faults.electronics_2;
        self.follow_adjustment();
        self.ion.sensor.gain = self.side.gain();
        self.cathode.set_thresholds(&self.switchover().emission);
        self.cathode.switch(&self.conditions());
        self.measure();
        self.follow_set_points();
        self.judge();
        self.pirani.remember(&self.condition);
        self.ion.remember(&self.condition);
    }

    /// Each part reads for itself; without emission the Pirani measures (80). When the gauge stops measuring the PV Selector
    /// stays: the Safe State, and above all the last valid value, is that of the part whose place it takes in the cyclic
    /// data. 3.2.1.4, 3.2.2.7, (74).
    fn measure(&mut self) {
        let pirani_pa = self.pirani.sensor.indicated_pa();
        self.pirani.reading_pa = Some(pirani_pa);
        self.ion.reading_pa = self.cathode.is_on().then(|| self.ion.sensor.indicated_pa());
        if self.machine.is_executing() {
            self.ion_is_active = self.cathode.is_on() && pirani_pa < self.switchover().pa;
        }
        self.cathode.follow(self.active().indicated_pa());
    }

    /// free choice: as on the sister gauge, only in EXECUTING and not with any sensor alarm (112).
    fn follow_set_points(&mut self) {
        let allowed = self.machine.is_executing() && !self.pirani.failed && !self.ion.failed;
        let pa = self.active().indicated_pa();
        self.set_points.iter_mut().for_each(|point| point.follow(allowed, pa));
    }
}
