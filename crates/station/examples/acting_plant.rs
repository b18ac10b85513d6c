//! A station with one gauge in memory that executes commands, for tests in a browser.
//!
//! ```text
//! cargo run -p profivac-station --example acting_plant -- 127.0.0.1:8080
//! ```
//!
//! The gauge is a bcg450 called chamber at 1e-6 mbar. Erna is engineer, Otto operator and Vera viewer; all have the same password. A line
//! `mbar 5e-4` on the standard input sets the pressure. The program ends when its input ends.

use profivac_client::cyclic::CyclicSlave;
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_recorder::{EventKind, Recorder, Settings};
use profivac_station::segment::DemoSegment;
use profivac_station::services::Services;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_web_server::auth::password::Hash;
use profivac_web_server::auth::users::Users;
use profivac_web_server::auth::{Access, Role};
use profivac_web_server::server::Setup;
use std::error::Error;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

const BAUD: Baud = Baud::B187500;

/// The time that the gauge advances in one step.
const STEP: Duration = Duration::from_millis(20);

const USERS: [(&str, Role); 3] = [("Erna", Role::Engineer), ("Otto", Role::Operator), ("Vera", Role::Viewer)];

const PASSWORD: &str = "tin whisker plateau";

fn main() -> Result<(), Box<dyn Error>> {
    let address: SocketAddr = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:0".to_owned()).parse()?;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("acting.db");
    let recorder = Recorder::start(&file, Settings::default())?;
    let services = Arc::new(Services::new("Test hall".to_owned(), file, recorder));
    services.recorder().event_now_and_wait(None, EventKind::Station, "the station starts");
    let (pressures, inbox) = channel();
    let mut segment = memory_segment()?;
    let names = |_| ("chamber".to_owned(), "bcg450".to_owned());
    let demo = DemoSegment::new(services.for_segments(), "hall", &mut segment, 1, names);
    std::thread::spawn(move || run(segment, demo, &inbox));
    let users = folder.path().join("users.toml");
    let hash = Hash::of(PASSWORD)?;
    Users::change(&users, |users| USERS.iter().try_for_each(|(name, role)| users.add(name, *role, hash.clone())))?;
    let server = profivac_station::server::start(services, Setup::new(address, Access::Users(users.clone())))?;
    println!("{}", server.url());
    println!("{}", users.display());
    for line in std::io::stdin().lines() {
        if let Some(mbar) = line?.strip_prefix("mbar ") {
            pressures.send(mbar.parse()?)?;
        }
    }
    Ok(())
}

fn around(mbar: f64) -> GasConditions {
    GasConditions { pressure: Pressure::from_mbar(mbar), atmosphere: Pressure::from_mbar(1013.25), gas: Gas::N2 }
}

fn memory_segment() -> Result<MemorySegment, Box<dyn Error>> {
    let spec: DeviceSpec = "bcg450@5".parse()?;
    let device = VirtualDevice::new(spec.build(NonvolatileMemory::volatile(), BAUD)?, 5, BAUD, around(1e-6));
    let model = entry("bcg450")?.model;
    let unit = model.unit_named("mbar").ok_or("the device has no unit mbar")?;
    let slave = CyclicSlave {
        address: 5,
        model,
        configuration: model.default_configuration,
        unit,
        channels: Default::default(),
    };
    Ok(MemorySegment::new(vec![device], vec![slave], BusParameters::new(1, BAUD).check()?, BAUD)?)
}

fn run(mut segment: MemorySegment, mut demo: DemoSegment, pressures: &Receiver<f64>) {
    let mut last = Instant::now();
    loop {
        match pressures.recv_timeout(STEP) {
            Ok(mbar) => segment.set_environment(around(mbar)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        let now = Instant::now();
        segment.run_until(segment.seconds() + now.duration_since(last).as_secs_f64().min(0.2));
        last = now;
        demo.run_once(&mut segment);
    }
}
