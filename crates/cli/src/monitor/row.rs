//! What is known of one slave at one moment, in every form it is shown in.

use profivac_devices::model::{Scale, Unit};
use profivac_dp::master::{Counters, State, Trouble};
use profivac_host::tool::BusMaster;
use profivac_host::watch::{Reading, Watched};
use serde::Serialize;

/// One slave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Seconds since 1970.
    pub unix_time: f64,
    pub address: u8,
    pub device: &'static str,
    /// In `unit`; nothing unless it is valid.
    pub pressure: Option<f64>,
    pub unit: &'static str,
    pub mbar: Option<f64>,
    /// The measuring part it is from.
    pub instance: u8,
    /// Where the master stands with the slave.
    pub state: String,
    /// What is not as it should be.
    pub remarks: Vec<String>,
    pub exchanges: u32,
    pub lost: u32,
}

/// The columns of CSV, in the order of [`Row::csv`].
pub const CSV_COLUMNS: &str = "unix_time,address,device,pressure,unit,mbar,instance,state,remarks,exchanges,lost";

impl Row {
    /// What `master` knows about a slave.
    pub fn of(watched: &Watched, master: &BusMaster, unix_time: f64) -> Self {
        let address = watched.address;
        let reading = master.inputs(address).map(|inputs| watched.reading(inputs)).unwrap_or_default();
        let counters = master.counters(address).copied().unwrap_or_default();
        Self::new(watched, unix_time, &reading, &counters, master.state(address), master.trouble(address))
    }

    fn new(
        watched: &Watched,
        unix_time: f64,
        reading: &Reading,
        counters: &Counters,
        state: Option<State>,
        trouble: Option<Trouble>,
    ) -> Self {
        let mbar = reading.pa.map(|pa| rounded(pa / 100.0));
        let (pressure, unit) = in_unit(mbar, watched.unit);
        let trouble = trouble.map(|trouble| trouble.to_string());
        Self {
            unix_time,
            address: watched.address,
            device: watched.model.name,
            pressure,
            unit,
            mbar,
            instance: reading.instance,
            state: state.map_or_else(String::new, |state| state.to_string()),
            remarks: trouble.into_iter().chain(reading.remarks().into_iter().map(str::to_owned)).collect(),
            exchanges: counters.exchanges,
            lost: counters.lost,
        }
    }

    /// Whether data are exchanged.
    pub fn is_exchanging(&self) -> bool {
        self.state == "DATA"
    }

    /// The pressure as people read it.
    pub fn pressure_text(&self) -> String {
        self.pressure.map_or_else(|| "-".to_owned(), |pressure| format!("{pressure:.3e} {}", self.unit))
    }

    /// What is not as it should be.
    pub fn remarks_text(&self) -> String {
        self.remarks.join("; ")
    }

    /// One line of CSV.
    pub fn csv(&self) -> String {
        let number = |number: Option<f64>| number.map_or_else(String::new, |number| format!("{number:e}"));
        [
            format!("{:.3}", self.unix_time),
            self.address.to_string(),
            self.device.to_owned(),
            number(self.pressure),
            self.unit.to_owned(),
            number(self.mbar),
            self.instance.to_string(),
            self.state.clone(),
            format!("\"{}\"", self.remarks_text().replace('"', "\"\"")),
            self.exchanges.to_string(),
            self.lost.to_string(),
        ]
        .join(",")
    }

    /// One line of a table.
    pub fn line(&self) -> String {
        format!(
            "{:>4}  {:<10}{:<18}{:<10}{:>10}{:>6}  {}",
            self.address,
            self.device,
            self.pressure_text(),
            self.state,
            self.exchanges,
            self.lost,
            self.remarks_text()
        )
        .trim_end()
        .to_owned()
    }
}

/// The header of a table of [`Row::line`].
pub fn header() -> String {
    format!(
        "{:>4}  {:<10}{:<18}{:<10}{:>10}{:>6}  {}",
        "ADDR", "DEVICE", "PRESSURE", "STATE", "CYCLES", "LOST", "REMARKS"
    )
}

/// A pressure in the unit the slave shows. COUNTS are for machines: mbar instead.
const fn in_unit(mbar: Option<f64>, unit: &'static Unit) -> (Option<f64>, &'static str) {
    match (mbar, unit.scale) {
        (Some(mbar), Scale::PerMbar(factor)) => (Some(mbar * factor), unit.name),
        (None, Scale::PerMbar(_)) => (None, unit.name),
        (mbar, Scale::Counts) => (mbar, "mbar"),
    }
}

/// To seven digits: more a float on the wire does not have.
fn rounded(number: f64) -> f64 {
    format!("{number:.6e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_devices::profile::{ExceptionStatus, StatusExtension};
    use profivac_dp::link::active::Failure;

    fn row(unit: &str, pa: Option<f64>, trouble: Option<Trouble>) -> Row {
        let unit = MODEL.unit_named(unit).unwrap();
        let watched = Watched { address: 5, model: &MODEL, configuration: MODEL.default_configuration, unit };
        let reading =
            Reading { pa, instance: 2, status: StatusExtension::UNDER, exception: ExceptionStatus::WARNING_DEVICE };
        let counters = Counters { exchanges: 1234, lost: 5, ..Counters::default() };
        Row::new(&watched, 1.5, &reading, &counters, Some(State::Data { diag: false }), trouble)
    }

    #[test]
    fn a_pressure_is_shown_in_the_slaves_unit_with_the_digits_it_has() {
        let pa = f64::from(5e-6_f32) * 100.0;
        assert_eq!(row("mbar", Some(pa), None).pressure_text(), "5.000e-6 mbar");
        assert_eq!(row("mbar", Some(pa), None).mbar, Some(5e-6));
        assert_eq!(row("Pascal", Some(pa), None).pressure_text(), "5.000e-4 Pascal");
        assert_eq!(row("COUNTS", Some(pa), None).pressure_text(), "5.000e-6 mbar");
        assert_eq!(row("Torr", None, None).pressure_text(), "-");
    }

    #[test]
    fn every_form_tells_the_same() {
        let row = row("mbar", Some(5e-4), Some(Trouble::Lost(Failure::Silence)));
        assert_eq!(row.csv(), "1.500,5,bcg450,5e-6,mbar,5e-6,2,DATA,\"no answer; underrange; device warning\",1234,5");
        assert_eq!(row.csv().split(',').count(), CSV_COLUMNS.split(',').count());
        let line =
            "   5  bcg450    5.000e-6 mbar     DATA            1234     5  no answer; underrange; device warning";
        assert_eq!(row.line(), line);
        let json = serde_json::to_string(&row).unwrap();
        let expected = "{\"unix_time\":1.5,\"address\":5,\"device\":\"bcg450\",\"pressure\":5e-6,\"unit\":\"mbar\",\"mbar\":5e-6,\
                        \"instance\":2,\"state\":\"DATA\",\"remarks\":[\"no answer\",\"underrange\",\"device warning\"],\
                        \"exchanges\":1234,\"lost\":5}";
        assert_eq!(json, expected);
    }
}
