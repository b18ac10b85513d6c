//! A station without a bus: the API and the dashboard over synthetic snapshots and a synthetic recording, the same in every run.
//!
//! ```text
//! cargo run -p profivac-station --example fake_plant -- 127.0.0.1:8080
//! ```
//!
//! For work on the dashboard and for its tests in a browser: three segments, thirteen gauges, a recording of a week. Everything is a
//! function of the seconds since the start, except that a line `vessel=1e5` on the standard input sets the pressure of that gauge in
//! Pa. The program ends when its input ends. Further arguments: `hostile` adds a gauge whose name is a script. `large` has 480 gauges.
//! `pumped` records twelve pump-downs of the series `transfer lock`, a plant to be identified as `test chamber`, and helium at the leak of
//! `leaking chamber`. `viewer` makes every client a viewer instead of an engineer. `users` requires a login as ada (engineer), olga
//! (operator) or vera (viewer), all with the password `tin whisker plateau`; the path of their file is printed as well.

#[path = "fake_plant/alarms.rs"]
mod alarms;
#[path = "fake_plant/blocks.rs"]
mod blocks;
#[path = "fake_plant/gauges.rs"]
mod gauges;
#[path = "fake_plant/segments.rs"]
mod segments;

use gauges::{Fake, Shown};
use profivac_recorder::{Event, EventKind, Micros, Quality, Recorder, Sample, Settings};
use profivac_station::alarm::AlarmThread;
use profivac_station::control::OperationError;
use profivac_station::control::error::Unavailable;
use profivac_station::control::requests::SegmentRequest;
use profivac_station::services::Services;
use profivac_station::snapshot::SegmentSnapshot;
use profivac_station::webhook::{DeliverySettings, DeliveryThread};
use profivac_web_server::auth::password::Hash;
use profivac_web_server::auth::users::Users;
use profivac_web_server::auth::{Access, Role};
use profivac_web_server::server::Setup;
use std::collections::HashMap;
use std::error::Error;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// The time between two snapshots.
const PERIOD: Duration = Duration::from_millis(100);

/// Recorded samples: the age of the first one in seconds, and the seconds between two.
const PAST: [(i64, i64); 3] = [(7 * 86_400, 120), (86_400, 20), (1_800, 1)];

/// The number of samples between two flushes; the queue of the recorder holds more.
const BATCH: u64 = 20_000;

/// The number of gauges with a past.
const USUAL: usize = 14;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let address: SocketAddr = arguments.next().unwrap_or_else(|| "127.0.0.1:0".to_owned()).parse()?;
    let more: Vec<String> = arguments.collect();
    let said = |word: &str| more.iter().any(|argument| argument == word);
    let fakes = if said("large") { gauges::large() } else { gauges::all(said("hostile")) };
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("fake.db");
    let recorder = Recorder::start(&file, Settings::default())?;
    let services = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
    let start = Micros::now();
    // A week of 480 gauges would take minutes.
    record_past(&services, fakes.get(..USUAL).unwrap_or(&fakes), start);
    if said("pumped") {
        record_pump_downs(&services, start);
        record_plant(&services, start);
        record_helium(&services, start);
    }
    services.directory().set(gauges::directory(&fakes));
    show(&services, &fakes, 0.0, &Told::default());
    for segment in ["beam line", "hall"] {
        answer(&services, &fakes, segment);
    }
    let emails = alarms::start(&services, &fakes, folder.path())?;
    let deliver = |email| {
        let (recorder, status) = (Arc::clone(services.recorder()), Arc::clone(services.webhooks()));
        DeliveryThread::start(email, recorder, status, DeliverySettings::default())
    };
    let _deliveries = emails.into_iter().map(deliver).collect::<Result<Vec<_>, _>>()?;
    services.recorder().event_now_and_wait(None, EventKind::Station, "the station starts");
    let (snapshots, recorder) = (Arc::clone(services.snapshots()), Arc::clone(services.recorder()));
    let _alarm_thread =
        AlarmThread::start(Arc::clone(services.alarms()), snapshots, recorder, Arc::clone(services.gateways()))?;
    let users = folder.path().join("users.toml");
    let access = match (said("users"), said("viewer")) {
        (true, _) => with_users(&users)?,
        (_, true) => Access::anonymous_viewer(),
        _ => Access::anonymous("demo", Role::Engineer),
    };
    let server = profivac_station::server::start(Arc::clone(&services), Setup::new(address, access))?;
    println!("{}", server.url());
    println!("{}", users.display());
    let told = Arc::new(Mutex::new(HashMap::new()));
    let heard = Arc::clone(&told);
    std::thread::spawn(move || live(&services, &fakes, start, &heard));
    // The input ends when the parent process ends.
    for line in std::io::stdin().lines() {
        if let Some((name, pa)) = line?.split_once('=') {
            told.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), pa.parse()?);
        }
    }
    Ok(())
}

/// The pressures that were set on the standard input, by gauge.
type Told = Mutex<HashMap<String, f64>>;

fn with_users(file: &Path) -> Result<Access, Box<dyn Error>> {
    let hash = Hash::of("tin whisker plateau")?;
    Users::change(file, |users| {
        users.add("ada", Role::Engineer, hash.clone())?;
        users.add("olga", Role::Operator, hash.clone())?;
        users.add("vera", Role::Viewer, hash)
    })?;
    Ok(Access::Users(file.to_owned()))
}

/// Records the week before the start.
fn record_past(services: &Services, fakes: &[Fake], start: Micros) {
    let mut pushed = 0_u64;
    for fake in fakes {
        let until = PAST.iter().skip(1).map(|(from, _)| -from).chain([0]);
        for ((from, step), until) in PAST.into_iter().zip(until) {
            for second in (-from..until).step_by(usize::try_from(step).unwrap_or(1)) {
                record(services, fake, start, second as f64);
                pushed += 1;
                if pushed.is_multiple_of(BATCH) {
                    let _written = services.recorder().flush();
                }
            }
        }
    }
    for (second, gauge, kind, text) in segments::EVENTS {
        let at = moment(start, second);
        let _written = services.recorder().record_event_and_wait(Event {
            at,
            gauge: gauge.map(str::to_owned),
            kind: kind.into(),
            text: text.to_owned(),
        });
    }
}

/// Records twelve pump-downs of a series without a gauge, one a day; the last two have twice the outgassing.
fn record_pump_downs(services: &Services, start: Micros) {
    let series = Arc::from("transfer lock");
    for day in 0..12 {
        let begun = -(12 - day) * 86_400;
        let outgassing = if day < 10 { 0.36 } else { 0.72 };
        for second in -30..0 {
            let sample = Sample::new(moment(start, f64::from(begun + second)), Some(1e5), Quality::Valid);
            services.recorder().push(&series, sample);
        }
        let mut second = 0;
        while second < 14_400 {
            let s = f64::from(second);
            let pa = 1e5 * (-s / 20.0).exp() + outgassing / (s + 1.0) + 1e-6;
            let sample = Sample::new(moment(start, f64::from(begun) + s), Some(pa), Quality::Valid);
            services.recorder().push(&series, sample);
            second += 1.max(second / 100);
        }
        let _written = services.recorder().flush();
    }
}

/// Records two hours of pumping 50 l with 20 l/s and twenty minutes with the valve closed, three hours ago. The leak is 2e-7, the
/// outgassing after an hour 2e-6 Pa m³/s.
fn record_plant(services: &Services, start: Micros) {
    let series = Arc::from("test chamber");
    let mut random = fastrand::Rng::with_seed(4);
    let mut pa = 100.0;
    for second in 0..8_400 {
        let noise: f64 = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let shown = pa * (1.0 + 0.01 * noise);
        let sample = Sample::new(moment(start, f64::from(second - 10_800)), Some(shown), Quality::Valid);
        services.recorder().push(&series, sample);
        for part in 0..100 {
            let now = f64::from(second) + f64::from(part) / 100.0;
            let pumped = if now < 7_200.0 { 0.02 * pa } else { 0.0 };
            pa += (2e-7 + 2e-6 * 3_600.0 / (now + 5.0) - pumped) / 0.05 / 100.0;
        }
    }
    let _written = services.recorder().flush();
}

/// Records two hours of pumping, five hours ago, with helium in place of the air of a leak for a minute, 100 minutes after its beginning.
fn record_helium(services: &Services, start: Micros) {
    let series = Arc::from("leaking chamber");
    let mut random = fastrand::Rng::with_seed(3);
    let filled = |s: f64| 1.0 - (-s.max(0.0) / 10.0).exp();
    for second in -20..7_200 {
        let t = f64::from(second).max(0.0);
        let noise: f64 = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let helium = filled(t.min(6_060.0) - 6_000.0) * (-(t - 6_060.0).max(0.0) / 10.0).exp();
        let pa = 1e4 * (-t / 10.0).exp() + 1e-3 * 3_600.0 / (t + 10.0) + 1e-4 * (1.0 - 0.54 * helium);
        let at = moment(start, f64::from(second - 18_000));
        services.recorder().push(&series, Sample::new(at, Some(pa * (1.0 + 0.005 * noise)), Quality::Valid));
    }
    let _written = services.recorder().flush();
}

/// Records the readings of a gauge.
fn record(services: &Services, fake: &Fake, start: Micros, second: f64) {
    let at = moment(start, second);
    for (series, shown) in fake.series(second) {
        let Shown { pa, quality } = shown;
        services.recorder().push(&series, Sample::new(at, pa, quality));
    }
}

fn moment(start: Micros, second: f64) -> Micros {
    Micros(start.0 + (second * 1e6) as i64)
}

/// Publishes the snapshots `second` seconds after the start.
fn show(services: &Services, fakes: &[Fake], second: f64, told: &Told) {
    let told = told.lock().unwrap_or_else(PoisonError::into_inner);
    for segment in segments::all(fakes, second) {
        let ours = fakes.iter().filter(|fake| fake.segment == segment.name);
        let gauges = ours.map(|fake| fake.view(second, told.get(fake.name).copied())).collect();
        services.snapshots().publish(SegmentSnapshot { segment, gauges });
    }
}

fn live(services: &Services, fakes: &[Fake], start: Micros, told: &Told) {
    loop {
        let second = (Micros::now().0 - start.0) as f64 / 1e6;
        show(services, fakes, second, told);
        for fake in fakes {
            record(services, fake, start, second);
        }
        std::thread::sleep(PERIOD);
    }
}

/// Answers the requests to a segment, about as fast as a slow bus.
fn answer(services: &Services, fakes: &[Fake], segment: &str) {
    let requests = services.control().requests().accept(segment);
    let devices: Vec<_> = fakes.iter().map(|fake| (fake.name, fake.device)).collect();
    std::thread::spawn(move || {
        while let Ok(request) = requests.recv() {
            std::thread::sleep(Duration::from_millis(400));
            match request {
                SegmentRequest::Blocks(gauge, answer) if gauge == "turbo outlet" => {
                    answer.send(Err(Unavailable::NoAnswer(gauge))).ok();
                }
                SegmentRequest::Blocks(gauge, answer) => {
                    let device = devices.iter().find(|(name, _)| *name == gauge).map_or("bcg450", |(_, device)| device);
                    let blocks = blocks::read(device).map_err(|error| Unavailable::SegmentDown(error.to_string()));
                    answer.send(blocks).ok();
                }
                SegmentRequest::Preview(gauge, _, answer) => drop(answer.send(Err(not_possible(&gauge)))),
                SegmentRequest::Execute(command, _, answer) => drop(answer.send(Err(not_possible(&command.gauge)))),
            }
        }
    });
}

/// A synthetic gauge executes nothing.
fn not_possible(gauge: &str) -> OperationError {
    Unavailable::SegmentDown(format!(
        "{gauge} is synthetic: the example acting_plant has a gauge that executes commands"
    ))
    .into()
}
