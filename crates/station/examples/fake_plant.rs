//! A station without a bus: the API and the dashboard over scenery and a record that are made up, and the same on every run.
//!
//! ```text
//! cargo run -p profivac-station --example fake_plant -- 127.0.0.1:8080
//! ```
//!
//! For work on the dashboard and for its tests in a browser. Three segments, thirteen gauges, a week of record. Everything is
//! a function of the seconds since it was started, except that a line `vessel=1e5` as input makes that gauge show that pressure in Pa
//! from then on. It ends when its input ends. Further arguments: `hostile` adds a gauge
//! whose name is a script. `viewer` lets everybody only look, otherwise everybody is an engineer. `users` lets in ada (engineer), olga
//! (operator) and vera (viewer), all with the password `tin whisker plateau`; the name of their file is printed as well.

#[path = "fake_plant/alarms.rs"]
mod alarms;
#[path = "fake_plant/blocks.rs"]
mod blocks;
#[path = "fake_plant/gauges.rs"]
mod gauges;
#[path = "fake_plant/segments.rs"]
mod segments;

use gauges::{Fake, Shown};
use profivac_recorder::{Event, EventKind, Micros, Recorder, Sample, Settings};
use profivac_station::alarm::AlarmThread;
use profivac_station::auth::password::Hash;
use profivac_station::auth::users::Users;
use profivac_station::auth::{Access, Role};
use profivac_station::control::operation::OperationError;
use profivac_station::server::{Server, Setup};
use profivac_station::services::{SegmentRequest, SegmentSnapshot, Services};
use std::collections::HashMap;
use std::error::Error;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often the scenery changes.
const PERIOD: Duration = Duration::from_millis(100);

/// From so many seconds ago a sample every so many seconds: a week coarsely, a day, the last half hour finely.
const PAST: [(i64, i64); 3] = [(7 * 86_400, 120), (86_400, 20), (1_800, 1)];

/// So many samples are handed over before the record is written: the recorder's queue holds more.
const BATCH: u64 = 20_000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let address: SocketAddr = arguments.next().unwrap_or_else(|| "127.0.0.1:0".to_owned()).parse()?;
    let more: Vec<String> = arguments.collect();
    let said = |word: &str| more.iter().any(|argument| argument == word);
    let fakes = gauges::all(said("hostile"));
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("fake.db");
    let recorder = Recorder::start(&file, Settings::default())?;
    let plant = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
    let start = Micros::now();
    remember(&plant, &fakes, start);
    show(&plant, &fakes, 0.0, &Told::default());
    for segment in ["beam line", "hall"] {
        answer(&plant, segment);
    }
    alarms::begin(&plant, &fakes)?;
    plant.record_event_and_wait(None, EventKind::Station, "the station begins");
    let _watcher = AlarmThread::start(Arc::clone(&plant))?;
    let users = folder.path().join("users.toml");
    let access = match (said("users"), said("viewer")) {
        (true, _) => with_users(&users)?,
        (_, true) => Access::anonymous_viewer(),
        _ => Access::anonymous("demo", Role::Engineer),
    };
    let server = Server::start(Arc::clone(&plant), Setup::new(address, access))?;
    println!("{}", server.url());
    println!("{}", users.display());
    let told = Arc::new(Mutex::new(HashMap::new()));
    let heard = Arc::clone(&told);
    std::thread::spawn(move || live(&plant, &fakes, start, &heard));
    // Until whoever started it is gone.
    for line in std::io::stdin().lines() {
        if let Some((name, pa)) = line?.split_once('=') {
            told.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), pa.parse()?);
        }
    }
    Ok(())
}

/// Gauges by name, with the pressure that somebody has told them.
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

/// The week before the start.
fn remember(plant: &Services, fakes: &[Fake], start: Micros) {
    let mut pushed = 0_u64;
    for fake in fakes {
        let until = PAST.iter().skip(1).map(|(from, _)| -from).chain([0]);
        for ((from, step), until) in PAST.into_iter().zip(until) {
            for second in (-from..until).step_by(usize::try_from(step).unwrap_or(1)) {
                record(plant, fake, start, second as f64);
                pushed += 1;
                if pushed.is_multiple_of(BATCH) {
                    let _written = plant.recorder().flush();
                }
            }
        }
    }
    for (second, gauge, kind, text) in segments::EVENTS {
        let at = moment(start, second);
        let _written = plant.recorder().record_event_and_wait(Event {
            at,
            gauge: gauge.map(str::to_owned),
            kind,
            text: text.to_owned(),
        });
    }
}

/// What a gauge shows at a second, on its way to the record.
fn record(plant: &Services, fake: &Fake, start: Micros, second: f64) {
    let at = moment(start, second);
    for (series, shown) in fake.series(second) {
        let Shown { pa, quality } = shown;
        plant.recorder().push(&series, Sample::new(at, pa, quality));
    }
}

fn moment(start: Micros, second: f64) -> Micros {
    Micros(start.0 + (second * 1e6) as i64)
}

/// What is seen `second` seconds after the start.
fn show(plant: &Services, fakes: &[Fake], second: f64, told: &Told) {
    let told = told.lock().unwrap_or_else(PoisonError::into_inner);
    for segment in segments::all(fakes, second) {
        let ours = fakes.iter().filter(|fake| fake.segment == segment.name);
        let gauges = ours.map(|fake| fake.view(second, told.get(fake.name).copied())).collect();
        plant.publish(SegmentSnapshot { segment, gauges });
    }
}

fn live(plant: &Services, fakes: &[Fake], start: Micros, told: &Told) {
    loop {
        let second = (Micros::now().0 - start.0) as f64 / 1e6;
        show(plant, fakes, second, told);
        for fake in fakes {
            record(plant, fake, start, second);
        }
        std::thread::sleep(PERIOD);
    }
}

/// Answers what is asked of a segment, about as fast as a slow bus.
fn answer(plant: &Services, segment: &str) {
    let questions = plant.accept_requests(segment);
    std::thread::spawn(move || {
        while let Ok(question) = questions.recv() {
            std::thread::sleep(Duration::from_millis(400));
            // Whoever asked may have gone.
            match question {
                SegmentRequest::Blocks(gauge, answer) if gauge == "turbo outlet" => {
                    answer.send(Err(format!("{gauge} does not answer"))).ok();
                }
                SegmentRequest::Blocks(_, answer) => drop(answer.send(Ok(blocks::all()))),
                SegmentRequest::Preview(gauge, _, answer) => drop(answer.send(Err(scenery(&gauge)))),
                SegmentRequest::Execute(order, _, answer) => drop(answer.send(Err(scenery(&order.gauge)))),
            }
        }
    });
}

/// Nothing can be done to what is painted.
fn scenery(gauge: &str) -> OperationError {
    OperationError::Unavailable(format!("{gauge} is scenery: the example acting_plant has a gauge that acts"))
}
