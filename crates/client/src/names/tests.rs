//! Names of parameters and commands: found, ambiguous, unknown.

use super::*;
use profivac_devices::catalog::model_named;

fn names(device: &str) -> ParameterNames {
    ParameterNames::of(model_named(device).unwrap())
}

fn numbers_of(device: &'static str, text: &str) -> String {
    match names(device).find(device, text) {
        Ok(Target::Parameter(named)) => named.parameter.numbers(),
        Ok(Target::CurrentInstance { slot, index }) => format!("shown {slot}/{index}"),
        Ok(Target::Raw { slot, index }) => format!("raw {slot}/{index}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn the_words_and_numbers_of_the_manual_find_a_parameter() {
    for (device, text, numbers) in [
        ("bcg450", "pirani.process-value", "1:1/19"),
        ("bcg450", "Pirani/Process Value (PV)", "1:1/19"),
        ("bcg450", "ba.degas-status", "1:2/109"),
        ("bcg450", "degas status", "1:2/109"),
        ("bcg450", "1:2/19", "1:2/19"),
        ("bcg450", "1/19", "shown 1/19"),
        ("bcg450", "0/25", "0/25"),
        ("bcg450", "device.serial", "0/23"),
        ("pcg550", "trip-point.1/high-trip-point", "2/17"),
        ("pcg550", "trip-point.2.high-trip-point", "3/17"),
        ("pcg550", "cdg.process-value", "1:1/19"),
        ("pcg550", "run-hours", "0/36"),
        ("pcg550", "device.run-hours-4", "0/212"),
        ("img400", "channel.3/process-value", "3/19"),
        ("img400", "relay.7/hysteresis", "11/24"),
        ("tpg300", "a2.pressure-unit", "2/22"),
        ("tpg500", "cold-cathode-b.upper-threshold", "10/21"),
        ("hpg400", "emission-on-switch", "0/202"),
    ] {
        assert_eq!(numbers_of(device, text), numbers, "{device} {text}");
    }
}

#[test]
fn a_word_of_the_manual_is_enough_to_read() {
    for (device, text, numbers) in [
        ("bcg450", "serial", "0/23"),
        ("bcg450", "degas", "1:2/109"),
        ("psg550", "pressure", "1:1/19"),
        ("bcg450", "pirani pressure", "1:1/19"),
        ("bcg450", "ba.pressure", "1:2/19"),
    ] {
        assert_eq!(numbers_of(device, text), numbers, "{device} {text}");
    }
    let several = numbers_of("bcg450", "pressure");
    for name in ["pirani.process-value (1:1/19)", "ba.process-value (1:2/19)", "cdg.process-value (1:3/19)"] {
        assert!(several.contains(name), "{several}");
    }
}

#[test]
fn a_write_takes_the_whole_name_and_no_abbreviation() {
    for model in MODELS {
        let names = names(model.name);
        for named in names.all() {
            let Ok(Target::Parameter(found)) = names.find_whole(model.name, &named.name) else { panic!("{named}") };
            assert_eq!(found.to_string(), named.to_string());
            // Without its last letter the name may name another parameter, but never this one.
            let short = &named.name[..named.name.len() - 1];
            if let Ok(Target::Parameter(found)) = names.find_whole(model.name, short) {
                assert_ne!(found.to_string(), named.to_string(), "{short}");
            }
        }
    }
    for (text, meant) in [
        ("pirani.safe-s", "pirani.safe-state"),
        ("serial", "device.serial-number"),
        ("device.serial", "device.serial-number"),
    ] {
        let error = names("bcg450").find_whole("bcg450", text).unwrap_err().to_string();
        assert!(error.contains("did you mean") && error.contains(meant), "{text}: {error}");
    }
    assert!(names("bcg450").find_whole("bcg450", "pressure").is_err());
}

#[test]
fn a_search_shows_names_commands_and_numbers() {
    let found = |text: &str| -> Vec<String> {
        let names = names("bcg450");
        names.all().iter().filter(|named| named.is_found_by(text)).map(ToString::to_string).collect()
    };
    assert_eq!(found("1/19").len(), names("bcg450").at_index(1, 19).count());
    assert_eq!(found("1:2/19"), ["ba.process-value (1:2/19)"]);
    assert!(found("19").iter().all(|name| name.ends_with("/19)")) && found("19").len() >= 3, "{:?}", found("19"));
    assert_eq!(found("degas on").len(), 1);
    assert!(found("execute").iter().any(|name| name.ends_with("(0/15)")), "{:?}", found("execute"));
    // Three sensors, and two set points that follow one of them.
    assert_eq!(found("pressure").iter().filter(|name| name.contains("process-value")).count(), 5);
}

#[test]
fn every_parameter_is_found_under_its_name_and_its_numbers() {
    for model in MODELS {
        let device = model.name;
        let names = names(device);
        assert!(names.all().len() > 40, "{device}");
        for named in names.all() {
            let Ok(Target::Parameter(found)) = names.find(device, &named.name) else { panic!("{device} {named}") };
            assert_eq!(found.to_string(), named.to_string(), "{device}");
            let shown = names.find(device, &named.parameter.numbers());
            assert!(matches!(shown, Ok(Target::Parameter(_) | Target::CurrentInstance { .. })), "{device} {named}");
        }
    }
}

#[test]
fn an_unknown_name_is_an_error_with_suggestions() {
    let unknown = "bcg450 has no parameter or command \"pirani.proces-valeu\"; did you mean pirani.process-value?";
    assert!(numbers_of("bcg450", "pirani.proces-valeu").starts_with(unknown.trim_end_matches('?')));
    assert_eq!(numbers_of("bcg450", "xyz"), "bcg450 has no parameter or command \"xyz\"");
    assert_eq!(numbers_of("bcg450", "7/19"), "raw 7/19");
    let command = "bcg450 has no parameter or command \"degas\"; did you mean ba.degas-off or ba.degas-on?";
    assert_eq!(names("bcg450").find_whole("bcg450", "degas").unwrap_err().to_string(), command);
    let ambiguous = "\"overrange\" is ambiguous: it may be pirani.overrange (1:1/44), ba.overrange (1:2/44), cdg.overrange (1:3/44)";
    assert_eq!(numbers_of("bcg450", "overrange"), ambiguous);
    let numbers = "expected SLOT/INDEX or SLOT:INSTANCE/INDEX with numbers from 0 to 254, got \"1/300\"";
    assert_eq!(numbers_of("bcg450", "1/300"), numbers);
    assert!(numbers_of("bcg450", "").starts_with("bcg450 has no parameter"));
}

/// The record of another instance is never read in its place.
#[test]
fn an_instance_that_no_table_has_is_an_error_with_the_known_ones() {
    let other = "bcg450 has no parameter 1:9/19; expected 1:1/19 or 1:2/19 or 1:3/19";
    assert!(numbers_of("bcg450", "1:9/19").starts_with(other), "{}", numbers_of("bcg450", "1:9/19"));
    assert_eq!(numbers_of("bcg450", "0:1/25"), "bcg450 has no parameter 0:1/25; expected 0/25");
    let outside = "bcg450 has no parameter 1:2/200; a record outside its tables has no instance: expected SLOT/INDEX";
    assert_eq!(numbers_of("bcg450", "1:2/200"), outside);
}

#[test]
fn a_command_is_found_by_its_name_and_its_instance() {
    let command = |device: &str, text: &str| match names(device).command(text) {
        Ok(Some((named, code))) => format!("{} {}", named.parameter.numbers(), code.number),
        Ok(None) => "none".to_owned(),
        Err(error) => error.to_string(),
    };
    assert_eq!(command("bcg450", "degas on"), "1:2/14 257");
    assert_eq!(command("bcg450", "execute"), "0/15 4");
    assert_eq!(command("bcg450", "explode"), "none");
    assert_eq!(command("pcg550", "cdg.zero-adjust"), "1:1/15 0");
    let ambiguous = "\"zero-adjust\" is ambiguous: it may be cdg.zero-adjust, pirani.zero-adjust";
    assert_eq!(command("pcg550", "zero-adjust"), ambiguous);
    assert_eq!(command("img400", "channel.2/degas on"), "2/14 257");
    assert_eq!(command("psg550", "zero adjust"), "1:1/15 0");
}

#[test]
fn a_slug_has_words_in_lower_case_with_hyphens() {
    for (text, expected) in [
        ("ProcessValue (PV)", "process-value-pv"),
        ("Device Exception Detail Alarm 0 ... 3", "device-exception-detail-alarm-0-3"),
        ("Sensor On_Off", "sensor-on-off"),
        ("AIBlockAdjust Command", "ai-block-adjust-command"),
        ("OneOfN PV Selector", "one-of-n-pv-selector"),
        ("Run hours (*4)", "run-hours-4"),
    ] {
        assert_eq!(slug(text), expected);
    }
}
