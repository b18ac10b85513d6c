//! Values of points as values of OPC UA.

use crate::plan::{DataType, Source};
use opcua_types::{DataValue, DateTime, LocalizedText, StatusCode, UAString, Variant};
use profivac_devices::reading::Quality;
use profivac_gateway::signal::gauge_state;
use profivac_gateway::{Health, PointValue, Signal, Snapshot, State, Value};
use profivac_recorder::{Micros, PointSample, Sample};

/// The microseconds from 1601, where OPC UA counts from, to 1970.
const MICROS_TO_1970: i64 = 11_644_473_600_000_000;

/// The value of a variable in this snapshot.
#[must_use]
pub fn data_value(source: &Source, data_type: DataType, snapshot: &Snapshot) -> Option<DataValue> {
    match source {
        Source::Point(index) => {
            let (point, value) = (snapshot.points.get(*index)?, snapshot.values.get(*index)?);
            Some(of_point(point.signal, data_type, value))
        }
        Source::Health(readings) => Some(health(readings, snapshot, |_, value| Some(value.state.codes().health))),
        Source::DeviceState(points) => Some(health(points, snapshot, health_of_device)),
        Source::Manufacturer(index) => {
            let (point, value) = (snapshot.points.get(*index)?, snapshot.values.get(*index)?);
            Some(manufacturer(data_type, point.vendor.as_deref(), value))
        }
        Source::Model(index) => {
            let (point, value) = (snapshot.points.get(*index)?, snapshot.values.get(*index)?);
            Some(model(data_type, point.vendor.as_deref(), value))
        }
        Source::Blank => Some(stamped(Some(blank(data_type)), StatusCode::Good, Micros::now())),
        Source::Fixed(text) => Some(stamped(Some(given_text(data_type, text)), StatusCode::Good, Micros::now())),
        Source::Unknown => Some(stamped(None, StatusCode::BadNoData, Micros::now())),
    }
}

/// A text as its data type wants it.
fn given_text(data_type: DataType, text: &str) -> Variant {
    match data_type {
        DataType::LocalizedText => Variant::from(LocalizedText::new("", text)),
        _ => Variant::String(UAString::from(text)),
    }
}

/// What DI prescribes for a property that a server does not know.
fn blank(data_type: DataType) -> Variant {
    match data_type {
        DataType::Int32 => Variant::Int32(-1),
        other => given_text(other, ""),
    }
}

/// The vendor of a device; its time is that of the point that names the device.
fn manufacturer(data_type: DataType, vendor: Option<&str>, device: &PointValue) -> DataValue {
    let vendor = vendor.map(|vendor| given_text(data_type, vendor));
    let status = if vendor.is_some() { StatusCode::Good } else { StatusCode::BadNoData };
    stamped(vendor, status, device.at.unwrap_or_else(Micros::now))
}

/// The model of a device. The station names a slave by vendor and model; here the vendor has a node of its own.
fn model(data_type: DataType, vendor: Option<&str>, device: &PointValue) -> DataValue {
    let text = match &device.value {
        Value::Text(text) => &**text,
        _ => "",
    };
    let without_vendor = vendor.and_then(|vendor| text.strip_prefix(vendor)?.strip_prefix(' '));
    let model = given_text(data_type, without_vendor.unwrap_or(text));
    stamped(Some(model), StatusCode::Good, device.at.unwrap_or_else(Micros::now))
}

fn of_point(signal: Signal, data_type: DataType, value: &PointValue) -> DataValue {
    let variant = variant(&value.value, data_type);
    let status = status(signal, value, variant.is_some());
    stamped(variant, status, value.at.unwrap_or_else(Micros::now))
}

/// The status of a value. Words, texts and times about a reading are right also while the reading is not.
fn status(signal: Signal, value: &PointValue, has_value: bool) -> StatusCode {
    let of_state = StatusCode::from(value.state.codes().opcua);
    let is_number = DataType::of(signal) == DataType::Float || DataType::of(signal) == DataType::Double;
    match (has_value, of_state.is_bad()) {
        (true, _) if is_number => of_state,
        (true, _) => StatusCode::Good,
        (false, true) => of_state,
        (false, false) => StatusCode::BadNoData,
    }
}

/// A value with its status and time. Without a value it holds the empty variant: a variable of the library gives a status only together
/// with a value, so a gauge that is gone would be shown as good.
fn stamped(value: Option<Variant>, status: StatusCode, at: Micros) -> DataValue {
    DataValue {
        value: Some(value.unwrap_or(Variant::Empty)),
        status: Some(status),
        source_timestamp: Some(time(at)),
        source_picoseconds: None,
        server_timestamp: Some(DateTime::now()),
        server_picoseconds: None,
    }
}

/// A value that is not known yet.
#[must_use]
pub fn unknown() -> DataValue {
    stamped(None, StatusCode::BadWaitingForInitialData, Micros::now())
}

#[expect(clippy::cast_possible_truncation, reason = "32 bits are the precision of gauges and of PA-DIM")]
const fn float(number: f64) -> Variant {
    Variant::Float(number as f32)
}

/// A value as a variant of the type of its variable; `None` if there is none.
fn variant(value: &Value, data_type: DataType) -> Option<Variant> {
    match value {
        Value::None => None,
        Value::Float(number) if data_type == DataType::Float => Some(float(*number)),
        Value::Float(number) => Some(Variant::Double(*number)),
        Value::Integer(number) => Some(Variant::Int64(*number)),
        Value::Boolean(value) => Some(Variant::Boolean(*value)),
        Value::Text(text) => Some(given_text(data_type, text)),
        Value::Choice(number) => Some(Variant::UInt32(u32::from(*number))),
        Value::Time(at) => Some(Variant::from(time(*at))),
    }
}

/// A time in OPC UA.
#[must_use]
pub fn time(at: Micros) -> DateTime {
    DateTime::from(at.0.saturating_add(MICROS_TO_1970).saturating_mul(10))
}

/// A time of OPC UA, in microseconds since 1970; `None` where the client gave none.
#[must_use]
pub fn micros(time: &DateTime) -> Option<Micros> {
    let ticks = time.checked_ticks();
    (ticks > 0).then(|| Micros((ticks / 10).saturating_sub(MICROS_TO_1970)))
}

/// The health of a device by a point: its state, or its faults.
fn health_of_device(signal: Signal, value: &PointValue) -> Option<Health> {
    match (signal, &value.value) {
        (Signal::GaugeState, Value::Choice(gauge_state::DATA_EXCHANGE)) => Some(Health::Normal),
        (Signal::GaugeState, Value::Choice(gauge_state::STARTING)) => Some(Health::CheckFunction),
        (Signal::GaugeState, Value::Choice(_)) => Some(Health::Failure),
        (Signal::Faults, Value::Text(faults)) if !faults.is_empty() => Some(Health::Failure),
        _ => None,
    }
}

/// The worst health of points: a failure is worse than a check of the function, and that worse than a value out of specification.
fn health(points: &[usize], snapshot: &Snapshot, of: impl Fn(Signal, &PointValue) -> Option<Health>) -> DataValue {
    let found = points.iter().filter_map(|index| Some((snapshot.points.get(*index)?, snapshot.values.get(*index)?)));
    let rank = |health: Health| match health {
        Health::Normal => 0,
        Health::OffSpec => 1,
        Health::CheckFunction => 2,
        Health::Failure => 3,
    };
    let worst = found.clone().filter_map(|(point, value)| of(point.signal, value)).max_by_key(|health| rank(*health));
    let at = found.filter_map(|(_, value)| value.at).max();
    let worst = worst.map(|health| Variant::Int32(health as i32));
    let status = if worst.is_some() { StatusCode::Good } else { StatusCode::BadNoData };
    stamped(worst, status, at.unwrap_or_else(Micros::now))
}

/// The value that a client writes; `None` for an array or another type than a number, a text, or true and false.
#[must_use]
pub fn given(variant: &Variant) -> Option<Value> {
    Some(match variant {
        // Through the decimal number, so that 5e-3 as 32 bits stays 5e-3.
        Variant::Float(number) => Value::Float(number.to_string().parse().ok()?),
        Variant::Double(number) => Value::Float(*number),
        Variant::SByte(number) => Value::Float(f64::from(*number)),
        Variant::Byte(number) => Value::Float(f64::from(*number)),
        Variant::Int16(number) => Value::Float(f64::from(*number)),
        Variant::UInt16(number) => Value::Float(f64::from(*number)),
        Variant::Int32(number) => Value::Float(f64::from(*number)),
        Variant::UInt32(number) => Value::Float(f64::from(*number)),
        Variant::Boolean(value) => Value::Boolean(*value),
        Variant::String(text) => Value::Text(text.as_ref().into()),
        _ => return None,
    })
}

/// A recorded pressure.
#[must_use]
pub fn of_sample(sample: &Sample) -> DataValue {
    recorded(sample.pa, sample.quality, sample.at, DataType::Float)
}

/// A recorded value of a point of a slave. Its time is that of the data exchange, or of the answer to its record.
#[must_use]
pub fn of_point_sample(sample: &PointSample, data_type: DataType) -> DataValue {
    recorded(sample.number, sample.quality, sample.at, data_type)
}

/// A recorded number with the status of its quality.
fn recorded(number: Option<f64>, quality: Quality, at: Micros, data_type: DataType) -> DataValue {
    let state = State::recorded(quality);
    let number = number.filter(|_| state.codes().has_value);
    let value = number.and_then(|number| variant(&Value::Float(number), data_type));
    stamped(value, StatusCode::from(state.codes().opcua), at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use opcua_server::address_space::Variable;
    use opcua_types::{DataEncoding, NumericRange, TimestampsToReturn};

    const EMPTY: Option<Variant> = Some(Variant::Empty);

    fn point(value: Value, state: State) -> PointValue {
        PointValue { value, state, at: Some(Micros(1_000_000)), version: 1 }
    }

    fn shown(signal: Signal, value: Value, state: State) -> (Option<Variant>, u32) {
        let value = of_point(signal, DataType::of(signal), &point(value, state));
        (value.value, value.status.unwrap().bits())
    }

    #[test]
    fn a_pressure_has_the_status_of_its_state() {
        assert_eq!(shown(Signal::Pressure, Value::Float(1.5), State::Ok), (Some(Variant::Float(1.5)), 0));
        let over = shown(Signal::Pressure, Value::Float(1.5), State::OverRange);
        assert_eq!(over, (Some(Variant::Float(1.5)), 0x4094_0000));
        assert_eq!(shown(Signal::Pressure, Value::None, State::Stale), (EMPTY, 0x8031_0000));
        assert_eq!(shown(Signal::Pressure, Value::None, State::Off), (EMPTY, 0x808D_0000));
    }

    #[test]
    fn a_client_reads_the_status_of_a_pressure_that_has_no_value() {
        let value = of_point(Signal::Pressure, DataType::Float, &point(Value::None, State::Stale));
        let mut variable = Variable::default();
        variable.set_data_value(value);
        let read = variable.value(TimestampsToReturn::Both, &NumericRange::None, &DataEncoding::Binary, 0.0);
        assert_eq!(read.status, Some(StatusCode::BadNoCommunication));
    }

    #[test]
    fn the_state_of_a_silent_gauge_is_a_good_value() {
        assert_eq!(shown(Signal::State, Value::Choice(7), State::Stale), (Some(Variant::UInt32(7)), 0));
        assert_eq!(shown(Signal::Usable, Value::Boolean(false), State::Stale), (Some(Variant::Boolean(false)), 0));
    }

    #[test]
    fn what_is_not_known_is_no_good_value() {
        assert_eq!(shown(Signal::CycleTime, Value::None, State::Ok), (EMPTY, StatusCode::BadNoData.bits()));
        // Over the range there is a bound of the pressure, but no corrected pressure.
        assert_eq!(shown(Signal::CorrectedPressure, Value::None, State::OverRange).1, StatusCode::BadNoData.bits());
    }

    #[test]
    fn the_time_is_that_of_the_reading() {
        let value = of_point(Signal::Pressure, DataType::Float, &point(Value::Float(1.0), State::Ok));
        assert_eq!(value.source_timestamp.unwrap().to_rfc3339(), "1970-01-01T00:00:01.000Z");
        assert_eq!(micros(&time(Micros(1_234_567))), Some(Micros(1_234_567)));
        assert_eq!(micros(&DateTime::null()), None);
    }

    #[test]
    fn a_gap_of_the_record_has_no_value() {
        let value = of_sample(&Sample::new(Micros(5), None, Quality::Stale));
        assert_eq!((value.value, value.status.unwrap().bits()), (EMPTY, 0x8031_0000));
    }

    #[test]
    fn a_recorded_value_of_a_point_has_the_type_of_its_node_the_status_of_its_quality_and_the_time_of_the_exchange() {
        let shown = |number, quality, data_type| {
            let value = of_point_sample(&PointSample::new(Micros(1_000_000), number, quality), data_type);
            assert_eq!(value.source_timestamp.unwrap().to_rfc3339(), "1970-01-01T00:00:01.000Z");
            (value.value, value.status.unwrap().bits())
        };
        // Zero and negative numbers are values of a point, and no pressures.
        for number in [0.0, -40.0, 429_496_729.4] {
            assert_eq!(shown(Some(number), Quality::Valid, DataType::Double), (Some(Variant::Double(number)), 0));
        }
        assert_eq!(shown(Some(1.5), Quality::Valid, DataType::Float), (Some(Variant::Float(1.5)), 0));
        assert_eq!(shown(None, Quality::Fault, DataType::Double), (EMPTY, 0x808C_0000));
        assert_eq!(shown(None, Quality::Stale, DataType::Double), (EMPTY, 0x8031_0000));
    }
}
