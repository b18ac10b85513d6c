//! One slave at one moment, and its forms in CSV, JSON and tables.

use profivac_client::cyclic::{Cause, ChannelValue, CyclicSlave};
use profivac_client::values::{cyclic_text, hex};
use profivac_devices::model::{Scale, Unit};
use profivac_devices::reading::Quality;
use profivac_dp::master::HandlerState;
use profivac_host::session::BusMaster;
use profivac_recorder::export::seven_digits;
use serde::{Serialize, Serializer};
use std::fmt;

/// A value of a slave at one moment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Seconds since 1970.
    pub unix_time: f64,
    /// The name of the segment, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segment: Option<String>,
    pub address: u8,
    /// The model, or the ident number of a slave that is no known device.
    pub device: String,
    /// In `unit`; `None` unless it is valid.
    pub pressure: Option<f64>,
    pub unit: &'static str,
    pub mbar: Option<f64>,
    /// The measuring part.
    pub instance: u8,
    /// The state of the slave.
    pub state: RowState,
    /// Faults and warnings.
    pub remarks: Vec<String>,
    pub exchanges: u32,
    pub lost: u32,
    /// Whether the value is a pressure, and if not, why; `None` without a value.
    #[serde(serialize_with = "quality_word")]
    pub quality: Option<Quality>,
    /// The end of the range, of a pressure below or above it.
    pub limit_mbar: Option<f64>,
    /// The same in `unit`.
    #[serde(skip)]
    pub limit: Option<f64>,
    /// The inputs of a slave that is no known device, or whose tables name values in them, in hex.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inputs: Option<String>,
    /// The same by module, if a GSD file names them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modules: Vec<ModuleInputs>,
    /// Values in the inputs that are no pressures, if a device file names them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<NamedValue>,
}

/// A value in the inputs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedValue {
    /// Its name in the device file.
    pub name: &'static str,
    /// The number with its unit, or the text of a code.
    pub value: String,
}

/// The inputs of a module.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ModuleInputs {
    pub slot: u32,
    /// Its name in the GSD file.
    pub module: String,
    /// In hex.
    pub inputs: String,
}

/// The state of a slave in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowState {
    /// The master does not have the slave.
    Unknown,
    /// The state of the slave in the master.
    Handler(HandlerState),
    /// A slave of another master, whose inputs this master reads.
    Read,
    /// No answer, or no port.
    Offline,
}

impl fmt::Display for RowState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => formatter.pad(""),
            Self::Handler(state) => formatter.pad(&state.to_string()),
            Self::Read => formatter.pad("READ"),
            Self::Offline => formatter.pad("OFFLINE"),
        }
    }
}

impl Serialize for RowState {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn quality_word<S: Serializer>(quality: &Option<Quality>, serializer: S) -> Result<S::Ok, S::Error> {
    quality.map(Quality::word).serialize(serializer)
}

/// The columns of CSV, in the order of [`Row::csv`].
pub fn csv_columns(with_segment: bool) -> String {
    let segment = if with_segment { "segment," } else { "" };
    format!(
        "unix_time,{segment}address,device,pressure,unit,mbar,instance,state,remarks,exchanges,lost,quality,limit_mbar,inputs"
    )
}

impl Row {
    /// The rows of a slave: one for each of its values, and at least one.
    pub fn of(segment: Option<&str>, cyclic: &CyclicSlave, master: &BusMaster, unix_time: f64) -> Vec<Self> {
        let address = cyclic.address;
        let reading = master.inputs(address).map(|inputs| cyclic.decode_inputs(inputs)).unwrap_or_default();
        let (_, unit) = in_unit(None, cyclic.unit);
        let device = cyclic.model.name.to_owned();
        let mut slave = Self { unit, ..Self::empty(segment, address, device, unix_time).with_master(master) };
        let inputs = master.inputs(address).unwrap_or_default();
        let named = cyclic.model.values_of(cyclic.configuration, false);
        let named = named.filter_map(|it| Some(NamedValue { name: it.name, value: cyclic_text(it, inputs)? }));
        slave.values = named.collect();
        slave.inputs = (!slave.values.is_empty()).then(|| hex(inputs));
        slave.remarks.extend(reading.alarms().into_iter().chain(reading.warnings()).map(str::to_owned));
        if reading.values.is_empty() {
            return vec![slave];
        }
        reading.values.iter().map(|value| slave.with_value(value, cyclic.unit)).collect()
    }

    /// A row without values.
    pub fn empty(segment: Option<&str>, address: u8, device: String, unix_time: f64) -> Self {
        Self {
            unix_time,
            segment: segment.map(str::to_owned),
            address,
            device,
            pressure: None,
            unit: "",
            mbar: None,
            instance: 0,
            state: RowState::Unknown,
            remarks: Vec::new(),
            exchanges: 0,
            lost: 0,
            quality: None,
            limit_mbar: None,
            limit: None,
            inputs: None,
            modules: Vec::new(),
            values: Vec::new(),
        }
    }

    /// The same slave with its state in the master.
    pub fn with_master(self, master: &BusMaster) -> Self {
        let counters = master.counters(self.address).copied().unwrap_or_default();
        let error = master.exchange_error(self.address);
        Self {
            state: master.state(self.address).map_or(RowState::Unknown, RowState::Handler),
            remarks: error.into_iter().map(|error| error.to_string()).collect(),
            exchanges: counters.exchanges,
            lost: counters.lost,
            ..self
        }
    }

    /// The same slave with its inputs in hex.
    pub fn with_inputs(self, inputs: Option<String>) -> Self {
        Self { inputs, ..self }
    }

    /// The same slave with its inputs by module.
    pub fn with_modules(self, modules: Option<Vec<ModuleInputs>>) -> Self {
        Self { modules: modules.unwrap_or_default(), ..self }
    }

    /// The slave does not exchange data for this reason, and has no value.
    pub fn set_offline(&mut self, reason: &str) {
        self.state = RowState::Offline;
        self.remarks = vec![reason.to_owned()];
        (self.pressure, self.mbar, self.limit, self.limit_mbar) = (None, None, None, None);
        (self.quality, self.inputs) = (None, None);
        self.modules.clear();
        self.values.clear();
    }

    /// The same slave with one of its values.
    fn with_value(&self, value: &ChannelValue, unit: &'static Unit) -> Self {
        let in_mbar = |pa: Option<f64>| pa.map(|pa| seven_digits(pa / 100.0));
        let (mbar, limit_mbar) = (in_mbar(value.pa), in_mbar(value.limit_pa));
        let (limit, _) = in_unit(limit_mbar, unit);
        let (pressure, unit) = in_unit(mbar, unit);
        let remarks = remark(value).into_iter().chain(self.remarks.iter().cloned()).collect();
        let quality = Some(value.quality);
        Self { pressure, unit, mbar, instance: value.instance, remarks, quality, limit_mbar, limit, ..self.clone() }
    }

    /// Whether the slave exchanges data, or is read.
    pub fn is_exchanging(&self) -> bool {
        matches!(self.state, RowState::Handler(HandlerState::Data { .. }) | RowState::Read)
    }

    /// The pressure with its unit, the end of the range, or the reason why there is no pressure; `-` without a value.
    pub fn pressure_text(&self) -> String {
        let unit = self.unit;
        match (self.quality, self.pressure, self.limit) {
            (_, Some(pressure), _) => format!("{pressure:.3e} {unit}"),
            (Some(Quality::Underrange), None, Some(limit)) => format!("< {limit:.3e} {unit}"),
            (Some(Quality::Overrange), None, Some(limit)) => format!("> {limit:.3e} {unit}"),
            (Some(quality), None, _) => quality.label().to_owned(),
            (None, None, _) => "-".to_owned(),
        }
    }

    /// Faults and warnings as one text.
    pub fn remarks_text(&self) -> String {
        self.remarks.join("; ")
    }

    /// Inputs, faults and warnings as one text.
    pub fn inputs_and_remarks_text(&self) -> String {
        let by_module = |one: &ModuleInputs| format!("slot {} {}: {}", one.slot, one.module, one.inputs);
        let by_name = |one: &NamedValue| format!("{} {}", one.name, one.value);
        let inputs = match (self.modules.is_empty(), &self.inputs) {
            _ if !self.values.is_empty() => self.values.iter().map(by_name).collect(),
            (true, inputs) => inputs.iter().map(|octets| format!("inputs {octets}")).collect(),
            (false, _) => self.modules.iter().map(by_module).collect::<Vec<_>>(),
        };
        inputs.into_iter().chain(self.remarks.iter().cloned()).collect::<Vec<_>>().join("; ")
    }

    /// One line of CSV.
    pub fn csv(&self) -> String {
        let number = |number: Option<f64>| number.map_or_else(String::new, |number| format!("{number:e}"));
        let time = Some(format!("{:.3}", self.unix_time));
        let columns = [
            self.address.to_string(),
            csv_field(&self.device),
            number(self.pressure),
            self.unit.to_owned(),
            number(self.mbar),
            self.instance.to_string(),
            self.state.to_string(),
            quoted(&self.remarks_text()),
            self.exchanges.to_string(),
            self.lost.to_string(),
            self.quality.map_or("", Quality::word).to_owned(),
            number(self.limit_mbar),
            self.inputs.clone().unwrap_or_default(),
        ];
        let segment = self.segment.as_deref().map(quoted);
        time.into_iter().chain(segment).chain(columns).collect::<Vec<_>>().join(",")
    }

    /// One line of a table.
    pub fn line(&self) -> String {
        let segment = self.segment.as_deref().map_or_else(String::new, segment_column);
        format!(
            "{segment}{:>4}  {:<10}{:>4}  {:<18}{:<10}{:>10}{:>6}  {}",
            self.address,
            self.device,
            self.instance,
            self.pressure_text(),
            self.state,
            self.exchanges,
            self.lost,
            self.inputs_and_remarks_text()
        )
        .trim_end()
        .to_owned()
    }
}

/// The quality of a value that is not valid, in words. The alarms of the device are remarks of their own.
fn remark(value: &ChannelValue) -> Option<String> {
    match (value.quality, value.cause) {
        (Quality::Valid, _) => None,
        (quality, None | Some(Cause::Alarms(_))) => Some(quality.label().to_owned()),
        (_, Some(_)) => Some(value.text()),
    }
}

/// The header of a table of [`Row::line`].
pub fn header(with_segment: bool) -> String {
    let segment = if with_segment { segment_column("SEGMENT") } else { String::new() };
    format!(
        "{segment}{:>4}  {:<10}{:>4}  {:<18}{:<10}{:>10}{:>6}  {}",
        "ADDR", "DEVICE", "PART", "PRESSURE", "STATE", "CYCLES", "LOST", "REMARKS"
    )
}

fn segment_column(text: &str) -> String {
    format!("{text:<12} ")
}

/// A text as a quoted CSV field.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// A text as a CSV field, quoted if it needs to be (RFC 4180).
fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\r', '\n']) { quoted(text) } else { text.to_owned() }
}

/// A pressure in the unit of the slave; in mbar instead of COUNTS.
const fn in_unit(mbar: Option<f64>, unit: &'static Unit) -> (Option<f64>, &'static str) {
    match (mbar, unit.scale) {
        (Some(mbar), Scale::PerMbar(factor)) => (Some(mbar * factor), unit.name),
        (None, Scale::PerMbar(_)) => (None, unit.name),
        (mbar, Scale::Counts) => (mbar, "mbar"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;

    fn row(unit: &str, pa: Option<f64>) -> Row {
        let slave = Row {
            state: RowState::Handler(HandlerState::Data { diag: false }),
            remarks: vec!["device warning".to_owned()],
            exchanges: 1234,
            lost: 5,
            ..Row::empty(None, 5, "bcg450".to_owned(), 1.5)
        };
        let quality = if pa.is_some() { Quality::Valid } else { Quality::Underrange };
        let limit_pa = pa.is_none().then_some(0.05);
        let value = ChannelValue { instance: 2, quality, cause: None, pa, limit_pa };
        slave.with_value(&value, MODEL.unit_named(unit).unwrap())
    }

    #[test]
    fn a_pressure_is_shown_in_the_unit_of_the_slave_with_its_digits() {
        let pa = f64::from(5e-6_f32) * 100.0;
        assert_eq!(row("mbar", Some(pa)).pressure_text(), "5.000e-6 mbar");
        assert_eq!(row("mbar", Some(pa)).mbar, Some(5e-6));
        assert_eq!(row("Pascal", Some(pa)).pressure_text(), "5.000e-4 Pascal");
        assert_eq!(row("COUNTS", Some(pa)).pressure_text(), "5.000e-6 mbar");
        assert_eq!(row("mbar", None).pressure_text(), "< 5.000e-4 mbar");
        assert_eq!(row("Pascal", None).pressure_text(), "< 5.000e-2 Pascal");
        assert_eq!((row("mbar", None).pressure, row("mbar", None).limit_mbar), (None, Some(5e-4)));
        assert_eq!(row("mbar", None).remarks, ["under range", "device warning"]);
    }

    #[test]
    fn every_form_has_the_same_values() {
        let row = row("mbar", Some(5e-4));
        assert_eq!(row.csv(), "1.500,5,bcg450,5e-6,mbar,5e-6,2,DATA,\"device warning\",1234,5,valid,,");
        assert_eq!(row.csv().split(',').count(), csv_columns(false).split(',').count());
        let table = "\
ADDR  DEVICE    PART  PRESSURE          STATE         CYCLES  LOST  REMARKS
   5  bcg450       2  5.000e-6 mbar     DATA            1234     5  device warning";
        assert_eq!([header(false), row.line()].join("\n"), table);
        let json = serde_json::to_string(&row).unwrap();
        let expected = "{\"unix_time\":1.5,\"address\":5,\"device\":\"bcg450\",\"pressure\":5e-6,\"unit\":\"mbar\",\
                        \"mbar\":5e-6,\"instance\":2,\"state\":\"DATA\",\
                        \"remarks\":[\"device warning\"],\"exchanges\":1234,\"lost\":5,\
                        \"quality\":\"valid\",\"limit_mbar\":null}";
        assert_eq!(json, expected);
    }

    #[test]
    fn the_inputs_of_an_unknown_slave_are_octets_in_every_form() {
        let row = Row {
            state: RowState::Handler(HandlerState::Data { diag: false }),
            exchanges: 7,
            inputs: Some("AA 55".to_owned()),
            ..Row::empty(None, 9, "0x1234".to_owned(), 1.5)
        };
        assert_eq!(row.csv(), "1.500,9,0x1234,,,,0,DATA,\"\",7,0,,,AA 55");
        let table = "   9  0x1234       0  -                 DATA               7     0  inputs AA 55";
        assert_eq!(row.line(), table);
        let json = serde_json::to_string(&row).unwrap();
        assert!(json.contains("\"device\":\"0x1234\",\"pressure\":null"), "{json}");
        assert!(json.ends_with("\"limit_mbar\":null,\"inputs\":\"AA 55\"}"), "{json}");
    }

    #[test]
    fn the_values_of_a_device_file_have_their_names_and_csv_has_the_octets() {
        let row = Row {
            inputs: Some("07 D0 03".to_owned()),
            values: vec![
                NamedValue { name: "speed", value: "1000 Hz".to_owned() },
                NamedValue { name: "state", value: "at speed".to_owned() },
            ],
            remarks: vec!["device warning".to_owned()],
            ..Row::empty(None, 9, "turbo".to_owned(), 1.5)
        };
        assert_eq!(row.inputs_and_remarks_text(), "speed 1000 Hz; state at speed; device warning");
        assert!(row.csv().ends_with(",07 D0 03"), "{}", row.csv());
        let json = serde_json::to_string(&row).unwrap();
        assert!(
            json.ends_with(
                "\"values\":[{\"name\":\"speed\",\"value\":\"1000 Hz\"},{\"name\":\"state\",\"value\":\"at speed\"}]}"
            ),
            "{json}"
        );
        let mut offline = row;
        offline.set_offline("no answer");
        assert!(offline.values.is_empty());
    }

    #[test]
    fn the_model_of_a_gsd_file_is_one_column_of_csv() {
        let row = Row::empty(None, 9, "Valves, 24 V \"HF\"".to_owned(), 1.5);
        assert!(row.csv().starts_with("1.500,9,\"Valves, 24 V \"\"HF\"\"\",,,"), "{}", row.csv());
        let row = Row::empty(None, 9, "Valve station".to_owned(), 1.5);
        assert!(row.csv().starts_with("1.500,9,Valve station,,,"), "{}", row.csv());
    }

    #[test]
    fn every_form_names_the_segment_if_there_are_several() {
        let row = Row { segment: Some("hall, \"north\"".to_owned()), ..row("mbar", Some(5e-4)) };
        assert!(row.csv().starts_with("1.500,\"hall, \"\"north\"\"\",5,bcg450,"), "{}", row.csv());
        assert!(csv_columns(true).starts_with("unix_time,segment,address,"));
        assert!(row.line().starts_with("hall, \"north\"    5  bcg450"), "{}", row.line());
        assert!(header(true).starts_with("SEGMENT      ADDR  DEVICE"));
        let json = serde_json::to_string(&row).unwrap();
        assert!(json.contains("\"segment\":\"hall, \\\"north\\\"\",\"address\":5"), "{json}");
    }
}
