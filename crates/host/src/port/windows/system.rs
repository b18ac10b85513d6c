//! Replaces `linux.rs` on Windows: what the system tells about serial ports.

pub use super::list::port_of_serial;
use super::list::{UsbAdapter, serial_ports};
use super::notice::Notice;
use super::{AdapterFacts, Delivery};
use std::time::Duration;

/// The latency of a USB adapter whose driver does not tell it. chosen: the longest that is usual, the default of FTDI chips.
/// profibus-wire 9.4, point 36.
const ASSUMED_LATENCY: Duration = Duration::from_millis(16);

/// How the driver of a serial port delivers characters, as the registry describes it.
pub fn delivery(name: &str) -> Delivery {
    let latency = adapter(name).and_then(|usb| usb.latency);
    Delivery::Usb { hold: latency.unwrap_or(ASSUMED_LATENCY), is_known: latency.is_some() }
}

/// Windows opens a serial port for one program alone.
pub fn open_elsewhere(_name: &str) -> Vec<Notice> {
    Vec::new()
}

/// Vendor and product of a USB adapter.
pub fn adapter_facts(name: &str) -> AdapterFacts {
    AdapterFacts { driver: None, usb_id: adapter(name).map(|usb| usb.id) }
}

fn adapter(name: &str) -> Option<UsbAdapter> {
    serial_ports().into_iter().find(|port| port.name.eq_ignore_ascii_case(name)).and_then(|port| port.usb)
}
