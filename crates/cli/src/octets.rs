//! Records as octets, by slot and index: `read --octets` and `write --octets`. They need DP-V1, but no known device.

use crate::failure::Failure;
use crate::gauge::{GaugeOptions, confirm};
use crate::output::{json, out};
use crate::record_row::RecordRow;
use crate::values;
use crate::write_failure::{before_write, print_failure};
use profivac_client::names::numbers;
use profivac_client::records::{RecordError, Records, WriteEffect};
use profivac_client::values::hex;
use serde::Serialize;

/// The word for Identification & Maintenance 0.
const IM0: &str = "im0";

/// The Call request for I&M0 and the record that carries it: slot 0, index 255, FI_Index 65000 (PROFIBUS Profile Guidelines part 1,
/// Identification & Maintenance Functions, order no. 3.502).
const CALL: [u8; 4] = [0x08, 0x00, 0xFD, 0xE8];
const CALL_INDEX: u8 = 255;

/// The octets of I&M0 behind the Call header.
const IM0_LENGTH: usize = 64;

/// A record that a user names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Record {
    At { slot: u8, index: u8 },
    Im0,
}

impl Record {
    fn parse(text: &str) -> Result<Self, Failure> {
        match numbers(text) {
            Some((slot, None, index)) => Ok(Self::At { slot, index }),
            _ if text.eq_ignore_ascii_case(IM0) => Ok(Self::Im0),
            _ => Err(Failure::usage(format!(
                "expected SLOT/INDEX like 1/19 or im0 with --octets, got {text:?}; names belong to known devices"
            ))),
        }
    }
}

/// The identification in I&M0.
#[derive(Debug, PartialEq, Eq, Serialize)]
struct Identification {
    /// The number that PROFIBUS International gives to the manufacturer.
    manufacturer: u16,
    order_number: String,
    serial_number: String,
    hardware_revision: u16,
    software_revision: String,
}

impl Identification {
    /// Reads the answer to the Call: its header of four octets, ten octets of the manufacturer, and the fields.
    fn parse(answer: &[u8]) -> Option<Self> {
        let (header, record) = answer.split_at_checked(CALL.len())?;
        if header != CALL || record.len() < IM0_LENGTH {
            return None;
        }
        let word = |at: usize| Some(u16::from_be_bytes([*record.get(at)?, *record.get(at + 1)?]));
        let text = |from: usize, to: usize| {
            let octets = record.get(from..to)?;
            let letters = octets.iter().map(|octet| if octet.is_ascii_graphic() { char::from(*octet) } else { ' ' });
            Some(letters.collect::<String>().trim().to_owned())
        };
        let [class, major, minor, fix] = *record.get(50..54)? else { return None };
        Some(Self {
            manufacturer: word(10)?,
            order_number: text(12, 32)?,
            serial_number: text(32, 48)?,
            hardware_revision: word(48)?,
            software_revision: format!("{}{major}.{minor}.{fix}", char::from(class)),
        })
    }

    fn text(&self) -> String {
        let Self { manufacturer, order_number, serial_number, hardware_revision, software_revision } = self;
        format!(
            "manufacturer = {manufacturer}\norder-number = {order_number}\nserial-number = {serial_number}\n\
             hardware-revision = {hardware_revision}\nsoftware-revision = {software_revision}"
        )
    }
}

/// Reads records of the slave and prints their octets.
pub fn read(options: &GaugeOptions, targets: &[String], as_json: bool) -> Result<(), Failure> {
    let wanted = targets.iter().map(|text| Record::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    let done = options.with_records(|records| {
        for record in &wanted {
            match *record {
                Record::At { slot, index } => {
                    let row = RecordRow::raw(slot, index, &get(records, options.address, slot, index)?);
                    if !as_json {
                        out(&format!("{slot}/{index} = {}", row.octets));
                    }
                    rows.push(json_value(&row)?);
                }
                Record::Im0 => {
                    let found = identification(records, options.address)?;
                    if !as_json {
                        out(&found.text());
                    }
                    rows.push(json_value(&found)?);
                }
            }
        }
        Ok(())
    });
    if as_json && (done.is_ok() || !rows.is_empty()) {
        out(&json(&rows));
    }
    done
}

fn json_value(row: &impl Serialize) -> Result<serde_json::Value, Failure> {
    serde_json::to_value(row).map_err(|error| Failure::usage(error.to_string()))
}

fn get(records: &mut dyn Records, address: u8, slot: u8, index: u8) -> Result<Vec<u8>, Failure> {
    records
        .read(slot, index)
        .map_err(|error| Failure::of_record(&format!("{slot}/{index} at address {address}"), error))
}

fn identification(records: &mut dyn Records, address: u8) -> Result<Identification, Failure> {
    let place = format!("I&M0 at address {address}");
    records.write(0, CALL_INDEX, &CALL).map_err(|error| Failure::of_record(&place, error))?;
    let answer = records.read(0, CALL_INDEX).map_err(|error| Failure::of_record(&place, error))?;
    Identification::parse(&answer).ok_or_else(|| {
        Failure::refused(format!("{place}: expected the header {} and 64 octets, got {}", hex(&CALL), hex(&answer)))
    })
}

/// A record that was written, in the JSON output; after a failure with its effect.
#[derive(Debug, Serialize)]
struct WrittenRecord {
    slot: u8,
    index: u8,
    octets: String,
    effect: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

/// Writes octets to a record of the slave, after a confirmation: nothing is checked but their form.
pub fn write(
    options: &GaugeOptions,
    target: &str,
    value: Option<&str>,
    yes: bool,
    as_json: bool,
) -> Result<(), Failure> {
    let wanted = parse_write(target, value).inspect_err(|failure| {
        if as_json {
            print_failure(target, WriteEffect::NotSent, failure);
        }
    });
    let (slot, index, octets) = wanted?;
    let (shown, address) = (hex(&octets), options.address);
    let place = format!("{slot}/{index} at address {address}");
    // The effect of the write; `None` before it.
    let mut effect = None;
    let done = options.with_records(|records| {
        confirm(
            &format!("{shown} goes to {slot}/{index} of the slave at address {address}, and profivac does not know its effect"),
            yes,
        )?;
        let written = records.write(slot, index, &octets);
        effect = Some(written.as_ref().map_or_else(RecordError::write_effect, |()| WriteEffect::Executed));
        written.map_err(|error| failed_write(&place, error))
    });
    let done = done.map_err(|failure| match effect {
        None => before_write(failure),
        Some(_) => failure,
    });
    if as_json {
        let effect = effect.unwrap_or(WriteEffect::NotSent).name();
        let error = done.as_ref().err().map(ToString::to_string);
        out(&json(&WrittenRecord { slot, index, octets: shown, effect, error }));
    } else if done.is_ok() {
        out(&format!("{slot}/{index}: {shown} written"));
    }
    done
}

/// The slot, the index and the octets of a write.
fn parse_write(target: &str, value: Option<&str>) -> Result<(u8, u8, Vec<u8>), Failure> {
    let Record::At { slot, index } = Record::parse(target)? else {
        return Err(Failure::usage("I&M0 is read only: expected SLOT/INDEX like 0/15 with --octets, got im0"));
    };
    let value = value.filter(|value| !value.trim().is_empty());
    let value =
        value.ok_or_else(|| Failure::usage("expected the octets in hex like '11 21' after SLOT/INDEX, got none"))?;
    Ok((slot, index, values::octets(value)?.0))
}

/// The failure of a write to the record that `place` names, with its effect.
fn failed_write(place: &str, error: RecordError) -> Failure {
    let effect = match error.write_effect() {
        WriteEffect::PossiblyExecuted => "; it may have been written, read it",
        WriteEffect::NotSent => "; nothing was written",
        WriteEffect::Refused | WriteEffect::Executed => "",
    };
    let failure = Failure::of_record(place, error);
    failure.with_sentence(&format!("{failure}{effect}"))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_client::records::{Interruption, RefusalCodes};
    use profivac_host::session::SessionError;

    #[test]
    fn a_record_is_slot_and_index_and_never_a_name() {
        assert_eq!(Record::parse("1/19").unwrap(), Record::At { slot: 1, index: 19 });
        assert_eq!(Record::parse("IM0").unwrap(), Record::Im0);
        for text in ["1:2/19", "pirani.process-value", "1/255", "", "19"] {
            assert!(Record::parse(text).unwrap_err().to_string().starts_with("expected SLOT/INDEX"), "{text}");
        }
    }

    #[test]
    fn a_failed_write_says_whether_the_slave_may_have_the_octets() {
        for (error, sentence) in [
            (SessionError::Interrupted.into(), "interrupted by a signal; it may have been written, read it"),
            (Interruption::NoAnswer.into(), "1/24 at address 9: no answer; it may have been written, read it"),
            (RecordError::NotSent(SessionError::Interrupted), "interrupted by a signal; nothing was written"),
            (
                Interruption::KeptConnectionEnded.into(),
                "1/24 at address 9: the connection that was kept has ended, as after a power failure of the gauge; repeat the \
                 request; nothing was written",
            ),
            (
                RecordError::Refused(RefusalCodes { code_1: None, code: 1 }),
                "1/24 at address 9: code 1: parameter not changeable",
            ),
        ] {
            assert_eq!(failed_write("1/24 at address 9", error).to_string(), sentence);
        }
    }

    #[test]
    fn the_identification_is_read_from_its_fields() {
        let mut answer = CALL.to_vec();
        answer.extend([0; 10]);
        answer.extend([0x01, 0x2C]);
        answer.extend(*b"ORDER-4711          ");
        answer.extend(*b"SERIAL 12       ");
        answer.extend([0, 3, b'V', 1, 2, 3]);
        answer.extend([0; 10]);
        assert_eq!(answer.len(), CALL.len() + IM0_LENGTH);
        let found = Identification::parse(&answer).unwrap();
        assert_eq!((found.manufacturer, found.hardware_revision), (300, 3));
        assert_eq!((found.order_number.as_str(), found.serial_number.as_str()), ("ORDER-4711", "SERIAL 12"));
        assert_eq!(found.software_revision, "V1.2.3");
        assert_eq!(Identification::parse(answer.get(..answer.len() - 1).unwrap()), None);
        let mut other = answer.clone();
        other[3] = 0xE9;
        assert_eq!(Identification::parse(&other), None, "the answer to another Call");
    }
}
