//! Cyclic data, sensors and front panel of TPG300 and TPG500.

use super::TpgBehaviour;
use super::channel::{REFRESH_S, TpgChannel, TpgGauge};
use super::codes::{MeasurementStatus, Volatility};
use super::control::RELAYS;
use super::table;
use super::threshold::ThresholdSet;
use crate::model::{Fault, Field, MeasuringRange, Model, Octets, Part, Unit};
use crate::profile::{Behaviour, Presentation};
use crate::simulation::{Drive, FrontPanel, Led, PartReading, ReportedState, StateReport, SwitchName};

impl Behaviour for TpgBehaviour {
    fn model(&self) -> &'static Model {
        self.model
    }

    /// The settings have the unit, and the number of channel modules changes only the telegram.
    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        None
    }

    fn set_unit(&mut self, unit: &'static Unit) {
        self.settings.unit = unit;
        self.kept.unit = unit;
    }

    /// The controller has no device state that data exchange could change.
    fn set_exchanging(&mut self, _running: bool) {}

    fn output(&mut self, field: Field, octets: &[u8]) {
        if let (Field::SensorOnOff, [octet]) = (field, octets) {
            self.command(*octet);
            self.update();
        }
    }

    fn input(&self, field: Field) -> Octets {
        let format = table::format(self.settings.unit);
        match field {
            Field::ChannelValue(channel, _) => format.encode(self.measured_pa(channel)),
            Field::ChannelMantissa(channel) => Octets::new(&mantissa(format.number_from_pa(self.measured_pa(channel)))),
            Field::MeasurementStatus(channel) => Octets::new(&[self.status(channel) as u8]),
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    fn start(&mut self) {
        *self = Self {
            channels: self.channels.each_ref().map(TpgChannel::restarted),
            faults: self.faults,
            ..Self::new(self.model, self.channels.each_ref().map(TpgChannel::gauge))
        };
    }

    fn update(&mut self) {
        if core::mem::take(&mut self.starting) {
            // A power cut while the settings are stored must not leave thresholds crossed.
            self.settings.limits.iter_mut().for_each(ThresholdSet::uncross);
            self.start_hot();
        }
        self.control();
    }

    fn parts(&self) -> &[Part] {
        self.fitted.parts()
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        let channel = self.fitted.channel(part).and_then(|channel| self.channels.get(channel));
        channel.and_then(TpgChannel::gauge).unwrap_or(TpgGauge::Pirani).measuring_range()
    }

    fn drive(&self, part: usize) -> Drive {
        let channel = self.fitted.channel(part).and_then(|channel| self.channels.get(channel));
        if channel.is_some_and(TpgChannel::is_on) { Drive::On } else { Drive::Off }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        if let Some(channel) = self.fitted.channel(part).and_then(|channel| self.channels.get_mut(channel)) {
            channel.sense(pa);
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.since_refresh_s += seconds;
        let due_s = libm::floor(self.since_refresh_s / REFRESH_S) * REFRESH_S;
        if due_s > 0.0 {
            self.since_refresh_s -= due_s;
            self.volatility = Volatility::ReadyToStore;
            for (channel, filter) in self.channels.iter_mut().zip(self.settings.filters) {
                channel.refresh(due_s, filter);
            }
        }
    }

    fn settle(&mut self) {
        self.volatility = Volatility::ReadyToStore;
        self.channels.iter_mut().for_each(TpgChannel::settle);
    }

    fn front_panel(&self) -> FrontPanel {
        FrontPanel { switches: &[SwitchName::Address], buttons: 0, potentiometers: &[] }
    }

    fn set_fault(&mut self, fault: Fault, active: bool) {
        self.faults.set(fault, active);
        for (channel, failed) in self.channels.iter_mut().zip(self.faults.failed()) {
            channel.failed = failed;
        }
    }

    fn has_alarm(&self) -> bool {
        self.parts().iter().any(|part| self.status(part.instance) == MeasurementStatus::Error)
    }

    fn report(&self) -> StateReport {
        let indicated = self.parts().iter().map(|part| PartReading {
            instance: part.instance,
            value_mbar: self.measured_pa(part.instance) / 100.0,
            valid: self.status(part.instance) == MeasurementStatus::Ok,
        });
        let cathodes = self.channels.iter().filter(|channel| channel.gauge() == Some(TpgGauge::ColdCathode));
        StateReport {
            device_state: ReportedState::None,
            led: Led::None,
            relays: self.thresholds.iter().take(RELAYS.len()).map(|threshold| threshold.activated).collect(),
            indicated: indicated.collect(),
            emission: cathodes.map(TpgChannel::is_on).collect(),
            ..StateReport::default()
        }
    }
}

/// Inficon floating point format: a signed word with three significant digits and a signed power of ten.
/// errata-bpg-bcg-tpg 126.
fn mantissa(number: f64) -> [u8; 3] {
    if number <= 0.0 {
        return [0; 3];
    }
    let exponent = libm::floor(libm::log10(number)) - 2.0;
    let digits = libm::round(number / libm::exp10(exponent));
    // 999.7 is 100 x 10^1, and so is a power of ten whose logarithm falls short of it.
    let (digits, exponent) = if digits >= 1000.0 { (100.0, exponent + 1.0) } else { (digits, exponent) };
    #[expect(clippy::cast_possible_truncation, reason = "100 to 999, and the exponents of a float")]
    let ([high, low], [power]) = ((digits as i16).to_be_bytes(), (exponent as i8).to_be_bytes());
    [high, low, power]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mantissa_has_three_digits() {
        for (number, digits, power) in [
            (8.3e-3, 830, -5),
            (1000.0, 100, 1),
            (999.4, 999, 0),
            (999.6, 100, 1),
            (1e-9, 100, -11),
            (0.001, 100, -5),
            (5.25e-7, 525, -9),
            (1e5, 100, 3),
        ] {
            let [high, low] = i16::to_be_bytes(digits);
            assert_eq!(mantissa(number), [high, low, i8::to_be_bytes(power)[0]], "{number}");
        }
        assert_eq!(mantissa(0.0), [0; 3]);
    }
}
