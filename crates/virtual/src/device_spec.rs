//! Devices by name: `bcg450@5:unit=torr`.
//!
//! To add a device, add its entry to [`DEVICES`].

use crate::device::GaugeSlave;
use crate::nonvolatile::{NonvolatileMemory, OpenedMemory};
use profivac_device_file::{built_in_like, description, is_device_file, known_devices, usual_files};
use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::{self, Bcg450};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::described::Described;
use profivac_devices::img400::{self, Gauges, Img400, IonGauge, OtherGauge};
use profivac_devices::model::Model;
use profivac_devices::profile::{SerialNumber, Setup};
use profivac_devices::pxg55x::table::{
    PCG550_WITH_ATM, PCG552_WITH_ATM, PCG554_WITH_ATM, PSG550, PSG552, PSG554, Variant,
};
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_devices::tpg::{self, Tpg};
use profivac_devices::xpg400::{self, Xpg400};
use profivac_dp::link::Baud;
use profivac_dp::slave::Slave;
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The highest address on a command line: 126 is a switch setting outside 0 to 125.
const MAX_ADDRESS: u8 = 126;

/// The keys of every device.
const COMMON_KEYS: [&str; 2] = ["serial", "unit"];

/// The longest serial number.
const MAX_SERIAL: usize = 30;

/// The form of a serial number.
const SERIAL_FORM: &str = "1 to 30 ASCII characters";

/// A known device.
pub struct DeviceEntry {
    /// Its model.
    pub model: &'static Model,
    /// The keys of this device in addition to [`COMMON_KEYS`].
    keys: &'static [&'static str],
    build: Build,
}

/// Builds the slave of a device.
type Build = fn(&DeviceSpec, Setup, NonvolatileMemory, Baud) -> BuildResult;

/// The slave of a device.
type BuildResult = Result<Box<dyn GaugeSlave>, SpecError>;

/// All known devices, in the order of their manuals.
pub static DEVICES: [DeviceEntry; 12] = [
    pcg(&PCG550_WITH_ATM),
    pcg(&PCG552_WITH_ATM),
    pcg(&PCG554_WITH_ATM),
    psg(&PSG550),
    psg(&PSG552),
    psg(&PSG554),
    DeviceEntry {
        model: &xpg400::table::BPG400.model,
        keys: &[],
        build: |spec, setup, memory, baud| {
            Ok(slave(Xpg400::with_model(spec.model, xpg400::Xpg400Model::Bpg, memory, setup), baud))
        },
    },
    DeviceEntry {
        model: &xpg400::table::HPG400.model,
        keys: &[],
        build: |spec, setup, memory, baud| {
            Ok(slave(Xpg400::with_model(spec.model, xpg400::Xpg400Model::Hpg, memory, setup), baud))
        },
    },
    DeviceEntry {
        model: &bcg450::table::MODEL,
        keys: &[],
        build: |spec, setup, memory, baud| Ok(slave(Bcg450::with_model(spec.model, memory, setup), baud)),
    },
    DeviceEntry { model: &tpg::table::TPG300, keys: &TPG_KEYS, build: build_tpg },
    DeviceEntry { model: &tpg::table::TPG500, keys: &TPG_KEYS, build: build_tpg },
    DeviceEntry { model: &img400::table::MODEL, keys: &IMG_KEYS, build: build_img },
];

/// A gauge of tira56e1 with an optional atmosphere sensor.
const fn pcg(variant: &'static Variant) -> DeviceEntry {
    DeviceEntry { keys: &["atm"], ..psg(variant) }
}

/// A gauge of tira56e1 without one.
const fn psg(variant: &'static Variant) -> DeviceEntry {
    DeviceEntry { model: &variant.model, keys: &[], build: build_pxg }
}

fn build_pxg(spec: &DeviceSpec, setup: Setup, memory: NonvolatileMemory, baud: Baud) -> BuildResult {
    let atmosphere = match spec.value("atm") {
        // With an atmosphere sensor, if the model exists with one.
        None => None,
        Some("on") => Some(true),
        Some("off") => Some(false),
        Some(_) => return Err(spec.invalid_value("atm", "on|off")),
    };
    let like = behaviour_of(spec.model)?.model;
    let kind = Pxg55xModel::named(like.name, atmosphere).ok_or_else(|| unknown(&spec.device))?;
    // A built-in gauge has the tables of its variant, with or without the sensor.
    let tables = if like == spec.model { &kind.variant().model } else { spec.model };
    Ok(slave(Pxg55x::with_model(tables, memory, kind, setup), baud))
}

const TPG_KEYS: [&str; 4] = ["a1", "a2", "b1", "b2"];

/// The gauges of a controller channel. `none` is a channel without a gauge.
const TPG_GAUGES: [(&str, Option<tpg::TpgGauge>); 3] =
    [("pirani", Some(tpg::TpgGauge::Pirani)), ("cold-cathode", Some(tpg::TpgGauge::ColdCathode)), ("none", None)];

fn build_tpg(spec: &DeviceSpec, setup: Setup, memory: NonvolatileMemory, baud: Baud) -> BuildResult {
    let [a1, a2, b1, b2] = TPG_KEYS;
    let (pirani, cold_cathode) = (Some(tpg::TpgGauge::Pirani), Some(tpg::TpgGauge::ColdCathode));
    let gauges = [
        spec.choice(a1, &TPG_GAUGES, pirani)?,
        spec.choice(a2, &TPG_GAUGES, pirani)?,
        spec.choice(b1, &TPG_GAUGES, cold_cathode)?,
        spec.choice(b2, &TPG_GAUGES, cold_cathode)?,
    ];
    Ok(slave(Tpg::new(spec.model, memory, setup, gauges), baud))
}

const IMG_KEYS: [&str; 4] = ["ch1", "ch2", "ch3", "ch4"];

const ION_GAUGES: [(&str, Option<IonGauge>); 3] =
    [("bag", Some(IonGauge::Bag)), ("ext", Some(IonGauge::Ext)), ("none", None)];

const OTHER_GAUGES: [(&str, Option<OtherGauge>); 3] =
    [("tpr", Some(OtherGauge::Tpr)), ("cmr", Some(OtherGauge::Cmr)), ("none", None)];

fn build_img(spec: &DeviceSpec, setup: Setup, memory: NonvolatileMemory, baud: Baud) -> BuildResult {
    let [ch1, ch2, ch3, ch4] = IMG_KEYS;
    let usual = Gauges::default();
    let gauges = Gauges {
        ch1: spec.choice(ch1, &ION_GAUGES, usual.ch1)?,
        ch2: spec.choice(ch2, &ION_GAUGES, usual.ch2)?,
        ch3: spec.choice(ch3, &OTHER_GAUGES, usual.ch3)?,
        ch4: spec.choice(ch4, &OTHER_GAUGES, usual.ch4)?,
    };
    Ok(slave(Img400::with_model(spec.model, memory, setup, gauges), baud))
}

fn slave<I: SimulatedDevice + Send + 'static>(simulated: I, baud: Baud) -> Box<dyn GaugeSlave> {
    let address = simulated.station_address();
    Box::new(Slave::new(simulated, address, baud))
}

/// A device as the command line writes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceSpec {
    /// The name of the device.
    pub device: String,
    /// Its tables: built in, or of a device file.
    pub model: &'static Model,
    /// The setting of the address switch, 0 to 126.
    pub address: u8,
    /// Keys with their values, each key once.
    pub keys: Vec<(String, String)>,
}

/// The reason why a device spec is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SpecError {
    /// The text does not have the form `DEVICE@ADDR[:key=value,...]`.
    #[error("expected DEVICE@ADDR[:key=value,...] like bcg450@5, got {0:?}")]
    Syntax(String),
    /// The keys are before the address.
    #[error("the keys follow the address: expected {device}@{address}:{keys}, got \"{device}:{keys}@{address}\"")]
    KeysBeforeAddress {
        /// The device.
        device: String,
        /// The keys with their values.
        keys: String,
        /// The address.
        address: String,
    },
    /// The address is not a number from 0 to 126.
    #[error("expected an address from 0 to 126, got {0:?}")]
    InvalidAddress(String),
    /// No device has this name.
    #[error("unknown device {name:?}; known: {known}{similar}", similar = similar(.name, *.devices), known = names(*.devices))]
    UnknownDevice {
        /// The name.
        name: String,
        /// The known devices.
        devices: KnownDevices,
    },
    /// A device file cannot be used.
    #[error("{0}")]
    DeviceFile(String),
    /// Nothing says how the device of a file behaves.
    #[error(
        "{0} cannot be simulated: its file has tables and no behaviour; a device behaves as the built-in one that it is `like`, or that \
         it names as its `behaviour`, or as its blocks name theirs"
    )]
    NoBehaviour(&'static str),
    /// The device does not have the key.
    #[error("{device} has no key {key:?}; it has {keys}", keys = expected.join(", "))]
    UnknownKey {
        /// The device.
        device: String,
        /// The key.
        key: String,
        /// The keys of the device.
        expected: Vec<&'static str>,
    },
    /// A key is given twice.
    #[error("the key {0:?} is given twice")]
    DuplicateKey(String),
    /// The device does not accept the value of a key.
    #[error("{device}: expected {key}={expected}, got {value:?}")]
    InvalidValue {
        /// The device.
        device: String,
        /// The key.
        key: &'static str,
        /// The accepted values.
        expected: String,
        /// The value.
        value: String,
    },
    /// Two devices have the same address.
    #[error("two devices at address {0}")]
    DuplicateAddress(u8),
}

/// The reason why the nonvolatile memory of a device cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MemoryError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] io::Error),
    /// The device spec is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
}

impl FromStr for DeviceSpec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        Self::parse_in(text, Path::new(""))
    }
}

impl DeviceSpec {
    /// Parses a device whose file, if it is one of a device file, is relative to `folder`.
    ///
    /// # Errors
    /// [`SpecError`].
    pub fn parse_in(text: &str, folder: &Path) -> Result<Self, SpecError> {
        let form = || SpecError::Syntax(text.to_owned());
        let (device, rest) = device_and_rest(text).ok_or_else(form)?;
        if let Some((device, keys)) = device.split_once(':') {
            let [device, keys, address] = [device, keys, rest].map(str::to_owned);
            return Err(SpecError::KeysBeforeAddress { device, keys, address });
        }
        let (address, keys) = rest.split_once(':').map_or((rest, None), |(address, keys)| (address, Some(keys)));
        let (keys_of_device, model) = known(device, folder)?;
        let address = parse_address(address)?;
        let mut spec = Self { device: model.name.to_owned(), model, address, keys: Vec::new() };
        for pair in keys.into_iter().flat_map(|keys| keys.split(',')) {
            let (key, value) = pair.split_once('=').ok_or_else(form)?;
            spec.add(keys_of_device, key, value)?;
        }
        Ok(spec)
    }

    fn add(&mut self, keys: &'static [&'static str], key: &str, value: &str) -> Result<(), SpecError> {
        let mut expected = keys.iter().chain(&COMMON_KEYS);
        if !expected.clone().any(|known| *known == key) {
            let expected = expected.by_ref().copied().collect();
            return Err(SpecError::UnknownKey { device: self.device.clone(), key: key.to_owned(), expected });
        }
        if self.value(key).is_some() {
            return Err(SpecError::DuplicateKey(key.to_owned()));
        }
        self.keys.push((key.to_owned(), value.to_owned()));
        Ok(())
    }

    /// The value of a key, if it is given.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<&str> {
        self.keys.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    /// Opens the nonvolatile memory of the device in `folder`. A file that cannot be used, or not completely, is kept aside.
    ///
    /// # Errors
    /// [`MemoryError`] when a file cannot be read or written, or the spec is wrong.
    pub fn open_memory(&self, folder: &Path) -> Result<OpenedMemory, MemoryError> {
        let OpenedMemory { mut memory, set_aside } = NonvolatileMemory::open(folder, &self.device, self.address)?;
        // Restores the values as the device will; the rate does not matter.
        let device = self.build(memory.to_volatile(), Baud::B19200)?;
        let mut refused = BTreeSet::new();
        device.device().refused_values(&mut |key| refused.extend([key]));
        let dropped = memory.drop_refused(&refused)?;
        Ok(OpenedMemory { memory, set_aside: set_aside.or(dropped) })
    }

    /// Builds the device with its nonvolatile memory.
    ///
    /// # Errors
    /// [`SpecError::InvalidValue`].
    pub fn build(&self, memory: NonvolatileMemory, baud: Baud) -> Result<Box<dyn GaugeSlave>, SpecError> {
        (way_of(self.model)?.1)(self, self.setup(self.model)?, memory, baud)
    }

    /// The setup from the keys of every device.
    fn setup(&self, model: &Model) -> Result<Setup, SpecError> {
        let mut setup = Setup::new(self.address);
        if let Some(text) = self.value("serial") {
            let fits = text.is_ascii() && !text.is_empty() && text.len() <= MAX_SERIAL;
            setup.serial =
                fits.then(|| SerialNumber::new(text)).ok_or_else(|| self.invalid_value("serial", SERIAL_FORM))?;
        }
        if let Some(name) = self.value("unit") {
            let names = || model.units.iter().map(|unit| unit.name).collect::<Vec<_>>().join("|");
            setup.unit = Some(model.unit_named(name).ok_or_else(|| self.invalid_value("unit", &names()))?);
        }
        Ok(setup)
    }

    /// The choice that the value of `key` names, `usual` if the key is not given.
    fn choice<T: Copy>(&self, key: &'static str, choices: &[(&str, T)], usual: T) -> Result<T, SpecError> {
        let Some(value) = self.value(key) else { return Ok(usual) };
        let names = || choices.iter().map(|(name, _)| *name).collect::<Vec<_>>().join("|");
        let choice = choices.iter().find(|(name, _)| *name == value);
        choice.map(|(_, choice)| *choice).ok_or_else(|| self.invalid_value(key, &names()))
    }

    /// The error for the value of `key`.
    fn invalid_value(&self, key: &'static str, expected: &str) -> SpecError {
        SpecError::InvalidValue {
            device: self.device.clone(),
            key,
            expected: expected.to_owned(),
            value: self.value(key).unwrap_or_default().to_owned(),
        }
    }
}

/// The device and what follows its `@`. The path of a device file may have one too.
#[must_use]
pub fn device_and_rest(text: &str) -> Option<(&str, &str)> {
    const END: &str = ".toml@";
    let of_file = text.to_ascii_lowercase().find(END).map(|place| place + END.len() - 1);
    let place = of_file.or_else(|| text.find('@'))?;
    Some((text.get(..place)?, text.get(place + 1..)?))
}

/// Parses the setting of an address switch.
///
/// # Errors
/// [`SpecError::InvalidAddress`].
pub fn parse_address(text: &str) -> Result<u8, SpecError> {
    let address = text.parse().ok().filter(|address| *address <= MAX_ADDRESS);
    address.ok_or_else(|| SpecError::InvalidAddress(text.to_owned()))
}

/// Checks that no two devices have the same address.
///
/// # Errors
/// [`SpecError::DuplicateAddress`] names the first duplicate.
pub fn check_addresses(specs: &[DeviceSpec]) -> Result<(), SpecError> {
    check_distinct(specs.iter().map(|spec| spec.address))
}

/// Checks that no address comes twice.
///
/// # Errors
/// [`SpecError::DuplicateAddress`] names the first duplicate.
pub fn check_distinct(addresses: impl IntoIterator<Item = u8>) -> Result<(), SpecError> {
    let mut taken = BTreeSet::new();
    match addresses.into_iter().find(|address| !taken.insert(*address)) {
        Some(address) => Err(SpecError::DuplicateAddress(address)),
        None => Ok(()),
    }
}

/// The built-in device with this name in any case, or with this name on the device: `bcg450`, `BCG450-SP`.
///
/// # Errors
/// [`SpecError::UnknownDevice`] lists the known devices.
pub fn entry(name: &str) -> Result<&'static DeviceEntry, SpecError> {
    DEVICES.iter().find(|entry| entry.model.is_called(name)).ok_or_else(|| unknown(name))
}

/// The device with this name, or of this device file in `folder`, and the keys that it has. A name that is not
/// built in is searched in the usual folders of device files.
fn known(device: &str, folder: &Path) -> Result<(&'static [&'static str], &'static Model), SpecError> {
    let read = |paths: &[PathBuf]| known_devices(paths).map_err(|error| SpecError::DeviceFile(error.to_string()));
    let model = if is_device_file(Path::new(device)) {
        read(&[folder.join(device)])?.described().first().copied().ok_or_else(|| unknown(device))?
    } else if let Ok(entry) = entry(device) {
        return Ok((entry.keys, entry.model));
    } else {
        let devices = read(&usual_files().0)?;
        devices.named(device).ok_or_else(|| SpecError::UnknownDevice { name: device.to_owned(), devices })?
    };
    Ok((way_of(model)?.0, model))
}

/// The keys of a device, and what builds it: the behaviours that its blocks name, or that of a built-in device.
fn way_of(model: &'static Model) -> Result<(&'static [&'static str], Build), SpecError> {
    if description(model).is_some() {
        return Ok((&[], build_described));
    }
    behaviour_of(model).map(|entry| (entry.keys, entry.build))
}

fn build_described(spec: &DeviceSpec, setup: Setup, memory: NonvolatileMemory, baud: Baud) -> BuildResult {
    let description = description(spec.model).ok_or(SpecError::NoBehaviour(spec.model.name))?;
    Ok(slave(Described::new(description, memory, setup), baud))
}

/// The built-in device whose behaviour a device has: its own, or that of the device that it is like.
fn behaviour_of(model: &'static Model) -> Result<&'static DeviceEntry, SpecError> {
    let like = built_in_like(model).unwrap_or(model);
    let found = DEVICES.iter().find(|entry| entry.model == like);
    found.ok_or(SpecError::NoBehaviour(model.name))
}

fn unknown(name: &str) -> SpecError {
    SpecError::UnknownDevice { name: name.to_owned(), devices: KnownDevices::BUILT_IN }
}

/// A question with the device that was meant, if a slip of the finger explains the difference.
fn similar(name: &str, devices: KnownDevices) -> String {
    let similar = devices.iter().find(|model| is_slip(name, model.name));
    similar.map(|model| format!("; did you mean {:?}?", model.name)).unwrap_or_default()
}

/// Whether `written` is `name` with two letters swapped, or with one other digit behind the first. More than that may be a device
/// of another maker: hpt200 is no hpg400. chosen: without a source.
fn is_slip(written: &str, name: &str) -> bool {
    let parts = |text: &str| {
        let plain = text.to_ascii_lowercase().replace([' ', '-', '_'], "");
        let plain = plain.strip_suffix("sp").map_or(plain.clone(), str::to_owned);
        let letters: String = plain.chars().take_while(char::is_ascii_alphabetic).collect();
        let number = plain.strip_prefix(&letters).unwrap_or_default().to_owned();
        (letters, number)
    };
    let sorted = |text: &str| {
        let mut letters: Vec<char> = text.chars().collect();
        letters.sort_unstable();
        letters
    };
    let ((letters, number), (known_letters, known_number)) = (parts(written), parts(name));
    let others = number.chars().zip(known_number.chars()).filter(|(one, other)| one != other).count();
    let is_near = number.len() == known_number.len() && number.get(..1) == known_number.get(..1) && others <= 1;
    (letters == known_letters && is_near) || (sorted(&letters) == sorted(&known_letters) && number == known_number)
}

fn names(devices: KnownDevices) -> String {
    devices.iter().map(|model| model.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<DeviceSpec, SpecError> {
        text.parse()
    }

    #[test]
    fn a_device_spec_has_a_device_an_address_and_keys() {
        let spec = parse("bcg450@126:unit=torr,serial=4711").unwrap();
        assert_eq!((spec.device.as_str(), spec.address), ("bcg450", 126));
        assert_eq!(parse("BCG450-SP@5").map(|spec| spec.device), Ok("bcg450".to_owned()));
        assert_eq!((spec.value("unit"), spec.value("serial"), spec.value("atm")), (Some("torr"), Some("4711"), None));
    }

    #[test]
    fn the_path_of_a_device_file_and_a_key_may_have_an_at_sign() {
        let parts = |text| device_and_rest(text).unwrap();
        assert_eq!(parts("a@b/my.TOML@7:serial=x@y"), ("a@b/my.TOML", "7:serial=x@y"));
        assert_eq!(parts("bcg450@5:serial=x@y"), ("bcg450", "5:serial=x@y"));
        assert_eq!(parse("bcg450@5:serial=x@y").unwrap().value("serial"), Some("x@y"));
        assert!(device_and_rest("bcg450").is_none());
    }

    #[test]
    fn a_slip_of_the_finger_has_a_suggestion_and_a_device_of_another_maker_has_none() {
        for (written, meant) in [("bcg451", "bcg450"), ("BGC450-SP", "bcg450"), ("psg-550x", ""), ("IMG 410", "img400")]
        {
            assert_eq!(
                similar(written, KnownDevices::BUILT_IN),
                if meant.is_empty() { String::new() } else { format!("; did you mean {meant:?}?") }
            );
        }
        for other in
            ["hpt200", "HPT 200", "cpt200", "ppt100", "pcg750", "tpg361", "tpg256a", "bcg552", "thermometer", "", "400"]
        {
            assert_eq!(similar(other, KnownDevices::BUILT_IN), "", "{other}");
        }
    }

    #[test]
    fn every_device_is_built_by_its_name() {
        for entry in &DEVICES {
            let name = entry.model.name;
            let slave =
                parse(&format!("{name}@9")).unwrap().build(NonvolatileMemory::volatile(), Baud::B19200).unwrap();
            assert_eq!((slave.device().name(), slave.station_address()), (name, 9));
            assert_eq!(slave.device().ident_number(), entry.model.ident);
        }
    }

    #[test]
    fn an_atmosphere_sensor_is_fitted_unless_a_key_removes_it() {
        let parts = |text: &str| {
            let slave = parse(text).unwrap().build(NonvolatileMemory::volatile(), Baud::B19200).unwrap();
            slave.device().parts().len()
        };
        assert_eq!([parts("pcg550@5"), parts("pcg550@5:atm=on"), parts("pcg550@5:atm=off")], [3, 3, 2]);
        assert_eq!(parts("psg550@5"), 1);
    }

    #[test]
    fn an_invalid_device_spec_is_an_error_that_names_the_part() {
        for (text, error) in [
            ("bcg450", SpecError::Syntax("bcg450".to_owned())),
            ("bcg450@5:unit", SpecError::Syntax("bcg450@5:unit".to_owned())),
            ("bcg451@5", unknown("bcg451")),
            ("bcg450@127", SpecError::InvalidAddress("127".to_owned())),
            ("bcg450@", SpecError::InvalidAddress(String::new())),
            ("bcg450@-1", SpecError::InvalidAddress("-1".to_owned())),
            ("bcg450@5:unit=pa,unit=pa", SpecError::DuplicateKey("unit".to_owned())),
        ] {
            assert_eq!(parse(text), Err(error), "{text}");
        }
        let sentence = parse("img400:ch3=none@11").unwrap_err().to_string();
        let expected = "the keys follow the address: expected img400@11:ch3=none, got \"img400:ch3=none@11\"";
        assert_eq!(sentence, expected);
        assert!(parse("psg550@5:atm=on").is_err());
        let sentence = parse("bcg450@5:atm=on").unwrap_err().to_string();
        assert_eq!(sentence, "bcg450 has no key \"atm\"; it has serial, unit");
    }

    #[test]
    fn an_invalid_value_is_an_error_that_lists_the_accepted_values() {
        let build = |text: &str| match parse(text).unwrap().build(NonvolatileMemory::volatile(), Baud::B19200) {
            Ok(_) => "built".to_owned(),
            Err(error) => error.to_string(),
        };
        assert_eq!(build("bcg450@5:unit=hpa,serial=4711"), "built");
        assert_eq!(build("pcg552@5:atm=off,unit=pa"), "built");
        assert_eq!(build("tpg500@5:a1=none,b2=pirani"), "built");
        assert_eq!(build("img400@5:ch1=none,ch4=tpr"), "built");
        assert_eq!(build("pcg554@5:atm=yes"), "pcg554: expected atm=on|off, got \"yes\"");
        assert_eq!(build("tpg300@5:a1=bag"), "tpg300: expected a1=pirani|cold-cathode|none, got \"bag\"");
        assert_eq!(build("img400@5:ch3=bag"), "img400: expected ch3=tpr|cmr|none, got \"bag\"");
        let units = "bcg450: expected unit=COUNTS|Torr|Micron|mbar|Pascal, got \"psi\"";
        assert_eq!(build("bcg450@5:unit=psi"), units);
        for serial in ["", "Zähler", "1234567890123456789012345678901"] {
            let expected = format!("bcg450: expected serial=1 to 30 ASCII characters, got {serial:?}");
            assert_eq!(build(&format!("bcg450@5:serial={serial}")), expected);
        }
    }

    #[test]
    fn a_duplicate_address_is_an_error() {
        let specs = |texts: &[&str]| texts.iter().map(|text| text.parse().unwrap()).collect::<Vec<DeviceSpec>>();
        assert_eq!(check_addresses(&specs(&["bcg450@5", "bcg450@6"])), Ok(()));
        let twice = check_addresses(&specs(&["bcg450@5", "bcg450@6", "bcg450@5"]));
        assert_eq!(twice, Err(SpecError::DuplicateAddress(5)));
    }
}
