//! The block that decodes a telegram of the inputs: the rules of [`crate::cyclic`], in structured text.

use super::source::{Source, bit, octet, real};
use super::{decoder_name, in_comment, is_pressure};
use crate::cyclic::unranged_instances;
use profivac_devices::model::{Counts, Field, Model, NumberType, PartSpec, Principle, Role, Row, Scale, Telegram};
use profivac_devices::profile::{ExceptionStatus, StatusExtension};
use profivac_devices::reading::Quality;

/// A number on the wire differs from the pressure by this part at most, as in [`crate::cyclic`].
const ROUNDING: f64 = 5e-3;

/// The highest pressure that any value may have.
const HIGHEST_PA: f64 = 1e30;

/// Writes the block.
pub(super) fn write(source: &mut Source, model: &Model, telegram: &Telegram) {
    Decoder { model, telegram }.write(source);
}

/// Where the status of a value is.
enum Status {
    /// One octet, at this offset.
    Gauge(usize),
    /// Half an octet for each channel, from this offset.
    Channels(usize),
    /// One octet behind each value.
    Measurement,
    /// In the value.
    Ttr,
    None,
}

struct Decoder<'a> {
    model: &'a Model,
    telegram: &'a Telegram,
}

impl Decoder<'_> {
    fn write(&self, source: &mut Source) {
        let name = decoder_name(self.model, self.telegram);
        source.begin_block(&name);
        self.describe(source);
        self.variables(source);
        source.begin_statements();
        self.common(source);
        let channels = self.pressures().len();
        if channels > 1 {
            source.open(&format!("FOR CHANNEL := 1 TO {channels} DO"));
            self.value(source, "[CHANNEL]");
            source.close("END_FOR;");
        } else {
            self.value(source, "");
        }
        source.end_block();
    }

    /// The offset of each pressure, and its field.
    fn pressures(&self) -> Vec<(usize, Field)> {
        self.telegram.layout().filter(|(_, field)| is_pressure(*field)).collect()
    }

    fn offset(&self, wanted: impl Fn(Field) -> bool) -> Option<usize> {
        self.telegram.layout().find(|(_, field)| wanted(*field)).map(|(start, _)| start)
    }

    fn exception(&self) -> Option<usize> {
        self.offset(|field| field == Field::ExceptionStatus)
    }

    fn selector(&self) -> Option<usize> {
        self.offset(|field| field == Field::PvSelector)
    }

    fn relays(&self) -> Option<(usize, u8)> {
        self.telegram.layout().find_map(|(start, field)| match field {
            Field::TripRelays(count) if count > 0 => Some((start, count)),
            _ => None,
        })
    }

    fn status(&self) -> Status {
        let extension = self.offset(|field| field == Field::StatusExtension).map(Status::Gauge);
        let channels = || self.offset(|field| field == Field::ChannelStatus).map(Status::Channels);
        let measurement =
            || self.offset(|field| matches!(field, Field::MeasurementStatus(_))).map(|_| Status::Measurement);
        let ttr = || self.offset(|field| field == Field::TtrValue).map(|_| Status::Ttr);
        extension.or_else(channels).or_else(measurement).or_else(ttr).unwrap_or(Status::None)
    }

    /// The TTR compatibility mode has one unit.
    fn has_unit(&self) -> bool {
        !matches!(self.status(), Status::Ttr)
    }

    fn describe(&self, source: &mut Source) {
        source.line(&format!("(* Decodes these {} octets of inputs:", self.telegram.octets()));
        for (start, field) in self.telegram.layout() {
            let last = start.saturating_add(field.octets()).saturating_sub(1);
            let offset = if start == last { start.to_string() } else { format!("{start} to {last}") };
            let channel = match field {
                Field::ChannelValue(channel, _)
                | Field::ChannelMantissa(channel)
                | Field::MeasurementStatus(channel) => {
                    format!(" of channel {channel}")
                }
                _ => String::new(),
            };
            let number = match field {
                Field::ProcessValue(NumberType::Integer) | Field::ChannelValue(_, NumberType::Integer) => {
                    let highest = self.model.max_integer;
                    format!(", a word; {highest}: this or more; 0: less than one unit (COUNTS: no pressure)")
                }
                Field::ProcessValue(NumberType::Float) | Field::ChannelValue(_, NumberType::Float) => {
                    ", a float".to_owned()
                }
                Field::ChannelMantissa(_) => ", mantissa and exponent".to_owned(),
                _ => String::new(),
            };
            source.line(&format!("   {offset:<8} {}{channel}{number}", field.name()));
        }
        if self.has_unit() {
            self.describe_unit(source);
            for unit in self.model.units {
                source.line(&format!("   {:<8} {}", unit.code, in_comment(unit.name)));
            }
        }
        source.line("   QUALITY:");
        for quality in [
            Quality::Valid,
            Quality::Overrange,
            Quality::Underrange,
            Quality::Fault,
            Quality::Stale,
            Quality::Off,
            Quality::Missing,
        ] {
            source.line(&format!("   {:<8} {}", quality as u8, quality.word()));
        }
        source.line("   While VALID is FALSE, the pressures are SUBSTITUTE_PA. *)");
    }

    /// Whether the user parameters select the unit. A TPG has none: IF300P/IF301P manual 3.2.1.2.
    fn has_unit_in_user_prm(&self) -> bool {
        self.model.user_prm.iter().any(|prm| self.model.unit(prm.unit_code()).is_some())
    }

    /// The slot and the row of the unit, if it is a parameter.
    fn unit_parameter(&self) -> Option<(u8, &'static Row)> {
        self.model.blocks.iter().find_map(|placed| {
            let row = placed.block.rows.iter().find(|row| row.role == Some(Role::Unit))?;
            Some((placed.locations.first()?.slot, row))
        })
    }

    /// A unit that is a parameter can change during data exchange, and the inputs do not show it: IF300P/IF301P manual 3.2.4.1.
    fn describe_unit(&self, source: &mut Source) {
        if self.has_unit_in_user_prm() {
            source.line("   UNIT is Data Units of the device, as its user parameters select it:");
            return;
        }
        if self.single_unit().is_some() {
            source.line("   UNIT is the only unit of the device:");
            return;
        }
        let parameter = self.unit_parameter().map_or_else(
            || "the unit of the device".to_owned(),
            |(slot, row)| {
                format!("slot {slot}, index {} ({}) in the parameter channel", row.index, in_comment(row.name))
            },
        );
        source.lines(&format!(
            "   CAUTION: the user parameters have no unit, and the unit can change during data exchange.\n   \
                Read {parameter} again and again,\n   \
                and set UNIT to it. After a change the pressures are wrong, and VALID is TRUE, until UNIT has the new code:"
        ));
        source.line("   -1       not known, no pressure: UNIT until the program sets it");
    }

    /// The only unit of the device, if it has one only.
    fn single_unit(&self) -> Option<u16> {
        match self.model.units {
            [unit] => Some(unit.code),
            _ => None,
        }
    }

    /// The value of UNIT that the program does not set. A unit that the user parameters do not select is not assumed.
    fn initial_unit(&self) -> i32 {
        let usual = || self.model.unit_named("mbar").or_else(|| self.model.units.first()).map(|unit| unit.code);
        let unit = if self.has_unit_in_user_prm() { usual() } else { self.single_unit() };
        unit.map_or(-1, i32::from)
    }

    /// A device file can have codes that are no `INT`.
    fn unit_type(&self) -> &'static str {
        let is_int = |code: u16| i16::try_from(code).is_ok();
        if self.model.units.iter().all(|unit| is_int(unit.code)) { "INT" } else { "DINT" }
    }

    fn variables(&self, source: &mut Source) {
        let last = self.telegram.octets().saturating_sub(1);
        let mut inputs = format!("OCTETS : ARRAY[0..{last}] OF BYTE;\nEXCHANGING : BOOL;\n");
        if self.has_unit() {
            inputs += &format!("UNIT : {} := {};\n", self.unit_type(), self.initial_unit());
        }
        inputs += "SUBSTITUTE_PA : REAL := 1.01325E+5;";
        source.variables("VAR_INPUT", &inputs);
        let channels = self.pressures().len();
        let of = |kind: &str| if channels > 1 { format!("ARRAY[1..{channels}] OF {kind}") } else { kind.to_owned() };
        let mut outputs = format!(
            "PRESSURE_PA : {real};\nPRESSURE_MBAR : {real};\nVALID : {bool};\nQUALITY : {int};\n",
            real = of("REAL"),
            bool = of("BOOL"),
            int = of("INT")
        );
        if self.selector().is_some() {
            outputs += "INSTANCE : INT;\n";
        }
        if self.exception().is_some() {
            outputs += "EXCEPTION : INT;\nALARM : BOOL;\nWARNING : BOOL;\n";
        }
        if let Some((_, count)) = self.relays() {
            outputs += &format!("RELAY : ARRAY[1..{count}] OF BOOL;\n");
        }
        source.variables("VAR_OUTPUT", &outputs);
        source.variables("VAR", &self.own_variables());
    }

    fn own_variables(&self) -> String {
        let float = self.pressures().iter().any(|(_, field)| number_of(*field) == Some(NumberType::Float));
        let mantissa = self.pressures().iter().any(|(_, field)| matches!(field, Field::ChannelMantissa(_)));
        let status = match self.status() {
            Status::Gauge(_) => "STATUS : INT;\nINVALID : BOOL;\n",
            Status::Channels(_) => "STATUS : INT;\nINVALID : BOOL;\nMEASURES : BOOL;\n",
            Status::Measurement => "STATUS : INT;\n",
            Status::Ttr => "ERROR : BOOL;\n",
            Status::None => "",
        };
        let mut own = String::from("AT_OCTET : INT;\nRAW : BYTE;\nB0 : INT;\nB1 : INT;\n");
        if float {
            own += "B2 : INT;\nB3 : INT;\nEXPONENT : INT;\n";
        }
        if mantissa {
            own += "POWER : INT;\n";
        }
        own += "NUMBER : REAL;\nIS_PRESSURE : BOOL;\nPRESSURE : REAL;\nVERDICT : INT;\n";
        if self.has_integers() {
            own += "IS_HIGHEST : BOOL;\nIS_ZERO : BOOL;\n";
        }
        own += status;
        if self.pressures().len() > 1 {
            own += "CHANNEL : INT;\n";
        }
        if self.has_counts() {
            own += "EXPONENT_OF_E : REAL;\n";
        }
        if self.needs_range() {
            own += "HAS_RANGE : BOOL;\nLOW : REAL;\nHIGH : REAL;\nPIRANI : BOOL;\n";
        }
        own
    }

    /// The statements before those for each value.
    fn common(&self, source: &mut Source) {
        if let Some(offset) = self.exception() {
            source.lines(&octet("EXCEPTION", offset));
            source.line(&format!("ALARM := {};", any_bit("EXCEPTION", ExceptionStatus::ALARM)));
            let warnings = ExceptionStatus::WARNING_COMMON
                | ExceptionStatus::WARNING_DEVICE
                | ExceptionStatus::WARNING_MANUFACTURER;
            source.line(&format!("WARNING := {};", any_bit("EXCEPTION", warnings)));
        }
        if let Some(offset) = self.selector() {
            source.lines(&octet("INSTANCE", offset));
        }
        if let Some((offset, count)) = self.relays() {
            // No FOR: a device with one relay would have one whose start is its end.
            for (relay, place) in (1..=count).zip(offset..) {
                source.lines(&format!("RAW := OCTETS[{place}];\nRELAY[{relay}] := BYTE_TO_INT((RAW)) <> 0;"));
            }
        }
        match self.status() {
            Status::Gauge(offset) => {
                source.lines(&octet("STATUS", offset));
                source.line(&format!("INVALID := {};", bit("STATUS", StatusExtension::INVALID.bits())));
            }
            Status::Channels(offset) => {
                source.line("MEASURES := FALSE;");
                for place in [offset, offset.saturating_add(1)] {
                    source.lines(&octet("STATUS", place));
                    let invalid = StatusExtension::INVALID.bits();
                    let (low, high) = (bit("STATUS", invalid), bit("STATUS", invalid << 4));
                    source.lines(&format!("IF NOT ({low}) OR NOT ({high}) THEN\n    MEASURES := TRUE;\nEND_IF;"));
                }
            }
            Status::Measurement | Status::Ttr | Status::None => {}
        }
    }

    /// The statements for one value.
    fn value(&self, source: &mut Source, index: &str) {
        let pressures = self.pressures();
        let Some((first, field)) = pressures.first().copied() else { return };
        let stride = pressures.get(1).map_or(0, |(next, _)| next.saturating_sub(first));
        match stride {
            0 => source.line(&format!("AT_OCTET := {first};")),
            stride => source.line(&format!("AT_OCTET := {first} + (CHANNEL - 1) * {stride};")),
        }
        source.lines(&octet("B0", "AT_OCTET"));
        source.lines(&octet("B1", "AT_OCTET + 1"));
        source.line("IS_PRESSURE := TRUE;");
        match field {
            Field::ChannelMantissa(_) => source.lines(MANTISSA),
            Field::TtrValue => source.lines(TTR),
            field if number_of(field) == Some(NumberType::Float) => source.lines(FLOAT),
            _ => {
                source.line("NUMBER := INT_TO_REAL((B0)) * 256.0 + INT_TO_REAL((B1));");
                source.line(&format!("IS_PRESSURE := NUMBER <= {};", real(self.model.max_integer.into())));
            }
        }
        if self.has_unit() {
            self.to_pascal(source);
        }
        if self.has_integers() {
            self.integer_ends(source);
        }
        source.lines(&format!(
            "IF (PRESSURE <= 0.0) OR (PRESSURE > {}) THEN\n    IS_PRESSURE := FALSE;\nEND_IF;",
            real(HIGHEST_PA)
        ));
        if self.needs_range() {
            self.range(source);
        }
        self.verdict(source, &pressures);
        source.lines(&format!("QUALITY{index} := VERDICT;\nVALID{index} := VERDICT = 0;"));
        source.lines(&format!(
            "IF VERDICT = 0 THEN\n    PRESSURE_PA{index} := PRESSURE;\nELSE\n    PRESSURE_PA{index} := SUBSTITUTE_PA;\nEND_IF;\n\
             PRESSURE_MBAR{index} := PRESSURE_PA{index} / 100.0;"
        ));
    }

    fn has_integers(&self) -> bool {
        self.pressures().iter().any(|(_, field)| number_of(*field) == Some(NumberType::Integer))
    }

    /// The two integers that stand for every pressure beyond them. 0 on a logarithmic scale is no pressure already, and neither is 0 in
    /// inputs that no gauge has filled.
    fn integer_ends(&self, source: &mut Source) {
        let highest = real(self.model.max_integer.into());
        source.line(&format!("IS_HIGHEST := IS_PRESSURE AND (NUMBER = {highest});"));
        let named = if self.selector().is_some() { " AND (INSTANCE <> 0)" } else { "" };
        let filled = bit("EXCEPTION", ExceptionStatus::EXPANDED.bits());
        let filled = self.exception().map(|_| format!(" AND ({filled})")).unwrap_or_default();
        source.line(&format!("IS_ZERO := IS_PRESSURE AND (NUMBER = 0.0){named}{filled};"));
    }

    /// The variable with the instance or channel of a value, if the tables have its COUNTS.
    fn instance(&self) -> Option<&'static str> {
        match (self.pressures().len() > 1, self.selector()) {
            _ if self.model.parts.is_empty() => None,
            (true, _) => Some("CHANNEL"),
            (false, Some(_)) => Some("INSTANCE"),
            (false, None) => None,
        }
    }

    /// The parts, each instance once: the first of an instance has its COUNTS.
    fn parts(&self) -> Vec<&'static PartSpec> {
        let mut parts: Vec<&PartSpec> = Vec::new();
        for spec in self.model.parts.iter().copied() {
            if parts.iter().all(|known| known.part.instance != spec.part.instance) {
                parts.push(spec);
            }
        }
        parts
    }

    fn has_counts(&self) -> bool {
        let has_log = self.model.parts.iter().any(|spec| matches!(spec.counts, Counts::Log { .. }));
        self.has_unit() && has_log && self.model.units.iter().any(|unit| unit.scale == Scale::Counts)
    }

    fn to_pascal(&self, source: &mut Source) {
        source.line("PRESSURE := 0.0;");
        source.open("CASE UNIT OF");
        for unit in self.model.units {
            match unit.scale {
                Scale::PerMbar(factor) => {
                    source.line(&format!(
                        "{}: PRESSURE := NUMBER * {}; (* {} *)",
                        unit.code,
                        real(100.0 / factor),
                        in_comment(unit.name)
                    ));
                }
                Scale::Counts => {
                    source.open(&format!("{}: (* {} *)", unit.code, in_comment(unit.name)));
                    self.counts(source);
                    source.close("");
                }
            }
        }
        source.branch("ELSE");
        source.line("IS_PRESSURE := FALSE;");
        source.close("END_CASE;");
        if let Some(instance) = self.instance().filter(|instance| *instance == "INSTANCE") {
            let instances = self.parts().into_iter().map(|spec| spec.part.instance);
            let known: Vec<_> =
                std::iter::once(0).chain(instances).map(|one| format!("({instance} <> {one})")).collect();
            source.lines(&format!("IF {} THEN\n    IS_PRESSURE := FALSE;\nEND_IF;", known.join(" AND ")));
        }
    }

    fn counts(&self, source: &mut Source) {
        let parts = self.parts();
        match (self.instance(), parts.first()) {
            (_, None) => source.lines(&linear(1.0)),
            (None, Some(spec)) => source.lines(&counts(spec.counts)),
            (Some(instance), Some(_)) => {
                source.open(&format!("CASE {instance} OF"));
                for (number, spec) in parts.into_iter().enumerate() {
                    // Without an active instance the master takes the first.
                    let none = if number == 0 && spec.part.instance != 0 { "0, " } else { "" };
                    source.open(&format!("{none}{}:", spec.part.instance));
                    source.lines(&counts(spec.counts));
                    source.close("");
                }
                source.branch("ELSE");
                source.line("IS_PRESSURE := FALSE;");
                source.close("END_CASE;");
            }
        }
    }

    /// Only One Of N Status Extension and the TTR compatibility mode need the range of the gauge.
    fn needs_range(&self) -> bool {
        matches!(self.status(), Status::Gauge(_) | Status::Ttr)
    }

    fn range(&self, source: &mut Source) {
        source.lines("HAS_RANGE := FALSE;\nPIRANI := FALSE;\nLOW := 0.0;\nHIGH := 0.0;");
        if matches!(self.status(), Status::Ttr) {
            if let Some(range) = crate::cyclic::whole_range(self.model) {
                source.lines(&set_range(range.lowest_pa, range.highest_pa));
            }
            return;
        }
        if self.selector().is_none() {
            return;
        }
        let unranged = unranged_instances(self.model);
        let ranged: Vec<_> = self.parts().into_iter().filter(|spec| !unranged.contains(&spec.part.instance)).collect();
        if ranged.is_empty() {
            return;
        }
        let has_ion = self.model.parts.iter().any(|spec| spec.part.principle == Principle::HotCathode);
        source.open("CASE INSTANCE OF");
        for spec in ranged {
            source.open(&format!("{}: (* {} *)", spec.part.instance, spec.part.principle.part_name()));
            source.lines(&set_range(spec.limits.under_pa, spec.limits.over_pa));
            if has_ion && spec.part.principle == Principle::Pirani {
                source.line("PIRANI := TRUE;");
            }
            source.close("");
        }
        source.branch("ELSE");
        source.line("HAS_RANGE := FALSE;");
        source.close("END_CASE;");
    }

    fn verdict(&self, source: &mut Source, pressures: &[(usize, Field)]) {
        if let Status::Channels(offset) = self.status() {
            source.lines(&format!(
                "{}\nIF CHANNEL MOD 2 = 0 THEN\n    STATUS := STATUS / 16;\nEND_IF;\nINVALID := {};",
                octet("STATUS", format_args!("{offset} + (CHANNEL - 1) / 2")),
                bit("STATUS", StatusExtension::INVALID.bits())
            ));
        }
        if let (Status::Measurement, Some((first, field))) = (self.status(), pressures.first()) {
            let offset = first.saturating_add(field.octets()).saturating_sub(*first);
            source.lines(&octet("STATUS", format_args!("AT_OCTET + {offset}")));
        }
        if matches!(self.status(), Status::Ttr) {
            source.line("ERROR := B0 >= 128;");
        }
        let mut rules = vec![("NOT EXCHANGING".to_owned(), Quality::Stale)];
        rules.extend(self.rules());
        if self.has_integers() {
            rules.push(("IS_HIGHEST".to_owned(), Quality::Overrange));
            rules.push(("IS_ZERO".to_owned(), Quality::Underrange));
        }
        for (number, (condition, quality)) in rules.into_iter().enumerate() {
            let word = if number == 0 { "IF" } else { "ELSIF" };
            source.line(&format!("{word} {condition} THEN"));
            source.line(&format!("    VERDICT := {}; (* {} *)", quality as u8, quality.word()));
        }
        source.lines(&format!(
            "ELSIF IS_PRESSURE THEN\n    VERDICT := {}; (* {} *)\nELSE\n    VERDICT := {}; (* {} *)\nEND_IF;",
            Quality::Valid as u8,
            Quality::Valid.word(),
            Quality::Fault as u8,
            Quality::Fault.word()
        ));
    }

    /// The conditions and their qualities, in order; behind them only the number decides.
    fn rules(&self) -> Vec<(String, Quality)> {
        let rule = |condition: &str, quality| (condition.to_owned(), quality);
        let (under, over) = (bit("STATUS", StatusExtension::UNDER.bits()), bit("STATUS", StatusExtension::OVER.bits()));
        let by_extension = |alarms: ExceptionStatus| {
            vec![
                (format!("INVALID AND ({})", any_bit("EXCEPTION", alarms)), Quality::Fault),
                (format!("({under}) AND ({over})"), Quality::Fault),
                (under.clone(), Quality::Underrange),
                (over.clone(), Quality::Overrange),
            ]
        };
        let within = format!(
            "HAS_RANGE AND IS_PRESSURE AND (PRESSURE > LOW * {}) AND (PRESSURE < HIGH * {})",
            real(1.0 + ROUNDING),
            real(1.0 - ROUNDING)
        );
        let at_low_end = format!("(PRESSURE <= LOW * {})", real(1.0 + ROUNDING));
        match self.status() {
            Status::Gauge(_) => {
                let mut rules = by_extension(ExceptionStatus::ALARM);
                rules.extend([
                    (format!("INVALID AND PIRANI AND IS_PRESSURE AND {at_low_end}"), Quality::Underrange),
                    (format!("INVALID AND {within}"), Quality::Fault),
                    rule("INVALID", Quality::Off),
                ]);
                rules
            }
            Status::Channels(_) => {
                let mut rules = by_extension(ExceptionStatus::ALARM_COMMON | ExceptionStatus::ALARM_MANUFACTURER);
                rules.extend(self.hot_cathodes().map(|condition| (format!("INVALID AND {condition}"), Quality::Off)));
                rules.extend([rule("INVALID AND MEASURES", Quality::Missing), rule("INVALID", Quality::Off)]);
                rules
            }
            Status::Measurement => vec![
                rule("STATUS = 1", Quality::Underrange),
                rule("STATUS = 2", Quality::Overrange),
                rule("STATUS = 4", Quality::Off),
                rule("STATUS = 5", Quality::Missing),
                rule("STATUS <> 0", Quality::Fault),
            ],
            Status::Ttr => vec![
                rule("ERROR", Quality::Fault),
                (format!("HAS_RANGE AND IS_PRESSURE AND {at_low_end}"), Quality::Underrange),
                (
                    format!("HAS_RANGE AND IS_PRESSURE AND (PRESSURE >= HIGH * {})", real(1.0 - ROUNDING)),
                    Quality::Overrange,
                ),
            ],
            Status::None => vec![
                rule("ALARM", Quality::Fault),
                (bit("EXCEPTION", ExceptionStatus::WARNING_DEVICE.bits()), Quality::Fault),
            ],
        }
    }

    /// The condition that the channel has a hot cathode in the tables.
    fn hot_cathodes(&self) -> Option<String> {
        let is_hot = |instance: u8| {
            let mut principles = self.model.parts.iter().filter(|spec| spec.part.instance == instance);
            principles.all(|spec| spec.part.principle == Principle::HotCathode)
        };
        let instances = self.parts().into_iter().map(|spec| spec.part.instance);
        let hot: Vec<_> = instances.filter(|one| is_hot(*one)).map(|one| format!("(CHANNEL = {one})")).collect();
        (!hot.is_empty()).then(|| format!("({})", hot.join(" OR ")))
    }
}

const fn number_of(field: Field) -> Option<NumberType> {
    match field {
        Field::ProcessValue(number) | Field::ChannelValue(_, number) => Some(number),
        _ => None,
    }
}

/// The condition that any of these bits is set.
fn any_bit(variable: &str, mask: ExceptionStatus) -> String {
    let bits: Vec<_> = mask.iter().map(|one| format!("({})", bit(variable, one.bits()))).collect();
    bits.join(" OR ")
}

fn set_range(low_pa: f64, high_pa: f64) -> String {
    format!("HAS_RANGE := TRUE;\nLOW := {};\nHIGH := {};", real(low_pa), real(high_pa))
}

/// The statements that convert COUNTS to Pa.
fn counts(counts: Counts) -> String {
    match counts {
        Counts::Log { per_decade, at_1_mbar } => format!(
            "EXPONENT_OF_E := (NUMBER - {}) / {} * 2.302585093;\n\
             IF (NUMBER = 0.0) OR (EXPONENT_OF_E > 60.0) THEN\n    IS_PRESSURE := FALSE;\nELSIF EXPONENT_OF_E < -75.0 THEN\n    PRESSURE := 1.0E-30;\nELSE\n    PRESSURE := EXP((EXPONENT_OF_E)) * 100.0;\nEND_IF;",
            real(at_1_mbar),
            real(per_decade)
        ),
        Counts::Linear { per_mbar } => linear(per_mbar),
        // A process value is no difference.
        Counts::Distance { .. } => "IS_PRESSURE := FALSE;".to_owned(),
    }
}

fn linear(per_mbar: f64) -> String {
    format!("PRESSURE := NUMBER * {};", real(100.0 / per_mbar))
}

/// A float of 32 bits, taken apart. Numbers that no gauge sends (denormalised, from 2^104 on, infinite, no number) are no pressure.
const FLOAT: &str = "\
RAW := OCTETS[AT_OCTET + 2];
B2 := BYTE_TO_INT((RAW));
RAW := OCTETS[AT_OCTET + 3];
B3 := BYTE_TO_INT((RAW));
EXPONENT := (B0 MOD 128) * 2 + B1 / 128;
NUMBER := 8388608.0 + INT_TO_REAL((B1 MOD 128)) * 65536.0 + INT_TO_REAL((B2)) * 256.0 + INT_TO_REAL((B3));
IF (EXPONENT = 0) OR (EXPONENT > 230) THEN
    IS_PRESSURE := FALSE;
    NUMBER := 0.0;
ELSE
    EXPONENT := EXPONENT - 150;
    WHILE EXPONENT > 0 DO
        NUMBER := NUMBER * 2.0;
        EXPONENT := EXPONENT - 1;
    END_WHILE;
    WHILE EXPONENT < 0 DO
        NUMBER := NUMBER * 0.5;
        EXPONENT := EXPONENT + 1;
    END_WHILE;
END_IF;
IF B0 >= 128 THEN
    NUMBER := 0.0 - NUMBER;
END_IF;";

/// The Inficon floating point format, as [`crate::cyclic::mantissa_number`] assumes it.
const MANTISSA: &str = "\
NUMBER := INT_TO_REAL((B0)) * 256.0 + INT_TO_REAL((B1));
RAW := OCTETS[AT_OCTET + 2];
POWER := BYTE_TO_INT((RAW));
IF POWER >= 128 THEN
    POWER := POWER - 256;
END_IF;
IF (B0 >= 128) OR (POWER > 25) OR (POWER < -30) THEN
    IS_PRESSURE := FALSE;
    NUMBER := 0.0;
    POWER := 0;
END_IF;
WHILE POWER > 0 DO
    NUMBER := NUMBER * 10.0;
    POWER := POWER - 1;
END_WHILE;
WHILE POWER < 0 DO
    NUMBER := NUMBER / 10.0;
    POWER := POWER + 1;
END_WHILE;";

/// Telegram 205, as [`crate::cyclic::TtrReading`] decodes it: the exponent of ten in Pa is value / 482 - 2.778.
const TTR: &str = "\
NUMBER := INT_TO_REAL((B0 MOD 16)) * 256.0 + INT_TO_REAL((B1));
PRESSURE := EXP((NUMBER / 482.0 - 2.778) * 2.302585093);
IS_PRESSURE := (B0 <> 0) OR (B1 <> 0);";
