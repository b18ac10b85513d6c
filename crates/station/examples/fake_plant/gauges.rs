//! Gauges, and what each shows at every second: fields of constants and a shape. Ranges, measuring principles, Ident_Numbers and the
//! correction for a gas come from the tables of the devices.

use profivac_devices::Principle;
use profivac_devices::model::{Model, PartSpec};
use profivac_recorder::Quality;
use profivac_station::directory::{Directory, GaugeLabels, SavedView};
use profivac_station::segment::corrected;
use profivac_station::view::{BusStationState, Gauge, GaugeKind, PressureLevel, Reading};
use profivac_vacuum::Gas;
use profivac_virtual::device_spec::entry;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What a measuring part shows.
#[derive(Clone, Copy)]
pub struct Shown {
    /// In Pa.
    pub pa: Option<f64>,
    /// What it is worth.
    pub quality: Quality,
}

/// How a pressure goes. Seconds are counted from the start of the program; before it they are negative.
#[derive(Clone, Copy)]
enum Shape {
    /// Always the same.
    Still(f64),
    /// Around a pressure by a part of a decade, slowly.
    Drift { pa: f64, decades: f64, period: f64 },
    /// Pumped from atmosphere to a pressure, again after each period in seconds.
    Pumped { to: f64, period: f64 },
    /// The valve was closed for the ten minutes before the start: a leak and outgassing.
    Rise,
    /// A defect: nothing is measured.
    Invalid,
    /// A channel without a gauge.
    Absent,
    /// The port was lost five minutes before the start.
    Lost(f64),
}

/// A gauge.
pub struct Fake {
    /// Its name.
    pub name: &'static str,
    /// Its segment.
    pub segment: &'static str,
    /// Its address.
    pub address: u8,
    /// What it is.
    pub device: &'static str,
    /// What it is to the station.
    pub state: BusStationState,
    gas: Gas,
    levels: &'static [(&'static str, f64)],
    /// The pressure of each series: one for a gauge, one for each channel of a controller.
    shapes: &'static [Shape],
    /// The alarms that it reports, as the client names them.
    pub exceptions: &'static [&'static str],
    /// The reason why it does not measure.
    pub problem: Option<&'static str>,
    /// Seconds in which nothing was heard of it.
    gaps: &'static [(f64, f64)],
}

const HALL: Fake = Fake {
    name: "",
    segment: "hall",
    address: 0,
    device: "bcg450",
    state: BusStationState::DataExchange,
    gas: Gas::N2,
    levels: &[],
    shapes: &[],
    exceptions: &[],
    problem: None,
    gaps: &[],
};

const BEAM: Fake = Fake { segment: "beam line", ..HALL };

/// All of them, segment by segment; one more whose name is a script, if it is wanted.
pub fn all(hostile: bool) -> Vec<Fake> {
    let mut all = hall().into_iter().chain(beam()).collect::<Vec<_>>();
    all.push(Fake {
        name: "oven",
        segment: "bench",
        address: 4,
        device: "psg550",
        state: BusStationState::Missing,
        problem: Some("/dev/ttyUSB2: the port is lost"),
        shapes: &[Shape::Lost(8.7)],
        ..HALL
    });
    if hostile {
        let name = "<img src=x onerror=alert(1)>";
        all.push(Fake { name, address: 77, shapes: &[Shape::Still(1.0)], ..BEAM });
    }
    all
}

/// As [`all`], and 467 more on fourteen segments: 480 gauges. One of them has a fault, one is missing.
pub fn large() -> Vec<Fake> {
    let more = (0..467_u16).map(|number| {
        let (segment, address) = (3 + number / 34, u8::try_from(3 + number % 34).unwrap_or_default());
        let fake = Fake {
            name: format!("s{segment:02}-{address:02}").leak(),
            segment: format!("segment {segment:02}").leak(),
            address,
            shapes: &[Shape::Drift { pa: 3.1e-5, decades: 0.2, period: 900.0 }],
            ..HALL
        };
        match number {
            100 => Fake { state: BusStationState::Fault, exceptions: &["device alarm"], ..fake },
            300 => Fake { state: BusStationState::Missing, shapes: &[Shape::Lost(8.7)], ..fake },
            _ => fake,
        }
    });
    all(false).into_iter().chain(more).collect()
}

fn hall() -> [Fake; 6] {
    [
        Fake {
            name: "chamber",
            address: 5,
            gas: Gas::Ar,
            levels: &[("process", 1e-2), ("interlock", 10.0)],
            shapes: &[Shape::Pumped { to: 3.2e-5, period: 14_400.0 }],
            ..HALL
        },
        Fake {
            name: "load lock",
            address: 6,
            device: "pcg550",
            levels: &[("vented", 9e4)],
            shapes: &[Shape::Pumped { to: 8e-3, period: 5_400.0 }],
            ..HALL
        },
        Fake {
            name: "turbo outlet",
            address: 7,
            device: "psg550",
            gas: Gas::Ar,
            shapes: &[Shape::Still(2.34)],
            ..HALL
        },
        Fake {
            name: "ion pump",
            address: 8,
            device: "bpg400",
            levels: &[("valve may open", 1e-4)],
            shapes: &[Shape::Drift { pa: 4.6e-6, decades: 0.35, period: 50_000.0 }],
            ..HALL
        },
        Fake {
            name: "cryostat",
            address: 9,
            device: "bpg400",
            state: BusStationState::Fault,
            shapes: &[Shape::Invalid],
            exceptions: &["ionisation part: electronics or sensor failure"],
            ..HALL
        },
        Fake {
            name: "transfer",
            address: 11,
            device: "hpg400",
            shapes: &[Shape::Drift { pa: 6.1e-3, decades: 0.6, period: 9_000.0 }],
            ..HALL
        },
    ]
}

fn beam() -> [Fake; 6] {
    [
        Fake {
            name: "gate 1",
            address: 21,
            device: "bpg400",
            shapes: &[Shape::Drift { pa: 8.3e-5, decades: 0.25, period: 2_700.0 }],
            gaps: &[(-540.0, -330.0), (-3_000.0, -2_100.0), (-200_000.0, -150_000.0)],
            ..BEAM
        },
        Fake { name: "gate 2", address: 22, device: "bpg400", shapes: &[Shape::Still(1.05e5)], ..BEAM },
        Fake {
            name: "pump stand",
            address: 30,
            device: "tpg500",
            shapes: &[
                Shape::Still(4.1),
                Shape::Drift { pa: 2.2e-5, decades: 0.2, period: 7_000.0 },
                Shape::Still(10_130.0),
                Shape::Absent,
            ],
            ..BEAM
        },
        Fake {
            name: "detector",
            address: 31,
            gas: Gas::He,
            shapes: &[Shape::Drift { pa: 2.7e-7, decades: 0.1, period: 30_000.0 }],
            ..BEAM
        },
        Fake { name: "vessel", address: 33, device: "pcg550", shapes: &[Shape::Rise], ..BEAM },
        Fake { name: "spare", address: 40, device: "pcg550", state: BusStationState::Starting, ..BEAM },
    ]
}

/// Between -1 and 1, the same for the same second.
fn noise(second: f64) -> f64 {
    let wild = (second * 12.9898).sin() * 43_758.545;
    2.0 * (wild - wild.floor()) - 1.0
}

fn pressure(shape: Shape, second: f64) -> Option<f64> {
    let noisy = |pa: f64, part: f64| pa * (1.0 + part * noise(second));
    match shape {
        Shape::Still(pa) => Some(pa),
        Shape::Drift { pa, decades, period } => {
            let slow = (second * TAU / period).sin() + 0.2 * (second * TAU / (period / 7.3)).sin();
            Some(noisy(pa * 10_f64.powf(decades * slow), 0.01))
        }
        Shape::Pumped { to, period } => {
            // At the start two thirds of a period have passed since the valve was opened.
            let since = (second + 0.67 * period).rem_euclid(period);
            let (roughing, gas) = (101_300.0 * (-since / (0.006 * period)).exp(), 30.0 * to * (0.02 * period));
            let vented = (since - 0.94 * period).max(0.0) / (0.01 * period);
            Some(noisy((roughing + to + gas / (since + 1.0) + to * 10_f64.powf(vented * 3.0)).min(101_300.0), 0.01))
        }
        Shape::Rise => {
            let closed = if (-600.0..0.0).contains(&second) { second + 600.0 } else { 0.0 };
            Some(noisy(0.05 + 2.4e-3 * closed + 1.6 * (1.0 - (-closed / 70.0).exp()), 0.002))
        }
        Shape::Lost(pa) => (second < -300.0).then_some(pa),
        Shape::Invalid | Shape::Absent => None,
    }
}

/// The active part of a gauge at a pressure: the ion gauge as far as it reaches, then the diaphragm, then the Pirani. Beyond all ranges
/// the part whose end is shown. `None` for a controller that does not report its gauges.
fn active_part(model: &'static Model, pa: f64) -> Option<&'static PartSpec> {
    let order = [Principle::HotCathode, Principle::Diaphragm, Principle::Pirani];
    let parts = || model.parts.iter().copied().filter(|spec| order.contains(&spec.part.principle));
    let contains = |spec: &&PartSpec| (spec.limits.under_pa..=spec.limits.over_pa).contains(&pa);
    let within = order.iter().find_map(|it| parts().filter(contains).find(|spec| spec.part.principle == *it));
    let lowest = parts().min_by(|a, b| a.limits.under_pa.total_cmp(&b.limits.under_pa));
    let highest = parts().max_by(|a, b| a.limits.over_pa.total_cmp(&b.limits.over_pa));
    within.or_else(|| lowest.filter(|spec| pa < spec.limits.under_pa)).or(highest)
}

impl Fake {
    /// The tables of the device.
    #[allow(clippy::expect_used, reason = "the devices are constants, and a test looks at all of them")]
    pub fn model(&self) -> &'static Model {
        entry(self.device).expect("a device of the catalog").model
    }

    /// Every series with what it shows at a second.
    pub fn series(&self, second: f64) -> Vec<(Arc<str>, Shown)> {
        let alone = self.shapes.len() == 1;
        let named = |index: usize| if alone { self.name.to_owned() } else { format!("{}.{}", self.name, index + 1) };
        let shown = |(index, shape): (usize, &Shape)| (Arc::from(named(index)), self.shown(*shape, second));
        self.shapes.iter().enumerate().map(shown).collect()
    }

    fn shown(&self, shape: Shape, second: f64) -> Shown {
        let is_silent = self.gaps.iter().any(|(from, to)| (*from..*to).contains(&second));
        match (pressure(shape, second).filter(|_| !is_silent), shape) {
            (None, Shape::Invalid) => Shown { pa: None, quality: Quality::Fault },
            (None, Shape::Absent) => Shown { pa: None, quality: Quality::Missing },
            (None, _) => Shown { pa: None, quality: Quality::Stale },
            (Some(pa), _) => self.measured(pa),
        }
    }

    /// A pressure as the device shows it: the number, or the end of its range.
    fn measured(&self, pa: f64) -> Shown {
        let limits = active_part(self.model(), pa).map(|spec| &spec.limits);
        match limits {
            Some(limits) if pa > limits.over_pa => Shown { pa: Some(limits.over_pa), quality: Quality::Overrange },
            Some(limits) if pa < limits.under_pa => Shown { pa: Some(limits.under_pa), quality: Quality::Underrange },
            _ => Shown { pa: Some(pa), quality: Quality::Valid },
        }
    }

    /// What the dashboard shows of it; the pressure that it was told, if it was told one.
    pub fn view(&self, second: f64, told: Option<f64>) -> Gauge {
        let told = |shown: Shown| told.map_or(shown, |pa| self.measured(pa));
        let readings = self.series(second).into_iter().enumerate();
        let age_ms = match self.state {
            BusStationState::Starting => None,
            BusStationState::Missing => Some(((second + 300.0) * 1e3) as u64),
            _ => Some(12),
        };
        Gauge {
            name: self.name.to_owned(),
            kind: GaugeKind::Gauge,
            segment: self.segment.to_owned(),
            address: self.address,
            device: self.device.to_owned(),
            model: Some(self.model()),
            has_dpv1: self.model().features.dpv1,
            state: self.state,
            problem: self.problem.map(str::to_owned),
            exceptions: self.exceptions.iter().map(|&words| words.to_owned()).collect(),
            gas: self.gas.to_string(),
            levels: self.levels.iter().map(|(name, pa)| PressureLevel { name: (*name).to_owned(), pa: *pa }).collect(),
            readings: readings.map(|(index, (series, shown))| self.reading(index, &series, told(shown))).collect(),
            age_ms,
            poll_ms: 200,
            stale_after_ms: 3000,
            ..Gauge::default()
        }
    }

    fn reading(&self, index: usize, series: &str, shown: Shown) -> Reading {
        let part = active_part(self.model(), shown.pa.unwrap_or_default()).map(|spec| spec.part);
        let pa = shown.pa.filter(|_| shown.quality == Quality::Valid);
        Reading {
            series: series.to_owned(),
            instance: part.map_or_else(|| u8::try_from(index + 1).unwrap_or(u8::MAX), |part| part.instance),
            principle: part.map(|part| part.principle),
            pa,
            limit_pa: shown.pa.filter(|_| shown.quality != Quality::Valid),
            corrected_pa: pa.zip(part).and_then(|(pa, part)| corrected(pa, part.principle, self.gas)),
            quality: shown.quality,
            cause: (shown.quality == Quality::Fault).then(|| "device alarm".to_owned()),
            is_defect: shown.quality == Quality::Fault,
        }
    }
}

/// The labels of the gauges: those of the hall, and a group, a tag and a place for each of the many gauges of [`large`].
pub fn directory(fakes: &[Fake]) -> Directory {
    let day = |day: &str| Some(day.to_owned());
    let labels = |fake: &Fake| {
        let (group, location) = match fake.segment {
            "hall" => ("target hall", "hall, platform"),
            "beam line" => ("beam line", "tunnel"),
            "bench" => ("laboratory", "room 12"),
            segment if segment.ends_with(['0', '2', '4', '6', '8']) => ("ring, inside", segment),
            segment => ("ring, outside", segment),
        };
        let tags = if fake.address.is_multiple_of(3) { vec!["bake-out".to_owned()] } else { Vec::new() };
        // The days are so far away that no test depends on its date.
        let calibration_due = if fake.name == "oven" { day("2021-03-01") } else { day("2121-03-01") };
        GaugeLabels {
            group: Some(group.to_owned()),
            tags,
            location: Some(location.to_owned()),
            calibrated: day("2020-03-01"),
            calibration_due,
        }
    };
    let view = |name: &str, group: Option<&str>, series: &[&str]| SavedView {
        name: name.to_owned(),
        search: None,
        group: group.map(str::to_owned),
        tag: None,
        location: None,
        state: None,
        series: series.iter().map(|&series| series.to_owned()).collect(),
    };
    Directory {
        gauges: fakes.iter().map(|fake| (fake.name.to_owned(), labels(fake))).collect(),
        views: vec![view("Tunnel", Some("beam line"), &[]), view("Pump stand", None, &["vessel", "pump stand"])],
        ..Directory::default()
    }
}
