//! A device of a file that is like no built-in one: its blocks name behaviours of the library, and its tables say where they are.
//!
//! chosen: what no manual of the twelve says. The part that measures is the one with the lowest range in which its reading lies; a cathode
//! is controlled by the Pirani, if there is one; a command that the library does not know is accepted and does nothing. Of the conditions
//! of a command only those of emission and degas are checked, and all cathodes have the limits of the one with the highest range. From the
//! factory the selector is 1 and trip points are 0 and not enabled.

mod parameters;
mod simulation;
mod trip;

use crate::model::{
    AccessError, Clipping, Counts, Limits, Location, Model, Part, PartSpec, PressureFormat, Principle, RangeStatus,
    Role, Row, Scale, Unit,
};
use crate::profile::{
    BlockDevice, Cathode, CathodeConditions, CommonExceptions, DeviceRow, ExceptionDetails, InputRow, MeasuringPart,
    Presentation, ReadingCondition, SelfTestResult, SerialNumber, Setup, StateMachine, StatusExtension, Thresholds,
    TransitionCommand,
};
use crate::simulation::REPORT_CAPACITY;
use crate::store::Store;
use trip::{Trip, TripRow};

/// The most measuring parts of a described device.
pub const MAX_PARTS: usize = REPORT_CAPACITY;

/// The most trip points of a described device.
pub const MAX_TRIPS: usize = REPORT_CAPACITY;

/// What a block does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockBehaviour {
    /// The device block with the state machine of SEMI: identity, state, commands, exceptions.
    StateMachine,
    /// The value of a measuring part, its range and its safe state.
    AnalogInput,
    /// A Pirani: status, alarm, adjustments.
    Pirani,
    /// A diaphragm: status, alarm, adjustments.
    Diaphragm,
    /// A hot cathode: status, alarm, emission, degas.
    HotCathode,
    /// A cold cathode: status, alarm, high voltage.
    ColdCathode,
    /// A relay that closes below a pressure.
    TripPoint,
}

impl BlockBehaviour {
    /// The principle of the part that a transducer block belongs to.
    #[must_use]
    pub const fn principle(self) -> Option<Principle> {
        match self {
            Self::Pirani => Some(Principle::Pirani),
            Self::Diaphragm => Some(Principle::Diaphragm),
            Self::HotCathode => Some(Principle::HotCathode),
            Self::ColdCathode => Some(Principle::ColdCathode),
            Self::StateMachine | Self::AnalogInput | Self::TripPoint => None,
        }
    }
}

/// The tables of a device and the behaviour of its blocks.
#[derive(Debug)]
pub struct Description {
    /// The tables.
    pub model: &'static Model,
    /// The behaviour of each block of the tables, in their order.
    pub blocks: &'static [Option<BlockBehaviour>],
    /// The pressures at which its cathodes are switched.
    pub thresholds: &'static Thresholds,
}

/// A described device with its nonvolatile memory.
pub type Described<S> = BlockDevice<DescribedBehaviour, S>;

impl<S: Store> Described<S> {
    /// A device that has just been switched on.
    #[must_use]
    pub fn new(description: &'static Description, store: S, setup: Setup) -> Self {
        Self::from_behaviour(DescribedBehaviour::new(description, setup.serial), store, &setup)
    }
}

/// The entry of a place without a part, which nothing reads.
static NO_PART: PartSpec = PartSpec {
    part: Part { instance: 0, principle: Principle::Pirani },
    limits: Limits { under_pa: 1.0, over_pa: 2.0, full_scale_pa: 2.0 },
    clipping: Clipping::Never,
    counts: Counts::Linear { per_mbar: 1.0 },
};

/// The unit of a device without units, of which the loader makes none.
static NO_UNIT: Unit = Unit { code: 0, name: "mbar", alias: "hPa", scale: Scale::MBAR };

/// A measuring part and its cathode.
#[derive(Clone, Debug)]
struct Sensing {
    part: MeasuringPart,
    /// Only of a part with a cathode.
    cathode: Cathode,
    sensor_failed: bool,
    electronics_failed: bool,
}

impl Sensing {
    fn new(spec: &'static PartSpec, thresholds: &'static Thresholds) -> Self {
        Self {
            part: MeasuringPart::new(spec),
            cathode: Cathode::new(thresholds),
            sensor_failed: false,
            electronics_failed: false,
        }
    }

    const fn has_cathode(&self) -> bool {
        matches!(self.part.part().principle, Principle::HotCathode | Principle::ColdCathode)
    }

    /// Whether it measures the chamber.
    fn is_of_chamber(&self) -> bool {
        self.part.part().principle != Principle::Atmosphere
    }
}

/// The behaviour of a described device.
#[derive(Clone, Debug)]
pub struct DescribedBehaviour {
    description: &'static Description,
    serial: SerialNumber,
    machine: StateMachine,
    presentation: Presentation,
    selector: u8,
    sensing: [Sensing; MAX_PARTS],
    /// The parts of the tables, of which there are `count`.
    parts: [Part; MAX_PARTS],
    count: usize,
    /// Zero adjustment of each part, in Pa.
    offsets_pa: [f64; MAX_PARTS],
    trips: [Trip; MAX_TRIPS],
    /// The position of the part that measures.
    active: usize,
    condition: ReadingCondition,
    one_of_n: StatusExtension,
    eeprom: bool,
    ram: bool,
    eprom: bool,
    comm: bool,
    /// The cyclic transition command of the last cycle.
    command: TransitionCommand,
    /// Operating time in seconds.
    seconds: f64,
}

/// What a row is to this behaviour.
#[derive(Clone, Copy, Debug)]
enum Meaning {
    Device(DeviceRow),
    BlockType,
    Selector,
    PvSelector,
    /// Status of the whole gauge.
    OneOfN,
    /// Data Type or Data Units.
    Presentation(InputRow),
    /// A row of the analog input of the part at this position.
    Input(usize, InputRow),
    Status(usize),
    SensorAlarm(usize),
    Emission(usize),
    Degas(usize),
    Command(usize),
    Trip(usize, TripRow),
}

/// The unit of a new device. chosen: mbar, in which the built-in gauges are delivered, or else the first of the file.
fn delivered_unit(model: &'static Model) -> &'static Unit {
    let mbar = model.units.iter().find(|unit| unit.scale == Scale::MBAR);
    mbar.or_else(|| model.units.first()).unwrap_or(&NO_UNIT)
}

impl DescribedBehaviour {
    fn new(description: &'static Description, serial: SerialNumber) -> Self {
        let Description { model, thresholds, .. } = *description;
        let spec = |position: usize| model.parts.get(position).copied().unwrap_or(&NO_PART);
        let positions: [usize; MAX_PARTS] = core::array::from_fn(|position| position);
        Self {
            description,
            serial,
            machine: StateMachine::power_up(),
            presentation: Presentation::new(model, delivered_unit(model)),
            selector: 1,
            sensing: positions.map(|position| Sensing::new(spec(position), thresholds)),
            parts: positions.map(|position| spec(position).part),
            count: model.parts.len().min(MAX_PARTS),
            offsets_pa: [0.0; MAX_PARTS],
            trips: [Trip::NEW; MAX_TRIPS],
            active: 0,
            condition: ReadingCondition { executing: false, disturbed: false, alarmed: false },
            one_of_n: StatusExtension::INVALID,
            eeprom: false,
            ram: false,
            eprom: false,
            comm: false,
            command: TransitionCommand::NONE,
            seconds: 0.0,
        }
    }

    fn has(&self, behaviour: BlockBehaviour) -> bool {
        self.description.blocks.contains(&Some(behaviour))
    }

    /// Whether the device measures: without the state machine always.
    fn is_executing(&self) -> bool {
        !self.has(BlockBehaviour::StateMachine) || self.machine.is_executing()
    }

    fn sensing(&self) -> &[Sensing] {
        self.sensing.get(..self.count).unwrap_or_default()
    }

    fn sensing_mut(&mut self) -> &mut [Sensing] {
        self.sensing.get_mut(..self.count).unwrap_or_default()
    }

    /// The position of the part with this instance.
    fn position(&self, instance: u8) -> Option<usize> {
        self.sensing().iter().position(|it| it.part.part().instance == instance)
    }

    /// The position of the part of a location: that of its instance, or of its slot where the slot has no instances.
    fn part_at(&self, location: &Location) -> Option<usize> {
        let mut locations = self.description.model.blocks.iter().flat_map(|placed| placed.locations);
        match location.instance {
            0 if locations.any(|it| it.slot == location.slot && it.instance > 0) => None,
            0 => self.position(location.slot),
            instance => self.position(instance),
        }
    }

    /// The part that measures.
    fn active(&self) -> Option<&MeasuringPart> {
        self.sensing().get(self.active).map(|it| &it.part)
    }

    /// The number of the trip point at this location of a block.
    fn trip_at(&self, block: usize, location: &Location) -> Option<usize> {
        let all = self.description.model.blocks.iter().zip(self.description.blocks).enumerate();
        let trips = all.filter(|(_, (_, behaviour))| **behaviour == Some(BlockBehaviour::TripPoint));
        let mut places = trips.flat_map(|(at, (placed, _))| placed.locations.iter().map(move |it| (at, it)));
        places.position(|(at, it)| at == block && it.is_at(location)).filter(|number| *number < MAX_TRIPS)
    }

    /// What the row is; none for a row that only keeps what is written.
    fn meaning(&self, block: usize, location: &Location, row: &Row) -> Option<Meaning> {
        let behaviour = self.description.blocks.get(block).copied().flatten();
        // Most rows of a large file: they need no search for their part.
        if behaviour.is_none() && row.role.is_none() {
            return None;
        }
        let part = self.part_at(location);
        match row.role {
            Some(Role::InstanceSelector) => return Some(Meaning::Selector),
            Some(Role::PvSelector) => return Some(Meaning::PvSelector),
            Some(Role::BlockType) => return Some(Meaning::BlockType),
            Some(Role::Unit) => return Some(Meaning::Presentation(InputRow::DataUnits)),
            Some(Role::NumberType) => return Some(Meaning::Presentation(InputRow::DataType)),
            Some(Role::StatusExtension) if part.is_none() => return Some(Meaning::OneOfN),
            _ => {}
        }
        match behaviour? {
            BlockBehaviour::StateMachine => DeviceRow::from_index(row.index).map(Meaning::Device),
            BlockBehaviour::AnalogInput => Some(Meaning::Input(part?, InputRow::from_index(row.index)?)),
            BlockBehaviour::TripPoint => Some(Meaning::Trip(self.trip_at(block, location)?, TripRow::of(row)?)),
            BlockBehaviour::Pirani
            | BlockBehaviour::Diaphragm
            | BlockBehaviour::HotCathode
            | BlockBehaviour::ColdCathode => match row.role {
                Some(Role::StatusExtension) => Some(Meaning::Status(part?)),
                Some(Role::SensorAlarm) => Some(Meaning::SensorAlarm(part?)),
                Some(Role::EmissionStatus) => Some(Meaning::Emission(part?)),
                Some(Role::DegasStatus) => Some(Meaning::Degas(part?)),
                _ if row.codes.is_command() => Some(Meaning::Command(part?)),
                _ => None,
            },
        }
    }

    /// Memory faults, alike in both records.
    fn common(&self) -> CommonExceptions {
        CommonExceptions::from_memory_faults(self.eprom, self.eeprom, self.ram)
    }

    /// Exception Detail Alarm: two octets for each part, in the order of the tables.
    fn alarm(&self) -> ExceptionDetails<16> {
        let mut device = [0; 16];
        for (pair, it) in device.chunks_exact_mut(2).zip(self.sensing()) {
            pair.copy_from_slice(&it.part.sensor_alarm());
        }
        ExceptionDetails { common: self.common(), device, manufacturer: u8::from(self.comm) }
    }

    /// Exception Detail Warning: the status extension, then two octets for each part.
    fn warning(&self) -> ExceptionDetails<17> {
        let mut device = [0; 17];
        if let Some(first) = device.first_mut() {
            *first = self.one_of_n.bits();
        }
        ExceptionDetails { common: self.common(), device, manufacturer: u8::from(self.comm) }
    }

    fn self_test(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), self.alarm().is_any())
    }

    /// The format of the pressures of a part.
    fn format_of(&self, part: Option<&MeasuringPart>) -> PressureFormat {
        let counts = part.map_or(NO_PART.counts, |part| part.spec.counts);
        PressureFormat { max_integer: self.description.model.max_integer, ..self.presentation.format(counts) }
    }

    /// The conditions of the cathode of a part. The Pirani controls it; without one the part itself.
    fn conditions(&self, position: usize) -> CathodeConditions {
        let pirani = self.sensing().iter().find(|it| it.part.part().principle == Principle::Pirani);
        let own = self.sensing().get(position);
        let able = |it: Option<&Sensing>| it.is_none_or(|it| !it.part.failed);
        let indicated_pa = |it: &Sensing| it.part.sensor.indicated_pa();
        let control_pa = pirani.or(own).map_or(f64::INFINITY, indicated_pa);
        CathodeConditions {
            able: self.is_executing() && able(pirani) && able(own),
            control_pa,
            gauge_pa: self.active().and_then(|part| part.reading_pa).unwrap_or(control_pa),
        }
    }

    /// Updates failures, emission, readings, the part that measures, relays and validity, in this order.
    fn update_all(&mut self) {
        self.machine.detect(self.common());
        let offsets_pa = self.offsets_pa;
        for (it, offset_pa) in self.sensing_mut().iter_mut().zip(offsets_pa) {
            it.part.failed = it.sensor_failed || it.electronics_failed;
            it.part.sensor.offset_pa = offset_pa;
        }
        for position in 0..self.count {
            let conditions = self.conditions(position);
            let Some(it) = self.sensing.get_mut(position) else { continue };
            let has_cathode = it.has_cathode();
            if has_cathode {
                it.cathode.update_emission(&conditions);
            }
            let measures = !has_cathode || it.cathode.is_on();
            it.part.reading_pa = measures.then(|| it.part.sensor.indicated_pa());
        }
        self.select_active();
        let gauge_pa = self.active().and_then(|part| part.reading_pa);
        for it in self.sensing_mut() {
            it.cathode.update_current(gauge_pa.unwrap_or(f64::INFINITY));
        }
        let alarm = self.alarm();
        self.condition = ReadingCondition {
            executing: self.is_executing(),
            disturbed: alarm.is_any(),
            alarmed: !alarm.common.is_empty() || alarm.manufacturer != 0,
        };
        let condition = self.condition;
        self.one_of_n = self.active().map_or(StatusExtension::INVALID, |part| part.status_extension(&condition));
        self.update_trips();
        self.sensing_mut().iter_mut().for_each(|it| it.part.remember(&condition));
    }

    /// The part with the lowest range in which its reading lies; without one, that with the highest range.
    fn select_active(&mut self) {
        let chamber = || self.sensing().iter().enumerate().filter(|(_, it)| it.is_of_chamber());
        let end_pa = |it: &Sensing| it.part.spec.limits.over_pa;
        let within = chamber().filter(|(_, it)| it.part.reading_pa.is_some() && it.part.range() == RangeStatus::Within);
        let lowest = within.min_by(|(_, a), (_, b)| end_pa(a).total_cmp(&end_pa(b)));
        let found = lowest.or_else(|| chamber().max_by(|(_, a), (_, b)| end_pa(a).total_cmp(&end_pa(b))));
        self.active = found.map_or(0, |(position, _)| position);
    }

    fn update_trips(&mut self) {
        let readings: [(u8, Option<f64>); MAX_PARTS] =
            self.sensing.each_ref().map(|it| (it.part.part().instance, it.part.reading_pa));
        let active_pa = self.active().map(MeasuringPart::indicated_pa);
        let allowed = self.condition.executing && !self.condition.disturbed;
        for trip in &mut self.trips {
            let own = readings.iter().find(|(instance, _)| *instance == trip.source && trip.source > 0);
            trip.follow(allowed, own.map_or(active_pa, |(_, pa)| *pa));
        }
    }

    /// Executes a command of the block of a part, by its name in the tables.
    fn execute(&mut self, position: usize, name: &str) -> Result<(), AccessError> {
        let conditions = self.conditions(position);
        let Some(it) = self.sensing.get_mut(position) else { return Err(AccessError::UnknownIndex) };
        match name {
            "emission-on" => it.cathode.switch_on(&conditions)?,
            "emission-off" => it.cathode.switch_off(),
            "degas-on" => it.cathode.start_degas(&conditions)?,
            "degas-off" => it.cathode.stop_degas(),
            "manual-mode" => it.cathode.set_automatic(false),
            "automatic-mode" => it.cathode.set_automatic(true),
            "zero-adjust" => {
                let indicated_pa = it.part.sensor.indicated_pa();
                if let Some(offset_pa) = self.offsets_pa.get_mut(position) {
                    *offset_pa -= indicated_pa;
                }
            }
            "disable-offset" => {
                if let Some(offset_pa) = self.offsets_pa.get_mut(position) {
                    *offset_pa = 0.0;
                }
            }
            _ => {}
        }
        Ok(())
    }
}
