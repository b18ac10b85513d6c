//! The two numbers of cyclic telegrams that are neither an integer nor a float.

/// The status of telegram 205: the gauge has an error. tira56e1 4.4.1.
const TTR_ERROR: u16 = 1 << 15;

/// The bits of telegram 205 that the manual declares to be 0. tira56e1 4.4.1.
const TTR_ZERO: u16 = 0b11 << 12;

/// The bits of the measurement value.
const TTR_VALUE: u16 = 0x0FFF;

/// Measurement values for a factor of ten.
const TTR_PER_DECADE: f64 = 482.0;

/// The exponent in Pa of the measurement value 0.
const TTR_OFFSET: f64 = 2.778;

/// Telegram 205 of the TTR compatibility mode (tira56e1 4.4.1): a status and a 12-bit value. It does not depend on Data Units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TtrReading {
    /// The gauge has an error.
    pub has_error: bool,
    /// The bits that the manual declares to be 0 are 0.
    pub is_defined: bool,
    /// The pressure in Pa.
    pub pa: f64,
}

impl TtrReading {
    /// The reading in the two octets of the telegram; `None` for another length.
    ///
    /// ```
    /// use profivac_client::cyclic::TtrReading;
    ///
    /// let reading = TtrReading::decode(&[0x08, 0xFF]).ok_or("not two octets")?;
    /// assert!((reading.pa / 100.0 - 1.0).abs() < 0.003, "1 mbar");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn decode(octets: &[u8]) -> Option<Self> {
        let word = u16::from_be_bytes(octets.try_into().ok()?);
        let exponent = f64::from(word & TTR_VALUE) / TTR_PER_DECADE - TTR_OFFSET;
        Some(Self { has_error: word & TTR_ERROR != 0, is_defined: word & TTR_ZERO == 0, pa: 10.0_f64.powf(exponent) })
    }
}

/// The number in three octets of the Inficon floating point format of a TPG; `None` for another length. i9973ber/a 3.2.4.1 names the
/// octets and does not define them: a signed word times a signed power of ten is assumed (errata-bpg-bcg-tpg 126).
///
/// ```
/// use profivac_client::cyclic::mantissa_number;
///
/// assert_eq!(mantissa_number(&[0x03, 0x3E, 0xFB]), Some(8.3e-3));
/// ```
#[must_use]
pub fn mantissa_number(octets: &[u8]) -> Option<f64> {
    let [high, low, power] = *octets else { return None };
    let (digits, power) = (i16::from_be_bytes([high, low]), i8::from_be_bytes([power]));
    let scale = 10.0_f64.powi(i32::from(power.unsigned_abs()));
    Some(if power < 0 { f64::from(digits) / scale } else { f64::from(digits) * scale })
}
