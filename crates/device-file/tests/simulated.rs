//! Devices of files that are simulated: the tables and ranges of the file with the behaviour of the device that it is like.

use profivac_device_file::{DeviceFile, description};
use profivac_devices::bcg450::Bcg450;
use profivac_devices::described::Described;
use profivac_devices::img400::{Gauges, Img400};
use profivac_devices::model::{Fault, Model, Role};
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::{Action, SimulatedDevice};
use profivac_dp::slave::{Device, Dpv1Error, Relation};

const MS2: Relation = Relation::Ms2(0);

fn model(like: &str, changes: &str) -> &'static Model {
    let head = format!("format = 1\nname = \"mine\"\ntitle = \"Mine\"\nlike = {like:?}\n");
    DeviceFile::parse(&format!("{head}{changes}")).unwrap_or_else(|error| panic!("{error}")).model().unwrap()
}

fn read(device: &mut impl Device, slot: u8, index: u8) -> Result<Vec<u8>, Dpv1Error> {
    let mut record = [0; 240];
    let length = device.read(MS2, slot, index, &mut record)?;
    Ok(record[..length].to_vec())
}

/// The Channel Instance Selector of a BCG450.
const SELECTOR: (u8, u8) = (1, 46);
/// Setpoint Function.
const FUNCTION: (u8, u8) = (1, 201);

#[test]
fn the_lower_set_point_is_that_of_the_first_relay_in_any_order_and_at_any_instance() {
    let changes = "[[block]]\nname = \"Analog Sensor Input Function Block (set point)\"\n\
                   at = [{ slot = 1, instance = 9, name = \"Setpoint B\" }, { slot = 1, instance = 7, name = \"Setpoint A\" }]\n";
    let mut gauge: Bcg450<RamStore> = Bcg450::with_model(model("bcg450", changes), RamStore::default(), Setup::new(5));
    gauge.settle();
    let select = |gauge: &mut Bcg450<RamStore>, instance| gauge.write(MS2, SELECTOR.0, SELECTOR.1, &[instance]);
    assert!(select(&mut gauge, 7).is_ok() && gauge.write(MS2, FUNCTION.0, FUNCTION.1, &[1]).is_ok());
    assert_eq!(read(&mut gauge, FUNCTION.0, FUNCTION.1), Ok(vec![1]));
    assert!(select(&mut gauge, 9).is_ok());
    assert_eq!(read(&mut gauge, FUNCTION.0, FUNCTION.1), Ok(vec![0]));
    assert!(select(&mut gauge, 8).is_err() && select(&mut gauge, 5).is_err(), "the file has no such instance");
}

#[test]
fn a_row_of_another_kind_than_the_inherited_one_keeps_what_is_written() {
    let changes = "[[block]]\nname = \"Device Block\"\n\
                   parameters = [{ index = 19, name = \"Number\", type = \"UINT16\", access = \"1/2_R/W\", store = \"N\" }]\n";
    let mut gauge: Bcg450<RamStore> = Bcg450::with_model(model("bcg450", changes), RamStore::default(), Setup::new(5));
    assert_eq!(read(&mut gauge, 0, 19), Ok(vec![0, 0]), "not the first octets of a text");
    assert!(gauge.write(MS2, 0, 19, &[1, 2]).is_ok() && gauge.write(MS2, 0, 19, b"INFICON AG").is_err());
    assert_eq!(read(&mut gauge, 0, 19), Ok(vec![1, 2]));
}

#[test]
fn a_controller_has_the_ranges_of_its_file() {
    let shown = profivac_device_file::show(profivac_devices::catalog::model_named("img400").unwrap());
    let parts = shown.split_once("parts = [").unwrap().1.split_once("\n]\n").unwrap().0;
    // The second hot cathode of channel 2 is the extractor, which the gauge has there.
    let line = parts.lines().filter(|line| line.contains("instance = 2")).nth(1).unwrap();
    let changed = line.replace("overrange = \"1e-4 mbar\"", "overrange = \"5e-5 mbar\"");
    assert_ne!(changed, line);
    let model = model("img400", &format!("parts = [{}\n]\n", parts.replace(line, &changed)));
    let row = model.blocks.iter().flat_map(|placed| placed.block.rows).find(|row| row.role == Some(Role::Overrange));
    let mut controller: Img400<RamStore> =
        Img400::with_model(model, RamStore::default(), Setup::new(5), Gauges::default());
    controller.settle();
    assert_eq!(read(&mut controller, 2, row.unwrap().index), Ok(5e-5_f32.to_be_bytes().to_vec()));
}

/// A gauge that is like no built-in one.
const OWN: &str = include_str!("own_gauge.toml");

fn own(text: &str) -> Described<RamStore> {
    let model = DeviceFile::parse(text).unwrap_or_else(|error| panic!("{error}")).model().unwrap();
    let mut gauge = Described::new(description(model).unwrap(), RamStore::default(), Setup::new(5));
    gauge.settle();
    gauge
}

/// All parts sense this pressure.
fn sense(gauge: &mut Described<RamStore>, mbar: f64) {
    for part in 0..gauge.parts().len() {
        gauge.sense(part, mbar * 100.0);
    }
}

/// A record of an instance of slot 1.
fn of_instance(gauge: &mut Described<RamStore>, instance: u8, index: u8) -> Vec<u8> {
    gauge.write(MS2, 1, 46, &[instance]).unwrap();
    read(gauge, 1, index).unwrap()
}

#[test]
fn blocks_that_name_behaviours_of_the_library_make_a_gauge() {
    let mut gauge = own(OWN);
    assert_eq!(read(&mut gauge, 0, 25), Ok(vec![2]), "IDLE after its self test");
    sense(&mut gauge, 5e-6);
    assert_eq!(of_instance(&mut gauge, 2, 23), [0], "no reading is valid in IDLE");
    assert_eq!(read(&mut gauge, 1, 102), Ok(vec![5]), "nor is that of the gauge, whose Pirani is below its range");
    gauge.write(MS2, 0, 15, &[4]).unwrap();
    assert_eq!(read(&mut gauge, 0, 25), Ok(vec![4]));
    assert_eq!(of_instance(&mut gauge, 2, 105), [1], "the emission goes on by itself");
    assert_eq!(of_instance(&mut gauge, 2, 19), 5e-6_f32.to_be_bytes());
    assert_eq!(read(&mut gauge, 1, 47), Ok(vec![2]), "the cathode measures");
    assert_eq!(of_instance(&mut gauge, 1, 19), 1e-3_f32.to_be_bytes(), "the Pirani shows the end of its range");
    // Degas below its condition, and not above.
    of_instance(&mut gauge, 2, 105);
    assert!(gauge.write(MS2, 1, 14, &[1, 1]).is_ok());
    assert_eq!(of_instance(&mut gauge, 2, 109), [1]);
    // The cathode goes off when the pressure rises.
    sense(&mut gauge, 10.0);
    assert_eq!((of_instance(&mut gauge, 2, 105), read(&mut gauge, 1, 47)), (vec![0], Ok(vec![1])));
    assert!(gauge.write(MS2, 1, 14, &[3, 1]).is_err(), "no emission at 10 mbar");
    // A relay below 20 mbar.
    gauge.write(MS2, 1, 46, &[3]).unwrap();
    gauge.write(MS2, 1, 19, &20_f32.to_be_bytes()).unwrap();
    gauge.write(MS2, 1, 24, &5_f32.to_be_bytes()).unwrap();
    gauge.write(MS2, 1, 20, &[1]).unwrap();
    let is_closed = |gauge: &Described<RamStore>| gauge.report().relays.iter().copied().collect::<Vec<_>>();
    assert_eq!(is_closed(&gauge), [true]);
    for (mbar, closed) in [(24.0, true), (26.0, false), (24.0, false), (19.0, true)] {
        sense(&mut gauge, mbar);
        assert_eq!(is_closed(&gauge), [closed], "{mbar}");
        assert_eq!(read(&mut gauge, 1, 21), Ok(vec![u8::from(closed)]), "{mbar}");
    }
    // A row without a meaning keeps what is written, and the settings survive the power.
    gauge.write(MS2, 0, 200, b"the third chamber   ").unwrap();
    gauge.set_power(false);
    gauge.set_power(true);
    gauge.settle();
    assert_eq!(read(&mut gauge, 0, 200), Ok(b"the third chamber   ".to_vec()));
    assert_eq!(of_instance(&mut gauge, 3, 19), 20_f32.to_be_bytes());
}

#[test]
fn a_device_has_a_behaviour_or_its_blocks_have() {
    let both = OWN.replacen("max-integer", "behaviour = \"bcg450\"\nmax-integer", 1);
    let said = DeviceFile::parse(&both).unwrap_err().to_string();
    assert!(
        said.contains(
            "the device has a behaviour, so its blocks cannot have their own; delete the behaviour of the device"
        ),
        "{said}"
    );
}

#[test]
fn a_fault_of_a_described_gauge_is_in_its_exceptions() {
    let mut gauge = own(OWN);
    gauge.write(MS2, 0, 15, &[4]).unwrap();
    sense(&mut gauge, 1.0);
    assert_eq!((read(&mut gauge, 0, 26), of_instance(&mut gauge, 1, 23)), (Ok(vec![0x80]), vec![1]));
    gauge.operate(Action::Fault { fault: Fault::Sensor1, active: true }).unwrap();
    assert_eq!((read(&mut gauge, 0, 26), of_instance(&mut gauge, 1, 23)), (Ok(vec![0xA2]), vec![0]));
    assert_eq!(read(&mut gauge, 0, 27), Ok(vec![2, 0, 0, 4, 0, 2, 0, 0, 1, 0]));
}

#[test]
fn a_behaviour_without_a_part_for_it_is_refused() {
    let said =
        |text: &str| DeviceFile::parse(text).map(|_| "read".to_owned()).unwrap_or_else(|error| error.to_string());
    for (old, new, expected) in [
        (
            "\"hot-cathode\"\nat",
            "\"cold-cathode\"\nat",
            "\"cold-cathode\" needs an entry of parts with the instance of the location",
        ),
        ("\"hot-cathode\"\nat", "\"hot-kathode\"\nat", "did you mean \"hot-cathode\"?"),
    ] {
        assert_eq!(OWN.matches(old).count(), 1, "{old}");
        let found = said(&OWN.replace(old, new));
        assert!(found.contains(expected), "{new}: {found}");
    }
    let of_no_block: Vec<_> = OWN.lines().filter(|line| !line.starts_with("behaviour =")).collect();
    let of_the_device = of_no_block.join("\n").replace("left-out =", "behaviour = \"bcg450\"\nleft-out =");
    let found = said(&of_the_device);
    assert!(found.contains("the behaviour of bcg450 expects the block"), "{found}");
    let shown = profivac_device_file::show(DeviceFile::parse(OWN).unwrap().model().unwrap());
    assert!(shown.contains("behaviour = \"trip-point\"") && shown.contains("left-out = \"the adjustment"), "{shown}");
}
