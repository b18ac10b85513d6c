//! What the system tells about the hardware of a serial device.

/// The driver and the kind of a serial adapter. Contains no serial number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AdapterFacts {
    /// The name of its driver.
    pub driver: Option<String>,
    /// Vendor and product of a USB adapter: `0403:6001`.
    pub usb_id: Option<String>,
}
