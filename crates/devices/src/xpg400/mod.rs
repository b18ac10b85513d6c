//! BPG400-SP and HPG400-SP: a Pirani with a Bayard-Alpert or a High Pressure ionisation gauge. tira36e1.
//!
//! [`table`] has the manual's tables, [`parts`] the ranges, [`codes`] the code tables. `adjust` has the full scale adjustment of
//! the Pirani, `parameters` reads and writes every row, `simulation` has cyclic data and front panel. Numbers in
//! brackets are those of errata-bpg-bcg-tpg.

mod adjust;
pub mod codes;
mod faults;
mod parameters;
pub mod parts;
mod simulation;
pub mod table;

use crate::model::{AccessError, DESCRIBED, Model};
use crate::profile::{
    BlockDevice, Cathode, CathodeConditions, CommonExceptions, DeviceBlockValues, ExceptionDetails, ExceptionStatus,
    MeasuringPart, Presentation, ReadingCondition, RelaySetPoint, SelfTestResult, SerialNumber, Setup, StateMachine,
    StatusExtension,
};
use crate::store::Store;
use faults::Faults;
use parts::Switchover;
use table::Variant;

/// A BPG400-SP or HPG400-SP with its nonvolatile memory.
pub type Xpg400<S> = BlockDevice<Xpg400Behaviour, S>;

impl<S: Store> Xpg400<S> {
    /// A gauge that has just been switched on.
    #[must_use]
    pub fn new(store: S, model: Xpg400Model, setup: Setup) -> Self {
        Self::with_model(&model.variant().model, model, store, setup)
    }

    /// The same for a gauge whose tables a device file has, like those of one of the two.
    #[must_use]
    pub fn with_model(tables: &'static Model, model: Xpg400Model, store: S, setup: Setup) -> Self {
        Self::from_behaviour(Xpg400Behaviour::new(tables, model, setup.serial), store, &setup)
    }
}

/// One of the two gauges.
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

    /// The pressure at which one part takes over from the other; on the HPG400-SP that of the switch LOW-HIGH (66).
    const fn switchover(self, low_high: u8) -> &'static Switchover {
        match self {
            Self::Bpg => &parts::BPG_SWITCHOVER,
            Self::Hpg => parts::hpg_switchover(low_high),
        }
    }
}

/// The behaviour of the two gauges.
#[derive(Clone, Debug)]
pub struct Xpg400Behaviour {
    model: Xpg400Model,
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
    set_points: [RelaySetPoint; 2],
    side: SideSwitches,
    /// The rest of the time of the full scale adjustment.
    adjusting_s: f64,
    faults: Faults,
    /// The conditions that all readings depend on.
    condition: ReadingCondition,
    /// One Of N Status Extension: the range of the whole gauge, and whether its value is valid (57, 58).
    one_of_n: StatusExtension,
    /// Operating time in seconds.
    seconds: f64,
}

/// The positions of the rotary switches on the side of the HPG400-SP, 0 to 9. The BPG400-SP has none and keeps these.
#[derive(Clone, Copy, Debug)]
struct SideSwitches {
    /// LOW-HIGH: the switchover.
    low_high: u8,
    /// CAL ADJ: the sensitivity (3.1.1.14).
    cal_adj: u8,
}

impl SideSwitches {
    /// 0 for LOW-HIGH (82). chosen: 0 for CAL ADJ too.
    const FACTORY: Self = Self { low_high: 0, cal_adj: 0 };

    /// The factor of CAL ADJ for the reading of the ionisation part.
    ///
    /// chosen: the manual gives no factors. As delivered it is 1; each position one way raises it by 5 %, as far
    /// as 5, and each position the other way, from 9 down to 6, lowers it by 5 %.
    fn gain(&self) -> f64 {
        let steps = if self.cal_adj <= 5 { f64::from(self.cal_adj) } else { f64::from(self.cal_adj) - 10.0 };
        1.0 + 0.05 * steps
    }
}

impl Xpg400Behaviour {
    fn new(tables: &'static Model, model: Xpg400Model, serial: SerialNumber) -> Self {
        let variant = model.variant();
        Self {
            model,
            serial,
            machine: StateMachine::power_up(),
            presentation: Presentation::new(tables, table::FACTORY_UNIT),
            selector: 1,
            pirani: MeasuringPart::new(tables.part_like(variant.pirani)),
            ion: MeasuringPart::new(tables.part_like(variant.ion)),
            ion_is_active: false,
            cathode: Cathode::new(&model.switchover(SideSwitches::FACTORY.low_high).emission),
            set_points: [RelaySetPoint::new(variant.potentiometer), RelaySetPoint::new(variant.potentiometer)],
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

    /// The set point with this instance: 3 or 4, unless a device file has others.
    fn set_point(&self, instance: u8) -> Option<&RelaySetPoint> {
        let number = if DESCRIBED {
            self.presentation.model.number_in_block(table::SET_POINT_BLOCK, instance)
        } else {
            instance.checked_sub(table::SETPOINT_A.instance).map(usize::from)
        };
        self.set_points.get(number?)
    }

    /// The pressure at which one part takes over from the other.
    const fn switchover(&self) -> &'static Switchover {
        self.model.switchover(self.side.low_high)
    }

    /// Executes a Device Block State Command. Reset sets the volatile values to those after power-up.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        if self.machine.command(number)? {
            self.cathode = Cathode::new(&self.switchover().emission);
        }
        Ok(())
    }

    /// The result that a self test would have.
    fn self_test(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), self.exception_status().intersects(ExceptionStatus::ALARM))
    }

    /// Memory faults, alike in both records (48, 49).
    fn common(&self) -> CommonExceptions {
        CommonExceptions::from_memory_faults(self.faults.eprom, self.faults.eeprom, self.faults.ram)
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

    /// Exception Detail Warning without the status extension: the warnings of defects (54). Memory and internal
    /// communication as in the alarm (49).
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

    /// Alarms make every reading invalid, and so do the warnings of defects (54).
    fn update_validity(&mut self) {
        let alarm = self.alarm();
        self.condition = ReadingCondition {
            executing: self.machine.is_executing(),
            disturbed: alarm.is_any() || self.defects().is_any(),
            alarmed: !alarm.common.is_empty() || alarm.manufacturer != 0,
        };
        let range = self.model.variant().range.status_of(self.active().indicated_pa());
        self.one_of_n = StatusExtension::new(range, self.active().is_valid(&self.condition));
    }

    /// The conditions of the cathode; the Pirani is its controlling part.
    fn conditions(&self) -> CathodeConditions {
        CathodeConditions {
            able: self.machine.is_executing() && !self.pirani.failed && !self.ion.failed,
            control_pa: self.pirani.sensor.indicated_pa(),
            gauge_pa: self.active().indicated_pa(),
        }
    }

    /// Updates device state, adjustment, emission, readings, relays, validity and last valid values, in this order.
    fn update_all(&mut self) {
        self.machine.detect(self.common());
        self.pirani.failed = self.faults.sensor_1 || self.faults.electronics_1;
        self.ion.failed = self.faults.sensor_2 || self.faults.electronics_2;
        self.check_adjustment();
        self.ion.sensor.gain = self.side.gain();
        self.cathode.set_thresholds(&self.switchover().emission);
        self.cathode.update_emission(&self.conditions());
        self.measure();
        self.update_set_points();
        self.update_validity();
        self.pirani.remember(&self.condition);
        self.ion.remember(&self.condition);
    }

    /// Sets the reading of each part and the active part; without emission the Pirani measures (80). When the gauge
    /// leaves EXECUTING the PV Selector stays, because the Safe State and the last valid value in the cyclic data are
    /// those of the part that measured last. 3.2.1.4, 3.2.2.7, (74).
    fn measure(&mut self) {
        let pirani_pa = self.pirani.sensor.indicated_pa();
        self.pirani.reading_pa = Some(pirani_pa);
        self.ion.reading_pa = self.cathode.is_on().then(|| self.ion.sensor.indicated_pa());
        if self.machine.is_executing() {
            self.ion_is_active = self.cathode.is_on() && pirani_pa < self.switchover().pa;
        }
        self.cathode.update_current(self.active().indicated_pa());
    }

    /// chosen: as on the BCG450-SP, only in EXECUTING and not with any sensor alarm (112).
    fn update_set_points(&mut self) {
        let allowed = self.machine.is_executing() && !self.pirani.failed && !self.ion.failed;
        let pa = self.active().indicated_pa();
        self.set_points.iter_mut().for_each(|point| point.follow(allowed, pa));
    }
}
