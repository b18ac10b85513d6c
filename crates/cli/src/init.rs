//! `profivac init`: makes a station's file from a scan.

use crate::bus::BusOptions;
use crate::console::Signals;
use crate::device_files::{known, names_with_ident};
use crate::explanation::counted;
use crate::failure::Failure;
use crate::output::{notice, out};
use crate::values;
use crate::zeros::names_outputs;
use clap::Args;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::identify::reported_model;
use profivac_client::ms2::Ms2;
use profivac_devices::model::Model;
use profivac_files::open_private;
use profivac_host::scan::probe_all;
use profivac_host::session::BusSession;
use profivac_listen::gauge::Origin;
use profivac_listen::{Divider, Observer, Tap, TapEvent, TimeSource};
use profivac_wire::cfg;
use profivac_wire::control::StationType;
use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Make a file for `profivac run` from the gauges that answer on a bus.
///
/// The command only reads: it does the same as `scan`, asks gauges for their configuration (Get_Cfg), and reads model, unit and channels
/// of gauges with DP-V1 over MS2. A gauge is named by its device and address; edit the file to change the name.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    bus: BusOptions,
    /// Only listen, send nothing, and make a listen-only segment of the gauges that exchange data with another master
    #[arg(long)]
    listen_only: bool,
    /// How long --listen-only listens
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds, default_value = "10", requires = "listen_only")]
    time: Duration,
    /// Write to this file, which must not exist, instead of standard output
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  profivac init --port /dev/ttyUSB0
  profivac init --port tcp://127.0.0.1:4000 --out plant.toml
  profivac init --port /dev/ttyUSB0 --baud auto --listen-only --for 60 --out plant.toml";

/// Asks every address and writes the file.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let bus = &arguments.bus;
    if arguments.listen_only {
        return listen(arguments);
    }
    let mut session = bus.open()?;
    let mut gauges = Vec::new();
    let mut owners = BTreeMap::new();
    let mut found = Vec::new();
    probe_all(&mut session, (0..=bus.hsa().min(125)).filter(|address| *address != bus.master()), &mut found)?;
    if bus.station_at_own_address(session, &found)?.is_some() {
        return Err(Failure::usage(format!(
            "another station has address {}, which this master used: choose another with --master N",
            bus.master()
        )));
    }
    for station in found {
        let address = station.address;
        owners.extend(station.slave.and_then(|slave| Some((address, slave.owner?))));
        match station.slave.map(|slave| names_with_ident(slave.ident)) {
            Some(devices) if !devices.is_empty() => gauges.push((address, devices)),
            Some(_) => notice(&format_args!("the slave at address {address} is not a known device")),
            None if station.station_type == StationType::Slave => {
                notice(&format_args!("the slave at address {address} sends no valid diagnosis"));
            }
            None => notice(&format_args!("address {address} is another master")),
        }
    }
    if gauges.is_empty() {
        return Err(Failure::no_answer(format!("no known gauge answers on {}", bus.port())));
    }
    let mut session = bus.open()?;
    report_models(&mut session, &mut gauges)?;
    let owner = |address| owners.get(&address).copied().unwrap_or_else(|| bus.master());
    integer_notices(&mut session, &gauges, owner)?.iter().for_each(notice);
    Signals::of_command()?.check()?;
    let text = station_file(bus.port(), session.baud().bits_per_second(), Segment::Master(bus.master()), &gauges, &[]);
    put(arguments, &text)
}

/// The addresses of gauges, each with the devices that it may be.
type Gauges = Vec<(u8, Vec<&'static str>)>;

/// Reads the models of a series, whose devices share an ident number. A gauge that does not report its model keeps all of them.
fn report_models(session: &mut BusSession, gauges: &mut Gauges) -> Result<(), Failure> {
    for (address, devices) in gauges.iter_mut().filter(|(_, devices)| devices.len() > 1) {
        let ident = known().named(devices.first().copied().unwrap_or_default()).map(|model| model.ident);
        match ident.and_then(|ident| reported_model(known(), ident, &mut Ms2::new(session, *address))) {
            Some(model) => *devices = vec![model.name],
            // A lost port or a signal is an error; a gauge that cannot be read is none.
            None => probe_all(session, [*address], &mut Vec::new())?,
        }
    }
    Ok(())
}

/// The notices about gauges whose integers do not show the whole range.
fn integer_notices(
    session: &mut BusSession,
    gauges: &Gauges,
    owner: impl Fn(u8) -> u8,
) -> Result<Vec<String>, Failure> {
    let mut notices = Vec::new();
    for (address, devices) in gauges {
        // Without DP-V1 there are no integers, and the unit could not be read without taking the slave.
        let is_dpv1 = |device: &str| known().named(device).is_some_and(|model| model.features.dpv1);
        if !matches!(devices.as_slice(), [device] if is_dpv1(device)) {
            continue;
        }
        match CyclicSlave::find_among(known(), session, *address, owner(*address)) {
            Ok(slave) => notices.extend(integer_notice(&slave)),
            Err(CyclicError::Session(error)) => return Err(error.into()),
            // A gauge that cannot be read is no problem of this command.
            Err(_) => {}
        }
    }
    Ok(notices)
}

fn integer_notice(slave: &CyclicSlave) -> Option<String> {
    Some(format!("the {} at address {}: {}", slave.model.name, slave.address, slave.integer_range()?))
}

fn put(arguments: &Arguments, text: &str) -> Result<(), Failure> {
    match &arguments.out {
        None => out(text.trim_end()),
        Some(path) => {
            write(path, text)?;
            let file = path.display();
            let [gauges, slaves] =
                ["gauge", "slave"].map(|table| text.matches(&format!("[[segment.{table}]]")).count());
            let slaves = if slaves > 0 { format!(" and {}", counted(slaves as u64, "slave")) } else { String::new() };
            let choose =
                if text.contains("# device = ") { "choose the device of each gauge marked # in it, then " } else { "" };
            notice(&format_args!(
                "{file} is written with {}{slaves}; next: {choose}`profivac run {file} --check`, then `profivac run {file}`",
                counted(gauges as u64, "gauge")
            ));
        }
    }
    Ok(())
}

/// Listens, and writes the file from the slaves that exchange data with their master.
fn listen(arguments: &Arguments) -> Result<(), Failure> {
    let (port, baud) = arguments.bus.open_to_listen()?;
    let mut tap = Tap::new(port, baud);
    let (mut divider, mut observer) =
        (Divider::new(baud, TimeSource::Platform), Observer::new(baud, TimeSource::Platform));
    let end = Instant::now().checked_add(arguments.time);
    let mut pieces = Vec::new();
    while let Some(left) = end.map(|end| end.saturating_duration_since(Instant::now())).filter(|left| !left.is_zero()) {
        match tap.receive(&[], left)?.0 {
            TapEvent::Octets(chunk) => divider.push(&chunk, &mut pieces),
            TapEvent::Silence => divider.end(&mut pieces),
            TapEvent::Nothing => {}
        }
        pieces.drain(..).for_each(|piece| observer.piece(&piece));
    }
    observer.advance(tap.now());
    let gauges: Vec<_> = observer
        .stations()
        .filter_map(|(address, station)| {
            station.knowledge.exchanged_at()?;
            let facts = station.knowledge.facts(address).filter(|facts| facts.origin() == Origin::Heard);
            facts.and_then(|facts| integer_notice(&facts.slave)).iter().for_each(notice);
            let devices = match station.knowledge.ident() {
                Some(ident) => names_with_ident(ident),
                // The master runs: only the lengths of the data tell which devices fit.
                None => fitting(station.knowledge.outputs(), station.knowledge.inputs().len()),
            };
            if devices.is_empty() {
                notice(&format_args!(
                    "the slave at address {address} exchanges data and fits no known device: it is not in the file"
                ));
            } else if station.knowledge.ident().is_none() {
                notice(&format_args!(
                    "the slave at address {address} was heard without its ident number; by the lengths of its data it fits {}",
                    devices.join(", ")
                ));
            }
            Some((address, devices)).filter(|(_, devices)| !devices.is_empty())
        })
        .collect();
    if gauges.is_empty() {
        return Err(Failure::no_answer(format!(
            "no known gauge was heard on {} in {} s: a device is known after its diagnosis or its start-up; listen longer, or restart the master",
            arguments.bus.port(),
            arguments.time.as_secs()
        )));
    }
    let is_guessed =
        |address: &u8| observer.stations().any(|(it, station)| it == *address && station.knowledge.ident().is_none());
    let guessed: Vec<u8> = gauges.iter().map(|(address, _)| *address).filter(is_guessed).collect();
    let rate = baud.bits_per_second();
    put(arguments, &station_file(arguments.bus.port(), rate, Segment::ListenOnly, &gauges, &guessed))
}

/// The kind of a segment in the file.
#[derive(Clone, Copy)]
enum Segment {
    /// With a master at this address.
    Master(u8),
    /// Without a master: the station only listens.
    ListenOnly,
}

/// Writes a new file, readable by its owner alone because it may later name secrets. An existing file is an error: a user may have edited
/// it.
fn write(path: &PathBuf, text: &str) -> Result<(), Failure> {
    let failed = |error: std::io::Error| {
        let name = path.display();
        Failure::usage(match error.kind() {
            ErrorKind::AlreadyExists => format!("{name} exists already and was not changed; choose another name"),
            _ => format!("{name} cannot be written: {error}"),
        })
    };
    let mut file = open_private(OpenOptions::new().write(true).create_new(true), path).map_err(failed)?;
    let written = file.write_all(text.as_bytes());
    if written.is_err() {
        // A partial file would prevent the next attempt.
        std::fs::remove_file(path).ok();
    }
    written.map_err(failed)
}

/// Whether one model stands for all devices with the ident number of this one.
fn has_common_model(device: &str) -> bool {
    let common = known().named(device).and_then(|model| known().assumed_with_ident(model.ident));
    common.is_some_and(|common| common.name != device)
}

/// The devices that have a configuration with this many octets of outputs and inputs.
fn fitting(outputs: usize, inputs: usize) -> Vec<&'static str> {
    let fits = |model: &Model| {
        model.configurations.iter().any(|it| {
            cfg::lengths(it.octets)
                .is_ok_and(|lengths| (usize::from(lengths.outputs), usize::from(lengths.inputs)) == (outputs, inputs))
        })
    };
    known().iter().filter(|model| fits(model)).map(|model| model.name).collect()
}

/// The file. A gauge at one of the addresses in `guessed` was not identified: its devices are those that fit its data.
fn station_file(port: &str, baud: u32, segment: Segment, gauges: &[(u8, Vec<&'static str>)], guessed: &[u8]) -> String {
    let kind = match segment {
        Segment::Master(master) => format!("master = {master}"),
        Segment::ListenOnly => "listen-only = true    # the station sends nothing".to_owned(),
    };
    let head = format!(
        "[station]\nname = \"Vacuum\"\nlisten = \"127.0.0.1:8080\"\n\n[[segment]]\nname = \"bus\"\nport = {port:?}\nbaud = {baud}\n{kind}\n"
    );
    gauges.iter().fold(head, |text, (address, devices)| {
        let device = devices.first().copied().unwrap_or_default();
        let others = devices.get(1..).unwrap_or_default();
        let line = match others {
            _ if guessed.contains(address) => format!(
                "# device = {device:?}    # fits{}: the lengths of its data are known only. Check it and remove the first #",
                others.iter().map(|other| format!(", as {other}")).collect::<String>()
            ),
            [] => format!("device = {device:?}"),
            // TPG300 and TPG500 have the same tables.
            others if has_common_model(device) => {
                format!("device = {device:?}    # or {}: they share an ident number", others.join(", "))
            }
            // A wrong model has other ranges: the user must decide.
            others => format!(
                "# device = {device:?}    # or {}: they share an ident number. Choose one and remove the first #",
                others.join(", ")
            ),
        };
        let name = if guessed.contains(address) { "gauge" } else { device };
        // The station sends zeros to its gauges.
        let table = if known().named(name).is_some_and(names_outputs) { "slave" } else { "gauge" };
        text + &format!("\n[[segment.{table}]]\nname = \"{name} {address}\"\naddress = {address}\n{line}\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::Bus;
    use profivac_client::class1::Class1Session;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_devices::catalog::model_named;
    use profivac_devices::model::AccessPath;
    use profivac_host::port::{Port, TcpServer};
    use std::path::Path;

    #[test]
    fn a_device_that_is_not_certain_is_left_to_the_user() {
        let text = station_file("/dev/ttyUSB0", 19200, Segment::Master(1), &[(6, vec!["pcg550", "psg550"])], &[]);
        let line =
            "\n# device = \"pcg550\"    # or psg550: they share an ident number. Choose one and remove the first #\n";
        assert!(text.contains(line), "{text}");
        assert!(profivac_config::parse(&text, Path::new("plant.toml")).is_err());
        assert!(profivac_config::parse(&text.replace("# device", "device"), Path::new("plant.toml")).is_ok());
    }

    #[test]
    fn a_gauge_that_was_heard_without_its_ident_number_has_every_device_that_fits() {
        let model = model_named("bcg450").unwrap();
        let lengths = cfg::lengths(model.configurations.first().unwrap().octets).unwrap();
        let devices = fitting(lengths.outputs.into(), lengths.inputs.into());
        assert!(devices.contains(&"bcg450"), "{devices:?}");
        assert!(fitting(240, 240).is_empty());
        let text =
            station_file("/dev/ttyUSB0", 19200, Segment::ListenOnly, &[(5, devices), (6, vec!["bcg450"])], &[5, 6]);
        assert!(text.contains("address = 5\n# device = "), "{text}");
        assert!(text.contains("name = \"gauge 6\"\naddress = 6\n# device = \"bcg450\"    # fits: "), "{text}");
        assert!(
            profivac_config::parse(&text, Path::new("plant.toml")).is_err(),
            "a device that only fits needs a look"
        );
        assert!(profivac_config::parse(&text.replace("# device", "device"), Path::new("plant.toml")).is_ok());
    }

    #[test]
    fn the_station_accepts_the_file_of_a_listen_only_segment() {
        let text = station_file("/dev/ttyUSB0", 93_750, Segment::ListenOnly, &[(5, vec!["bcg450"])], &[]);
        let config = profivac_config::parse(&text, Path::new("plant.toml")).unwrap();
        assert!(config.segments[0].listen_only && !config.segments[0].detects_baud);
        assert_eq!(config.segments[0].baud.bits_per_second(), 93_750);
    }

    #[test]
    fn the_notice_about_integers_names_the_gauge_and_the_limits_in_mbar() {
        let model = model_named("bcg450").unwrap();
        let notice = |unit| {
            let (configuration, unit) = (&model.configurations[4], model.unit_named(unit).unwrap());
            let channels = ReportedChannels::default();
            integer_notice(&CyclicSlave { address: 5, model, configuration, unit, channels })
        };
        let said = notice("Micron").unwrap();
        assert!(said.starts_with("the bcg450 at address 5: its integers in Micron show 0.0013332 to 43.686 mbar only"));
        assert_eq!(notice("COUNTS"), None);
    }

    /// A session with the virtual devices `specs`.
    fn bus(specs: &[&str]) -> Bus {
        Bus::on(profivac_virtual::open::devices(specs).unwrap()).open().unwrap()
    }

    /// Another master has chosen the module of the gauge at address 5, and has released the gauge.
    #[test]
    fn a_gauge_whose_module_has_integers_is_named_with_its_limits_and_one_with_floats_is_not() {
        let mut bus = bus(&["bcg450@5:unit=pascal", "bcg450@6:unit=pascal"]);
        let gauges = vec![(5, vec!["bcg450"]), (6, vec!["bcg450"])];
        let before = integer_notices(bus.session(), &gauges, |_| 0).unwrap();
        assert_eq!(before, Vec::<String>::new(), "their modules have floats");
        let slave = CyclicSlave::find(bus.session(), 5, 0).unwrap();
        let integers = CyclicSlave { configuration: &slave.model.configurations[4], ..slave };
        // Data Type of a BCG450 is index 21 of slot 1; 3 is Integer16.
        Ms2::new(bus.session(), 5).write(1, 21, &[3]).unwrap();
        drop(Class1Session::open(bus.session(), &integers, AccessPath::Class1).unwrap());
        let notices = integer_notices(bus.session(), &gauges, |_| 0).unwrap();
        let [said] = notices.as_slice() else { panic!("{notices:?}") };
        assert!(
            said.starts_with("the bcg450 at address 5: its integers in Pascal show 0.01 to 327.67 mbar only"),
            "{said}"
        );
    }

    /// Both parts that read over MS2, with a gauge for each.
    fn read(bus: &mut Bus) -> [Result<(), Failure>; 2] {
        let mut gauges = vec![(5, vec!["bcg450"]), (6, vec!["pcg550", "psg552"])];
        let notices = integer_notices(bus.session(), &gauges, |_| 0).map(drop);
        [report_models(bus.session(), &mut gauges), notices]
    }

    #[test]
    fn a_signal_ends_the_reading() {
        let mut interrupted = bus(&["bcg450@5", "psg552@6"]);
        interrupted.session().set_cancellation(Some(Box::new(|| true)));
        for result in read(&mut interrupted) {
            let failure = format!("{:?}", result.unwrap_err());
            assert!(failure.contains("interrupted by a signal"), "{failure}");
        }
        for result in read(&mut bus(&["bcg450@5", "psg552@6"])) {
            result.unwrap();
        }
    }

    #[test]
    fn a_lost_port_is_an_error_and_no_gauge_that_cannot_be_read() {
        let server = TcpServer::listen("127.0.0.1:0").unwrap();
        let mut bus = Bus::builder(format!("tcp://{}", server.name())).open().unwrap();
        drop(server);
        for result in read(&mut bus) {
            let failure = format!("{:?}", result.unwrap_err());
            assert!(failure.contains("lost tcp://"), "{failure}");
        }
    }

    #[test]
    fn a_gauge_that_has_vanished_is_no_error() {
        let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@9"]).unwrap());
        bus = bus.timeout(Duration::from_millis(200));
        for result in read(&mut bus.open().unwrap()) {
            result.unwrap();
        }
    }

    #[test]
    fn the_station_accepts_the_file() {
        let found = [(5, vec!["bcg450"]), (6, vec!["psg552"]), (8, vec!["tpg300", "tpg500"])];
        let text = station_file("/dev/ttyUSB0", 19200, Segment::Master(1), &found, &[]);
        let config = profivac_config::parse(&text, Path::new("plant.toml")).unwrap();
        let gauges = &config.segments[0].gauges;
        assert_eq!(
            gauges.iter().map(|gauge| (gauge.address, gauge.name.as_str())).collect::<Vec<_>>(),
            [(5, "bcg450 5"), (6, "psg552 6"), (8, "tpg300 8")]
        );
    }
}
