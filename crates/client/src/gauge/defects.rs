//! The defects of a gauge in the words of its manual: what Exception Status only announces.
//!
//! | Device | Record |
//! |---|---|
//! | BPG, HPG, BCG, PCG, PSG | Exception Detail Alarm of the device block: tira36e1 and tira41d1 3.1.1.11, tira56e1 7.1.12 |
//! | IMG 400 | Sensor Alarm of each channel: BG 5530 4.4.4 to 4.4.6 |
//!
//! Both are read without moving a Channel Instance Selector.

use super::Gauge;
use crate::cyclic::exception_texts;
use crate::error::ClientError;
use crate::names::NamedParameter;
use crate::records::Records;
use profivac_devices::model::{Model, Role};
use profivac_devices::profile::{CommonExceptions, ExceptionStatus};

/// The bits of Common Exception Detail 0: tira56e1 7.1.12, table 28.
const COMMON: [(CommonExceptions, &str); 7] = [
    (CommonExceptions::DIAGNOSTIC, "internal diagnostic exception"),
    (CommonExceptions::PROCESSOR, "microprocessor exception"),
    (CommonExceptions::EPROM, "EPROM exception"),
    (CommonExceptions::EEPROM, "EEPROM exception"),
    (CommonExceptions::RAM, "RAM exception"),
    (CommonExceptions::COMMUNICATION, "communications exception"),
    (CommonExceptions::REAL_TIME, "internal real-time exception"),
];

/// The defects of a gauge by the groups of Exception Status.
///
/// ```
/// use profivac_client::Defects;
/// use profivac_devices::profile::ExceptionStatus;
///
/// let defects = Defects { device: vec!["Pirani: sensor failure".to_owned()], ..Defects::default() };
/// let exception = ExceptionStatus::ALARM_COMMON | ExceptionStatus::ALARM_DEVICE;
/// assert_eq!(defects.texts(exception), ["common alarm", "Pirani: sensor failure"]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Defects {
    /// Of the common group.
    pub common: Vec<String>,
    /// Of the device group: those of the measuring parts and channels.
    pub device: Vec<String>,
    /// Of the manufacturer group.
    pub manufacturer: Vec<String>,
}

impl Defects {
    /// The alarms of an Exception Status: each group by its defects, or by its name if no defect is known.
    #[must_use]
    pub fn texts(&self, exception: ExceptionStatus) -> Vec<String> {
        let groups = [
            (ExceptionStatus::ALARM_COMMON, &self.common),
            (ExceptionStatus::ALARM_DEVICE, &self.device),
            (ExceptionStatus::ALARM_MANUFACTURER, &self.manufacturer),
        ];
        let set = groups.into_iter().filter(|(group, _)| exception.contains(*group));
        let texts = |(group, defects): (ExceptionStatus, &Vec<String>)| match &defects[..] {
            [] => exception_texts(group).into_iter().map(str::to_owned).collect(),
            _ => defects.clone(),
        };
        set.flat_map(texts).collect()
    }

    /// The defects in an Exception Detail Alarm: each group after its size.
    fn in_detail(model: &Model, record: &[u8]) -> Self {
        let (common, rest) = group(record);
        let (device, rest) = group(rest);
        let (manufacturer, _) = group(rest);
        let common = CommonExceptions::from_bits_retain(common.first().copied().unwrap_or_default());
        let manufacturer = manufacturer.first().copied().unwrap_or_default();
        let pairs = model.alarms.instances.iter().zip(device.as_chunks::<2>().0);
        let of_part = |(instance, octets): (&u8, &[u8; 2])| {
            let part = part_name(model, *instance);
            model.alarms.sensor_alarms(*octets).map(move |name| format!("{part}: {name}"))
        };
        let own = model.alarms.manufacturer.iter().filter(|(mask, _)| manufacturer & mask != 0);
        Self {
            common: COMMON
                .iter()
                .filter(|(bit, _)| common.contains(*bit))
                .map(|(_, name)| (*name).to_owned())
                .collect(),
            device: pairs.flat_map(of_part).collect(),
            manufacturer: own.map(|(_, name)| (*name).to_owned()).collect(),
        }
    }
}

/// The octets of a group behind their number, and the octets after them.
fn group(record: &[u8]) -> (&[u8], &[u8]) {
    let Some((size, rest)) = record.split_first() else { return (&[], &[]) };
    rest.split_at_checked((*size).into()).unwrap_or((rest, &[]))
}

/// The measuring part of an instance in a sentence.
fn part_name(model: &Model, instance: u8) -> &'static str {
    let part = model.parts.iter().map(|spec| spec.part).find(|part| part.instance == instance);
    part.map_or("the gauge", |part| part.principle.part_name())
}

impl<R: Records> Gauge<R> {
    /// Reads the defects behind the alarms of Exception Status. Empty for a device without such records.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let defects = bus.gauge(5)?.defects()?;
    /// assert!(defects.device.is_empty(), "the gauge works");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The errors of reading. A channel that refuses its Sensor Alarm has no gauge, and no defect.
    pub fn defects(&mut self) -> Result<Defects, ClientError> {
        let names = self.names();
        let of_role = |role| names.all().iter().filter(move |named| named.parameter.row.role == Some(role));
        if let Some(detail) = of_role(Role::AlarmDetail).next() {
            let reading = self.read_parameter(detail)?;
            return Ok(Defects::in_detail(self.model, &reading.octets));
        }
        let mut defects = Defects::default();
        let mut last_slot = None;
        // A channel accepts several gauges, whose blocks share a slot. A row of an instance would move the selector.
        for alarm in of_role(Role::SensorAlarm).filter(|alarm| alarm.parameter.location.instance == 0) {
            let slot = alarm.parameter.location.slot;
            if last_slot.replace(slot) != Some(slot) {
                defects.device.extend(self.channel_alarms(alarm)?);
            }
        }
        Ok(defects)
    }

    /// The defects of a channel.
    fn channel_alarms(&mut self, alarm: &NamedParameter) -> Result<Vec<String>, ClientError> {
        let slot = alarm.parameter.location.slot;
        let octets = match self.read_parameter(alarm) {
            Err(ClientError::Refused { .. }) => return Ok(Vec::new()),
            reading => reading?.octets,
        };
        let Ok(octets) = <[u8; 2]>::try_from(octets) else { return Ok(Vec::new()) };
        let names = self.model.alarms.sensor_alarms(octets);
        Ok(names.map(|name| format!("channel {slot}: {name}")).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::MODELS;
    use profivac_devices::{bcg450, pxg55x};

    #[test]
    fn the_octets_of_exception_detail_alarm_are_named_as_the_manual_orders_them() {
        let bcg450 = &bcg450::table::MODEL;
        // tira41d1 3.1.1.11: CDG, Pirani, BA.
        let found = Defects::in_detail(bcg450, &[2, 0x04, 0, 6, 0, 0, 0, 2, 0, 2, 1, 1]);
        assert_eq!(found.common, ["EPROM exception"]);
        assert_eq!(
            found.device,
            ["Pirani: electronics or sensor failure", "ionisation part: electronics or sensor failure"]
        );
        assert_eq!(found.manufacturer, ["internal communication error"]);
        let pcg550 = &pxg55x::table::VARIANTS[0].model;
        let found = Defects::in_detail(pcg550, &[2, 0, 0, 4, 1, 0, 0, 2, 1, 2]);
        assert_eq!(found.device, ["diaphragm: sensor element failure", "Pirani: electronics failure"]);
        assert_eq!(found.manufacturer, ["incompatible software"]);
    }

    #[test]
    fn a_record_that_is_cut_off_names_what_it_has() {
        let bcg450 = &bcg450::table::MODEL;
        assert_eq!(Defects::in_detail(bcg450, &[]), Defects::default());
        assert_eq!(Defects::in_detail(bcg450, &[2, 0x10]).common, ["RAM exception"]);
        assert_eq!(
            Defects::in_detail(bcg450, &[2, 0, 0, 250, 0, 2]).device,
            ["diaphragm: electronics or sensor failure"]
        );
    }

    #[test]
    fn a_group_without_known_defects_keeps_its_name() {
        let alarms = ExceptionStatus::ALARM_DEVICE | ExceptionStatus::ALARM_MANUFACTURER;
        let known = Defects { device: vec!["channel 1: electronics failure".to_owned()], ..Defects::default() };
        assert_eq!(known.texts(alarms), ["channel 1: electronics failure", "manufacturer alarm"]);
        assert_eq!(Defects::default().texts(alarms), ["device alarm", "manufacturer alarm"]);
        assert!(known.texts(ExceptionStatus::WARNING_DEVICE).is_empty());
    }

    #[test]
    fn every_instance_of_an_alarm_detail_is_a_part_of_the_device_or_of_its_series() {
        for model in MODELS {
            let known: Vec<_> =
                model.alarms.instances.iter().filter(|it| part_name(model, **it) != "the gauge").collect();
            // A PSG55x has one part, and one pair of octets.
            assert!(known.len() == model.alarms.instances.len() || model.parts.len() == 1, "{}", model.name);
        }
    }
}
