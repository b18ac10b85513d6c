//! The serial ports of Windows, and what the registry tells about their adapters.

use serial2::SerialPort;
use std::time::Duration;
use windows_registry::{Key, LOCAL_MACHINE};

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialPortFacts {
    /// `COM5`.
    pub name: String,
    /// The USB adapter; `None` for another port.
    pub usb: Option<UsbAdapter>,
}

/// What a USB adapter says about itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsbAdapter {
    /// Vendor and product: `0403:6001`.
    pub id: String,
    /// The serial number, which stays when the adapter is plugged in elsewhere: the number of its COM port changes.
    pub serial: Option<String>,
    /// How long the driver of an FTDI adapter holds octets back: `LatencyTimer`, in ms.
    pub latency: Option<Duration>,
}

/// The keys of the registry below which the drivers of USB adapters name their ports: FTDI has a bus of its own.
const BUSES: [&str; 2] = ["FTDIBUS", "USB"];

/// The serial ports of the system, by number; none if it does not list them.
#[must_use]
pub fn serial_ports() -> Vec<SerialPortFacts> {
    let adapters = adapters();
    let adapter =
        |name: &str| adapters.iter().find(|(port, _)| port.eq_ignore_ascii_case(name)).map(|(_, usb)| usb.clone());
    // Without a list there is nothing to choose from.
    let ports = SerialPort::available_ports().ok().into_iter().flatten();
    let names = ports.map(|port| port.to_string_lossy().into_owned());
    let mut ports: Vec<_> = names.map(|name| SerialPortFacts { usb: adapter(&name), name }).collect();
    ports.sort_by(|one, other| (one.name.len(), &one.name).cmp(&(other.name.len(), &other.name)));
    ports
}

/// The port of the adapter with this serial number.
#[must_use]
pub fn port_of_serial(serial: &str) -> Option<String> {
    let is_it = |port: &SerialPortFacts| port.usb.as_ref().is_some_and(|usb| usb.serial.as_deref() == Some(serial));
    serial_ports().into_iter().find(is_it).map(|port| port.name)
}

/// The adapters that the registry knows, also those that are not plugged in, and the names of their ports.
fn adapters() -> Vec<(String, UsbAdapter)> {
    let mut found = Vec::new();
    for bus in BUSES {
        let Ok(bus) = LOCAL_MACHINE.open(format!(r"SYSTEM\CurrentControlSet\Enum\{bus}")) else { continue };
        for (device, instance, parameters) in parameters(&bus) {
            let (Ok(port), Some(id)) = (parameters.get_string("PortName"), id(&device)) else { continue };
            let latency = parameters.get_u32("LatencyTimer").ok().map(|ms| Duration::from_millis(ms.into()));
            found.push((port, UsbAdapter { id, serial: serial(&device, &instance), latency }));
        }
    }
    found
}

/// The names of each device and instance of a bus, and the parameters of its driver.
fn parameters(bus: &Key) -> Vec<(String, String, Key)> {
    let keys = |key: &Key| key.keys().map(Iterator::collect::<Vec<_>>).unwrap_or_default();
    let mut found = Vec::new();
    for device in keys(bus) {
        let Ok(of_device) = bus.open(&device) else { continue };
        for instance in keys(&of_device) {
            if let Ok(parameters) = of_device.open(format!(r"{instance}\Device Parameters")) {
                found.push((device.clone(), instance, parameters));
            }
        }
    }
    found
}

/// Vendor and product of a device: `VID_10C4&PID_EA60`, `VID_0403+PID_6001+A50285BIA`.
fn id(device: &str) -> Option<String> {
    let number =
        |name: &str| device.split(['&', '+']).find_map(|part| part.strip_prefix(name)).map(str::to_ascii_lowercase);
    Some(format!("{}:{}", number("VID_")?, number("PID_")?))
}

/// The serial number: FTDI has it behind the product, with a letter for the port of the chip; others as the instance, which has an `&` if
/// Windows has made it up.
fn serial(device: &str, instance: &str) -> Option<String> {
    match device.split('+').nth(2) {
        Some(serial) => serial.get(..serial.len().saturating_sub(1)).map(str::to_owned),
        None => (!instance.contains('&')).then(|| instance.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_of_a_device_have_its_numbers() {
        assert_eq!(id("VID_10C4&PID_EA60").as_deref(), Some("10c4:ea60"));
        assert_eq!(id("VID_0403+PID_6001+A50285BIA").as_deref(), Some("0403:6001"));
        assert_eq!(id("ROOT_HUB30"), None);
        assert_eq!(serial("VID_0403+PID_6001+A50285BIA", "0000").as_deref(), Some("A50285BI"));
        assert_eq!(serial("VID_10C4&PID_EA60", "0001").as_deref(), Some("0001"));
        assert_eq!(serial("VID_1A86&PID_7523", "5&2ba0a1e&0&2"), None);
    }
}
