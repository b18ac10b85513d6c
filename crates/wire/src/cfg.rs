//! Configuration identifiers of Chk_Cfg and Get_Cfg: the sizes of inputs and outputs. profibus-wire 2.6.

use crate::octets::{Reader, TooShort};
use core::fmt;

/// One configuration identifier, in general or special format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identifier<'a> {
    /// Outputs: master to slave.
    pub output: Option<Area>,
    /// Inputs: slave to master.
    pub input: Option<Area>,
    /// Manufacturer-specific octets (special format only), for example data type codes.
    pub manufacturer: &'a [u8],
}

/// The size of one direction of an identifier.
///
/// ```
/// use profivac_wire::cfg::Area;
///
/// assert_eq!(Area { units: 4, words: true, consistent: true }.octets(), 8);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Area {
    /// Number of units, 1 to 64.
    pub units: u8,
    /// Whether a unit is a word of two octets instead of one octet.
    pub words: bool,
    /// Whether the data are consistent over the whole length instead of over one unit.
    pub consistent: bool,
}

impl Area {
    /// Size in octets, 1 to 128.
    #[must_use]
    pub const fn octets(&self) -> u16 {
        let units = self.units as u16;
        if self.words { units.saturating_mul(2) } else { units }
    }

    /// Decodes the length octet of the special format.
    const fn from_length(octet: u8) -> Self {
        Self { units: (octet & 0x3F).wrapping_add(1), words: octet & 0x40 != 0, consistent: octet & 0x80 != 0 }
    }
}

/// Octets in each direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lengths {
    /// Master to slave, 0 to 244.
    pub outputs: u8,
    /// Slave to master, 0 to 244.
    pub inputs: u8,
}

/// Error of a list of identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CfgError {
    /// The list is empty.
    Empty,
    /// The last identifier declares more octets than follow.
    Truncated,
    /// One direction has more than 244 octets.
    TooLong,
}

impl fmt::Display for CfgError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "no identifier",
            Self::Truncated => "the last identifier announces more octets than follow",
            Self::TooLong => "more than 244 octets in one direction",
        })
    }
}

impl core::error::Error for CfgError {}

/// Iterates over the identifiers of a configuration. Ends after the first truncated one.
///
/// ```
/// use profivac_wire::cfg::{Area, Identifiers};
///
/// // One octet in, one octet out.
/// let identifiers: Vec<_> = Identifiers::new(&[0x10, 0x20]).flatten().collect();
/// assert_eq!(identifiers[0].input, Some(Area { units: 1, words: false, consistent: false }));
/// assert_eq!(identifiers[1].output.map(|area| area.octets()), Some(1));
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identifiers<'a> {
    reader: Reader<'a>,
}

impl<'a> Identifiers<'a> {
    /// An iterator over the identifiers in `octets`.
    #[must_use]
    pub const fn new(octets: &'a [u8]) -> Self {
        Self { reader: Reader::new(octets) }
    }
}

impl<'a> Iterator for Identifiers<'a> {
    type Item = Result<Identifier<'a>, TooShort>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.reader.is_empty() {
            return None;
        }
        let identifier = identifier(&mut self.reader);
        if identifier.is_err() {
            self.reader = Reader::new(&[]);
        }
        Some(identifier)
    }
}

fn identifier<'a>(reader: &mut Reader<'a>) -> Result<Identifier<'a>, TooShort> {
    let octet = reader.octet()?;
    if octet & 0x30 == 0 { special(octet, reader) } else { Ok(general(octet)) }
}

/// General format: bits 5 and 4 select the directions, which share one length. profibus-wire 2.6.1.
const fn general(octet: u8) -> Identifier<'static> {
    let area = Area { units: (octet & 0x0F).wrapping_add(1), words: octet & 0x40 != 0, consistent: octet & 0x80 != 0 };
    Identifier {
        output: if octet & 0x20 != 0 { Some(area) } else { None },
        input: if octet & 0x10 != 0 { Some(area) } else { None },
        manufacturer: &[],
    }
}

/// Special format: bits 7 and 6 announce length octets, the low nibble counts manufacturer octets. profibus-wire 2.6.2.
fn special<'a>(octet: u8, reader: &mut Reader<'a>) -> Result<Identifier<'a>, TooShort> {
    let mut length = |follows| -> Result<Option<Area>, TooShort> {
        if follows { reader.octet().map(|octet| Some(Area::from_length(octet))) } else { Ok(None) }
    };
    let output = length(octet & 0x80 != 0)?;
    let input = length(octet & 0x40 != 0)?;
    let manufacturer = match octet & 0x0F {
        // 15 means "no data, do not check"; only a master may send it.
        15 => &[],
        count => reader.take(usize::from(count))?,
    };
    Ok(Identifier { output, input, manufacturer })
}

/// Sums the octets that a configuration exchanges in each direction.
///
/// ```
/// use profivac_wire::cfg;
///
/// let lengths = cfg::lengths(&[0x11, 0x21])?;
/// assert_eq!((lengths.inputs, lengths.outputs), (2, 2));
/// # Ok::<(), cfg::CfgError>(())
/// ```
///
/// # Errors
/// [`CfgError`] if the list is empty or truncated, or has more than 244 octets in one direction.
pub fn lengths(octets: &[u8]) -> Result<Lengths, CfgError> {
    if octets.is_empty() {
        return Err(CfgError::Empty);
    }
    let (mut outputs, mut inputs) = (0u16, 0u16);
    for identifier in Identifiers::new(octets) {
        let identifier = identifier.map_err(|TooShort| CfgError::Truncated)?;
        outputs = outputs.saturating_add(identifier.output.map_or(0, |area| area.octets()));
        inputs = inputs.saturating_add(identifier.input.map_or(0, |area| area.octets()));
    }
    let within = |octets| u8::try_from(octets).ok().filter(|octets| *octets <= 244).ok_or(CfgError::TooLong);
    Ok(Lengths { outputs: within(outputs)?, inputs: within(inputs)? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hex;

    #[test]
    fn lengths_of_the_reference_and_the_manuals() {
        for (text, outputs, inputs) in [
            ("10", 0, 1),
            ("20", 1, 0),
            ("30", 1, 1),
            ("11 21", 2, 2),
            ("94", 0, 5),
            ("D3", 0, 8),
            ("F7", 16, 16),
            ("00", 0, 0),
            ("00 10 10", 0, 2),
            ("C3 CF C7 01 02 03", 32, 16),
            ("42 84 08 05", 0, 5),
            ("82 84 08 05", 5, 0),
            ("CB 89 8E 08 05 08 05 08 05 08 05 05 05 0A", 10, 15),
            ("C1 81 84 85", 2, 5),
            ("4F 84", 0, 5),
            // tira41d1 2.3 as errata-bpg-bcg-tpg 2 prints it
            ("44 84 05 05 05 03", 0, 5),
            ("C8 89 8E 0A 05 05 0A 05 05 05 08", 10, 15),
            // IF300P/IF301P manual
            ("97 A7 94 94 94 94 A0", 9, 28),
        ] {
            assert_eq!(lengths(&hex(text)), Ok(Lengths { outputs, inputs }), "{text}");
        }
    }

    #[test]
    fn a_truncated_identifier_is_no_configuration() {
        for (text, defect) in [
            ("", CfgError::Empty),
            ("C6", CfgError::Truncated),
            ("C6 81", CfgError::Truncated),
            // tira41d1 1.4 as printed, one octet short: errata-bpg-bcg-tpg 2
            ("C6 81 84 05 05 05 05 03", CfgError::Truncated),
            ("11 42 84 08", CfgError::Truncated),
            ("7F 7F 7F 7F 7F 7F 7F 7F", CfgError::TooLong),
        ] {
            assert_eq!(lengths(&hex(text)), Err(defect), "{text}");
        }
    }

    #[test]
    fn an_identifier_has_direction_unit_consistency_and_manufacturer_octets() {
        let octets = hex("C2 C1 84 08 05 11");
        let mut identifiers = Identifiers::new(&octets);
        assert_eq!(
            identifiers.next(),
            Some(Ok(Identifier {
                output: Some(Area { units: 2, words: true, consistent: true }),
                input: Some(Area { units: 5, words: false, consistent: true }),
                manufacturer: &[8, 5],
            }))
        );
        assert_eq!(
            identifiers.next(),
            Some(Ok(Identifier {
                output: None,
                input: Some(Area { units: 2, words: false, consistent: false }),
                manufacturer: &[],
            }))
        );
        assert_eq!(identifiers.next(), None);
    }
}
