//! The configuration file: defaults, errors with positions, notices.

use super::*;
use profivac_dp::link::Baud;
use profivac_recorder::Retention;
use profivac_station::config::POLL;
use profivac_station::directory::Directory;
use profivac_station::directory::ViewState;
use profivac_station::plant::PlantPartKind;
use profivac_station::plant::PlantPicture;
use profivac_vacuum::Gas;
use profivac_web_server::auth::Access;
use std::path::Path;
use std::path::PathBuf;
use std::time::Duration;

const FILE: &str = r#"
[station]
name = "Target hall"

[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
baud = 93750
master = 1

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
poll = "100 ms"
gas = "ar"
levels = { process = "1e-3 mbar" }
"#;

fn parse(text: &str) -> Result<Config, ConfigError> {
    crate::parse(text, Path::new("plants/hall.toml"))
}

fn problem(text: &str) -> String {
    parse(text).unwrap_err().problem.to_string()
}

#[test]
fn a_file_describes_a_station() {
    let config = parse(FILE).unwrap();
    assert_eq!((config.name.as_str(), config.database.as_path()), ("Target hall", Path::new("plants/hall.db")));
    assert_eq!(config.listen.to_string(), "127.0.0.1:8080");
    let segment = &config.segments[0];
    assert_eq!((segment.name.as_str(), segment.baud, segment.master), ("hall", Baud::B93750, 1));
    let gauge = &segment.gauges[0];
    assert_eq!((gauge.address, gauge.poll, gauge.gas), (5, Duration::from_millis(100), Gas::Ar));
    assert_eq!(gauge.levels[0].0, "process");
    assert!((gauge.levels[0].1.pa() - 0.1).abs() < 1e-12);
}

#[test]
fn relative_paths_are_relative_to_the_file() {
    let more = "\"\nusers = \"accounts.toml\"\nhosts = [\"vacuum.example\", \"10.0.0.1\", \"fe80::1\"]\n[tls]\ncertificate = \"a.pem\"\nkey = \"/etc/a.key\"";
    let config = parse(&FILE.replacen("hall\"", &format!("hall{more}"), 1)).unwrap();
    assert_eq!(config.access(), Access::Users(PathBuf::from("plants/accounts.toml")));
    assert_eq!(config.hosts, ["vacuum.example", "10.0.0.1", "fe80::1"]);
    let tls = config.tls.clone().unwrap();
    assert_eq!((tls.certificate.as_path(), tls.key.as_path()), (Path::new("plants/a.pem"), Path::new("/etc/a.key")));
    assert!(config.is_private() && !parse(FILE).unwrap().is_private());
    let ports = ["sim:hall.toml", "sim:/srv/hall.toml", "/dev/ttyUSB0", "tcp://hall:1234"];
    let found = ports.map(|port| {
        let config = parse(&format!("[[segment]]\nname = \"hall\"\nport = \"{port}\"\n")).unwrap();
        config.segments[0].port.clone()
    });
    assert_eq!(found, ["sim:plants/hall.toml", "sim:/srv/hall.toml", "/dev/ttyUSB0", "tcp://hall:1234"]);
}

#[test]
fn keys_that_are_missing_have_defaults() {
    let config = parse("[[segment]]\nname = 'a'\nport = 'b'\n[[segment.gauge]]\nname='c'\naddress=5\ndevice='bcg450'");
    let config = config.unwrap();
    let gauge = &config.segments[0].gauges[0];
    assert_eq!((config.name.as_str(), config.segments[0].master, gauge.poll, gauge.gas), ("hall", 0, POLL, Gas::N2));
    let users = Path::new("plants/hall.users.toml");
    assert_eq!((config.users.path.as_path(), config.access()), (users, Access::UsersWhenPresent(users.to_owned())));
    assert_eq!(config.database_check, Some(jiff::civil::time(3, 0, 0, 0)));
    assert_eq!(parse(&FILE.replace("[station]", "[station]\ndatabase-check = \"off\"")).unwrap().database_check, None);
}

#[test]
fn an_error_names_its_position_and_what_was_expected() {
    let altered = |from: &str, to: &str| parse(&FILE.replace(from, to)).unwrap_err().to_string();
    for (from, to, sentence) in [
        ("baud = 93750", "baud = 9", "hall.toml:8:8: expected a PROFIBUS rate, one of 9600, "),
        ("master = 1", "master = 5", "hall.toml:13:11: address 5 is already used by the master"),
        ("master = 1", "master = 126", "hall.toml:9:10: expected a master address from 0 to 125, found 126"),
        ("address = 5", "address = 126", "hall.toml:13:11: expected a slave address from 0 to 125, found 126"),
        ("address = 5", "address = 300", "hall.toml:13:11: "),
        ("bcg450", "bcg451", "hall.toml:14:10: unknown device \"bcg451\"; known: "),
        ("bcg450", "bgc450", "; did you mean \"bcg450\"?"),
        ("bcg450", "PSG 551-SP", "; did you mean \"psg550\"?"),
        ("bcg450", "thermometer", "bpg400"),
        ("100 ms", "1 ms", "hall.toml:15:8: expected a sampling interval from 20ms to 1h, found 1ms"),
        ("100 ms", "often", "hall.toml:15:8: "),
        ("\"100 ms\"", "\"100\"", "hall.toml:15:8: expected a time with its unit like \"200 ms\""),
        (
            "\"100 ms\"",
            "100",
            "hall.toml:15:8: expected a time with its unit like \"200 ms\", \"10 min\" or \"7 days\", got \"100\"",
        ),
        ("\"1e-3 mbar\"", "1e-3", "hall.toml:17:22: expected a unit, one of mbar, "),
        ("100 ms", "2 h", "hall.toml:15:8: expected a sampling interval from 20ms to 1h, found 2h"),
        ("\"ar\"", "\"beer\"", "hall.toml:16:7: expected a gas, one of "),
        ("1e-3 mbar", "low", "hall.toml:17:22: "),
        ("baud =", "buad =", "; did you mean `baud`?"),
        ("gas =", "gass =", "hall.toml:16:1: unknown field `gass`, expected one of `name`, `address`, "),
        ("name = \"chamber\"", "name = \"\"", "hall.toml:12:8: expected a name for the gauge, found an empty string"),
        (
            "[station]",
            "[stations]",
            "hall.toml:2:2: unknown field `stations`, expected one of `station`, `tls`, `openid`, `retention`, `segment`, ",
        ),
        ("[station]", "[station]\nhosts = [\"a.example\", \"b.example:80\"]", "hall.toml:3:23: expected a name or an"),
        (
            "[station]",
            "[station]\ndatabase-check = \"3 am\"",
            "hall.toml:3:18: expected a time of the day like \"03:00\", or \"off\", got \"3 am\"",
        ),
        ("[station]", "[tls]\nkey = \"a\"\n[station]", "hall.toml:2:1: missing field `certificate`"),
        ("port = \"/dev/ttyUSB0\"", "", "missing field `port`"),
    ] {
        let found = altered(from, to);
        assert!(found.contains(sentence), "{to}: {found}");
    }
    assert_eq!(parse("").unwrap_err().to_string(), "plants/hall.toml:1:1: expected at least one [[segment]]");
    let second = FILE.split_once("[[segment]]").unwrap().1;
    let twice = FILE.to_owned() + &second.replace("name = \"hall\"", "[[segment]]\nname = \"annex\"");
    let expected = "the port \"/dev/ttyUSB0\" is defined twice; put all its gauges into one segment";
    assert_eq!(problem(&twice), expected);
}

#[test]
fn the_file_of_the_users_is_found_in_a_file_with_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hall.toml");
    for (text, expected) in [
        (FILE.replace("bcg450", "bcg451"), "hall.users.toml"),
        (FILE.replace("[station]", "[station]\nusers = \"people.toml\"\nnonsense = 1"), "people.toml"),
        (String::new(), "hall.users.toml"),
    ] {
        std::fs::write(&path, &text).unwrap();
        assert_eq!(read_users_file(&path).unwrap(), folder.path().join(expected), "{text}");
    }
    std::fs::write(&path, "[station").unwrap();
    assert!(read_users_file(&path).is_err(), "no TOML");
}

#[test]
fn a_device_may_have_the_name_on_its_nameplate() {
    for written in ["bcg450", "BCG450", "BCG450-SP", "bcg 450-sp"] {
        let config = parse(&FILE.replace("\"bcg450\"", &format!("{written:?}"))).unwrap();
        assert_eq!(config.segments[0].gauges[0].device.name, "bcg450", "{written}");
    }
}

#[test]
fn a_device_name_without_resemblance_gets_no_suggestion() {
    let found = problem(&FILE.replace("bcg450", "thermometer"));
    assert!(!found.contains("did you mean"), "{found}");
}

#[test]
fn former_keys_are_accepted_with_a_notice_that_names_line_column_and_the_new_key() {
    let old = FILE.replacen("hall\"", "hall\"\nrecord = \"old.db\"", 1)
        + "[alarms]\nblind = { priority = 'off' }\n  \"record\" = { priority = 'off' }\n";
    let config = parse(&old).unwrap();
    assert_eq!(config.database, Path::new("plants/old.db"));
    assert!(config.alarms.iter().all(|rule| rule.name != "station: not recording"));
    let notices: Vec<_> = crate::notices(&config).iter().map(ToString::to_string).collect();
    assert_eq!(
        notices,
        [
            "plants/hall.toml:4:1: the key record is now called database; the former name still works",
            "plants/hall.toml:21:4: the key record is now called database; the former name still works",
            "plants/hall.toml:20:1: the key blind is now called not-measurable; the former name still works",
        ]
    );
    let new = old
        .replace("record = \"", "database = \"")
        .replace("\"record\"", "database")
        .replace("blind", "not-measurable");
    let config = parse(&new).unwrap();
    assert_eq!((config.database.as_path(), crate::notices(&config)), (Path::new("plants/old.db"), Vec::new()));
    assert!(config.alarms.iter().all(|rule| rule.name != "station: not recording"));
}

#[test]
fn a_key_is_given_by_one_of_its_names_only() {
    let both = FILE.replacen("hall\"", "hall\"\nrecord = \"old.db\"\ndatabase = \"new.db\"", 1);
    assert_eq!(
        parse(&both).unwrap_err().to_string(),
        "plants/hall.toml:4:10: expected database or its former name record, found both: delete record"
    );
}

#[test]
fn changes_that_need_a_restart_are_listed() {
    let old = parse(FILE).unwrap();
    assert_eq!(needs_restart(&old, &old), []);
    let new = FILE.replace("Target hall\"", "Target hall\"\nlisten = \"127.0.0.1:9090\"\ndatabase = \"other.db\"");
    let needed: Vec<_> = needs_restart(&old, &parse(&new).unwrap()).iter().map(ToString::to_string).collect();
    assert_eq!(
        needed,
        [
            "listen stays 127.0.0.1:8080 until the station is restarted, then it becomes 127.0.0.1:9090",
            "database stays plants/hall.db until the station is restarted, then it becomes plants/other.db"
        ]
    );
}

#[test]
fn another_certificate_with_the_same_key_needs_a_restart() {
    let tls = |certificate| parse(&format!("{FILE}\n[tls]\ncertificate = \"{certificate}\"\nkey = \"a.key\"")).unwrap();
    let needed = needs_restart(&tls("a.pem"), &tls("b.pem"));
    assert_eq!(
        needed.iter().map(ToString::to_string).collect::<Vec<_>>(),
        [
            "tls stays plants/a.pem with plants/a.key until the station is restarted, then it becomes plants/b.pem with plants/a.key"
        ]
    );
}

#[test]
fn a_segment_without_gauges_gives_a_notice() {
    assert_eq!(notices(&parse(FILE).unwrap()), []);
    let empty = parse("[[segment]]\nname = 'a'\nport = 'b'").unwrap();
    assert_eq!(notices(&empty), [ConfigNotice::EmptySegment { segment: "a".to_owned() }]);
}

#[test]
fn two_gauges_cannot_share_an_address_or_a_name() {
    let twice = FILE.to_owned() + "[[segment.gauge]]\nname = \"second\"\naddress = 5\ndevice = \"pcg550\"\n";
    assert_eq!(problem(&twice), "address 5 is already used by another gauge or slave");
    let same_name = twice.replace("second", "chamber");
    assert_eq!(problem(&same_name), "the gauge \"chamber\" is defined twice; choose another name");
    let two_lines = FILE.replace("\"chamber\"", "\"cham\\nber\"");
    assert_eq!(problem(&two_lines), "expected visible characters in one line, found U+000A in \"cham\\nber\"");
}

#[test]
fn an_error_about_a_missing_file_names_the_file() {
    let error = crate::read(Path::new("no/such/plant.toml")).unwrap_err().to_string();
    assert!(error.starts_with("no/such/plant.toml: the file cannot be read"), "{error}");
}

const PLANT: &str = r#"
[[volume]]
name = "target"
zone = "hall"
gauges = ["chamber"]

[[volume]]
name = "fore line"

[[valve]]
name = "slide"
between = ["target", "fore line"]

[[pump]]
name = "scroll"
kind = "roughing"
inlet = "fore line"
"#;

#[test]
fn a_file_may_describe_the_plant() {
    assert_eq!(parse(FILE).unwrap().plant, PlantPicture::default());
    let plant = parse(&format!("{FILE}{PLANT}")).unwrap().plant;
    let volumes: Vec<_> = plant.volumes.iter().map(|volume| (volume.name.as_str(), volume.zone.as_deref())).collect();
    assert_eq!(volumes, [("target", Some("hall")), ("fore line", None)]);
    assert_eq!(plant.volumes[0].gauges, ["chamber"]);
    let parts: Vec<_> = plant.parts.iter().map(|part| (part.name.as_str(), part.kind, part.volumes.len())).collect();
    assert_eq!(parts, [("slide", PlantPartKind::Valve, 2), ("scroll", PlantPartKind::RoughingPump, 1)]);
}

#[test]
fn a_drawing_is_read_from_its_file_and_an_error_names_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hall.toml");
    let text = FILE.replacen("[station]\n", "[station]\ndrawing = \"hall.svg\"\n", 1);
    let parse = || crate::parse(&text, &path).map(|config| config.plant.drawing);
    let error = parse().unwrap_err().to_string();
    assert!(error.contains("hall.toml:3:") && error.contains("hall.svg: No such file"), "{error}");
    let svg =
        |id: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1 1\">\n<g id=\"{id}\"/></svg>");
    std::fs::write(folder.path().join("hall.svg"), svg("gauge:chambr")).unwrap();
    let error = parse().unwrap_err().to_string();
    assert!(
        error.ends_with("hall.svg: 2:1: the file of the station has no gauge \"chambr\"; did you mean \"chamber\"?"),
        "{error}"
    );
    std::fs::write(folder.path().join("hall.svg"), svg("gauge:chamber")).unwrap();
    assert!(parse().unwrap().unwrap().contains("data-gauge=\"chamber\""));
}

#[test]
fn a_plant_that_does_not_fit_together_is_refused() {
    let wrong = |from: &str, to: &str| problem(&format!("{FILE}{}", PLANT.replacen(from, to, 1)));
    assert_eq!(
        wrong("inlet = \"fore line\"", "inlet = \"for line\""),
        "there is no volume \"for line\"; did you mean \"fore line\"?; [[volume]] defines one"
    );
    assert_eq!(
        wrong("[\"target\", \"fore", "[\"fore line\", \"fore"),
        "expected two different volumes, found \"fore line\" twice"
    );
    assert_eq!(wrong("[\"chamber\"]", "[\"chambre\"]"), "there is no gauge \"chambre\"; did you mean \"chamber\"?");
    assert_eq!(
        wrong("name = \"fore line\"", "name = \"fore line\"\ngauges = [\"chamber\"]"),
        "the gauge \"chamber\" is at the volume \"target\" already; delete one of both"
    );
    assert_eq!(wrong("\"scroll\"", "\"slide\""), "the pump or valve \"slide\" is defined twice; choose another name");
    assert_eq!(wrong("zone = \"hall\"", "zone = \"\""), "expected a name for the zone, found an empty string");
}

#[test]
fn a_retention_has_defaults_a_range_and_may_be_unlimited() {
    let day = Duration::from_secs(86_400);
    assert_eq!(parse(FILE).unwrap().retention, Retention::default());
    let given = |lines: &str| parse(&format!("[retention]\n{lines}\n{FILE}"));
    let days = "samples = '30 days'\nspans = 'unlimited'\nevents = '1 day'\nalarm-history = '36525 days'\narchive-batches = '3 days'";
    let all = given(days).unwrap();
    let expected = Retention {
        samples: Some(day * 30),
        spans: [None; 4],
        events: Some(day),
        alarm_history: Some(day * 36_525),
        batches: Some(day * 3),
    };
    assert_eq!(all.retention, expected);
    assert_eq!(given("samples = 'unlimited'").unwrap().retention.samples, None);
    for wrong in ["23h", "36526 days", "", "soon", "-1 day"] {
        let error = given(&format!("events = '{wrong}'")).unwrap_err().to_string();
        let expected = format!(
            "plants/hall.toml:2:10: expected a time from 1 day to 36525 days, or \"unlimited\", found {wrong:?}"
        );
        assert_eq!(error, expected);
    }
    let needed = needs_restart(&parse(FILE).unwrap(), &all);
    assert_eq!(
        needed.iter().map(ToString::to_string).collect::<Vec<_>>(),
        [
            "retention stays samples 730 days, spans 1826 days, events 1826 days, alarm-history 1826 days, archive-batches 1 days until \
             the station is restarted, then it becomes samples 30 days, spans unlimited, events 1 days, alarm-history 36525 days, \
             archive-batches 3 days"
        ]
    );
}

#[test]
fn names_and_messages_that_are_not_visible_or_are_paths_are_refused_with_their_position() {
    let both = ("expected visible characters in one line, found U+202E in ", "expected a name, found the path ");
    for (from, to, position) in [
        ("name = \"Target hall\"", "name = \"{}\"", "3:8"),
        ("name = \"hall\"", "name = \"{}\"", "6:8"),
        ("name = \"chamber\"", "name = \"{}\"", "12:8"),
        ("levels = { process", "levels = { '{}'", "17:12"),
    ] {
        let error = |name: &str| {
            assert!(FILE.contains(from), "{from}");
            parse(&FILE.replacen(from, &to.replace("{}", name), 1)).unwrap_err().to_string()
        };
        let expected = |sentence: &str| format!("plants/hall.toml:{position}: {sentence}");
        let found = error("a\u{202E}b");
        assert!(found.starts_with(&expected(both.0)), "{found}");
        let found = error("..");
        assert!(found.starts_with(&expected(both.1)), "{found}");
        let found = error(&"ä".repeat(121));
        assert!(found.ends_with("of at most 120 characters, found 121; shorten it"), "{found}");
    }
    assert!(parse(&FILE.replacen("Target hall", &"ä".repeat(120), 1)).is_ok());
    let alarm = |name: &str, message: &str| {
        format!("{FILE}[[alarm]]\nname = '{name}'\ngauge = 'chamber'\nabove = '1 mbar'\nmessage = '{message}'\n")
    };
    assert!(
        problem(&alarm("a\u{200B}", "Act.")).starts_with("expected visible characters in one line, found U+200B in ")
    );
    assert!(
        problem(&alarm("a", "A\u{2066}ct.")).starts_with("expected visible characters in one line, found U+2066 in ")
    );
    assert!(parse(&alarm("a", "Close the valve.").replace("'Close the valve.'", "\"\"\"One.\nTwo.\"\"\"")).is_ok());
    let webhook = |name: &str| format!("{FILE}[[webhook]]\nname = '{name}'\nurl = 'https://example.org'\n");
    assert!(problem(&webhook("../a")).starts_with(both.1));
}

/// Such an alarm could never be raised.
#[test]
fn a_limit_that_no_reading_can_be_beyond_is_an_error() {
    let alarm = |condition: &str| format!("{FILE}[[alarm]]\nname = 'a'\ngauge = 'chamber'\n{condition}\n");
    for condition in ["above = '5000 mbar'", "below = '1e-12 mbar'"] {
        let sentence = problem(&alarm(condition));
        assert!(
            sentence.starts_with("expected a limit in the range of a bcg450, 5e-10 mbar to 1.5e3 mbar, found "),
            "{sentence}"
        );
        assert!(sentence.ends_with("no reading is beyond it, so the alarm could never be raised"), "{sentence}");
    }
    for condition in ["above = '1500 mbar'", "below = '5e-10 mbar'", "above = '1e-9 mbar'"] {
        assert!(parse(&alarm(condition)).is_ok(), "{condition}");
    }
}

#[test]
fn a_gauge_may_have_labels() {
    let labelled =
        |lines: &str| parse(&format!("{FILE}{lines}\n").replace("levels = { process = \"1e-3 mbar\" }\n", ""));
    assert_eq!(parse(FILE).unwrap().directory, Directory::default());
    let all = "group = 'target'\ntags = ['bake-out', 'ion pump']\nlocation = 'hall 2 / rack 4'\ncalibrated = 2024-02-29\n\
               calibration-interval = '365 days'";
    let labels = &labelled(all).unwrap().directory.gauges["chamber"];
    assert_eq!((labels.group.as_deref(), labels.location.as_deref()), (Some("target"), Some("hall 2 / rack 4")));
    assert_eq!(labels.tags, ["bake-out", "ion pump"]);
    assert_eq!(labels.calibrated.as_deref(), Some("2024-02-29"));
    assert_eq!(labels.calibration_due.as_deref(), Some("2025-02-28"));
    let undue = labelled("calibrated = 2026-05-01").unwrap().directory;
    assert_eq!(undue.gauges["chamber"].calibration_due, None);
}

#[test]
fn wrong_labels_are_refused_with_line_column_and_the_next_step() {
    let refused = |lines: &str| parse(&format!("{FILE}{lines}\n")).unwrap_err().to_string();
    let long = "x".repeat(41);
    let many: Vec<_> = (0..17).map(|number| format!("'{number}'")).collect();
    for (lines, sentence) in [
        ("group = ''", "18:9: expected a name for the group, found an empty string".to_owned()),
        (&format!("group = '{long}'"), "18:9: expected a group of at most 40 characters, found 41; shorten it".to_owned()),
        ("group = 'a\u{202E}b'", "18:9: expected visible characters in one line, found U+202E in ".to_owned()),
        ("tags = ['a', 'b\u{200B}']", "18:14: expected visible characters in one line, found U+200B in ".to_owned()),
        ("tags = ['a', 'a']", "18:14: the tag \"a\" is defined twice; delete one of both".to_owned()),
        (
            &format!("tags = [{}]", many.join(",")),
            "expected at most 16 tags for a gauge, found 17; delete some, or use group".to_owned(),
        ),
        ("location = '..'", "18:12: expected a name, found the path \"..\"".to_owned()),
        (
            "calibrated = '2026-05-01'",
            "18:14: expected the day of the last calibration without quotes and time, such as 2026-05-01, found \"2026-05-01\""
                .to_owned(),
        ),
        ("calibrated = 2026-05-01T10:00:00Z", "18:14: expected the day of the last calibration without quotes".to_owned()),
        ("calibrated = 2026-02-30", "plants/hall.toml:18:".to_owned()),
        (
            "calibration-interval = '365 days'",
            "18:24: calibration-interval counts from the last calibration: add calibrated = DATE".to_owned(),
        ),
        (
            "calibrated = 2026-05-01\ncalibration-interval = 'soon'",
            "19:24: expected a time from 1 day to 36525 days, such as \"365 days\", found \"soon\"".to_owned(),
        ),
        ("calibrated = 2026-05-01\ncalibration-interval = '36526 days'", "19:24: expected a time from 1 day".to_owned()),
        ("calibrated = 9999-12-31\ncalibration-interval = '1 day'", "19:24: expected a time from 1 day".to_owned()),
    ] {
        let found = refused(lines);
        assert!(found.contains(&sentence), "{lines}: {found}");
    }
}

#[test]
fn a_view_is_a_filter_of_the_overview_or_a_group_of_trends() {
    let labelled = format!("{FILE}group = 'target'\ntags = ['bake-out']\nlocation = 'rack 4'\n");
    let given = |lines: &str| parse(&format!("{labelled}[[view]]\nname = 'a'\n{lines}\n"));
    let refused = |lines: &str| given(lines).unwrap_err().problem.to_string();
    let views = given("group = 'target'\ntag = 'bake-out'\nlocation = 'rack 4'\nstate = 'no-data'\nsearch = 'cham'");
    let view = views.unwrap().directory.views.remove(0);
    assert_eq!((view.group.as_deref(), view.tag.as_deref()), (Some("target"), Some("bake-out")));
    assert_eq!((view.location.as_deref(), view.search.as_deref()), (Some("rack 4"), Some("cham")));
    assert_eq!((view.state, view.series.len()), (Some(ViewState::NoData), 0));
    let trends = given("series = ['chamber', 'chamber.2']").unwrap().directory.views.remove(0);
    assert_eq!(trends.series, ["chamber", "chamber.2"]);
    assert_eq!(
        refused("group = 'targt'"),
        "no gauge has the group \"targt\"; did you mean \"target\"?; add it to a [[segment.gauge]], or change the view"
    );
    assert!(refused("tag = 'x'").starts_with("no gauge has the tag \"x\""));
    assert!(refused("location = 'x'").starts_with("no gauge has the location \"x\""));
    assert_eq!(
        refused("state = 'bad'"),
        "expected a state, one of problems, alarms, fault, no-data, calibration-overdue, found \"bad\""
    );
    assert!(refused("series = ['chambre']").starts_with("there is no gauge \"chambre\"; did you mean \"chamber\"?"));
    assert_eq!(refused("series = ['chamber', 'chamber']"), "\"chamber\" is twice in the list of gauges");
    for lines in ["", "series = ['chamber']\nstate = 'fault'"] {
        assert!(refused(lines).starts_with("expected for the view \"a\" either series, "), "{lines}");
    }
    assert!(refused("search = 'a\u{202E}b'").starts_with("expected visible characters in one line, found U+202E in "));
    let twice = refused("state = 'fault'\n[[view]]\nname = 'a'\nstate = 'fault'");
    assert_eq!(twice, "the view \"a\" is defined twice; choose another name");
}

/// A plant with three labelled gauges, of which two have limits.
const LABELLED: &str = "
[[segment]]
name = 'hall'
port = '/dev/ttyUSB0'
[[segment.gauge]]
name = 'chamber'
address = 5
device = 'bcg450'
group = 'target'
tags = ['bake-out']
[[segment.gauge]]
name = 'lock'
address = 6
device = 'bcg450'
group = 'target'
[[segment.gauge]]
name = 'spare'
address = 7
device = 'bcg450'
group = 'store'
[[volume]]
name = 'target chamber'
zone = 'target zone'
gauges = ['chamber']
[[alarm]]
name = 'chamber high'
gauge = 'chamber'
above = '1e-3 mbar'
[[alarm]]
name = 'lock rises'
gauge = 'lock'
rise = 0.5
[[alarm]]
name = 'both high'
gauges = ['chamber', 'lock']
count = 2
above = '1 mbar'
";

fn plant_state(lines: &str) -> Result<Vec<String>, String> {
    let config = parse(&format!("{LABELLED}[[plant-state]]\nname = 'Vented'\n{lines}\n"));
    let states = config.map(|config| config.plant_states).map_err(|error| error.problem.to_string());
    states.map(|states| states[0].alarms.iter().cloned().collect())
}

#[test]
fn a_plant_state_selects_alarms_by_gauges_labels_zones_segments_kinds_and_names() {
    let of_chamber = ["chamber high", "chamber: limit not measurable"];
    assert_eq!(plant_state("gauges = ['chamber']").unwrap(), of_chamber, "both high is about another gauge too");
    assert_eq!(plant_state("tags = ['bake-out']").unwrap(), of_chamber);
    assert_eq!(plant_state("zones = ['target zone']").unwrap(), of_chamber);
    let of_both =
        ["both high", "chamber high", "chamber: limit not measurable", "lock rises", "lock: limit not measurable"];
    assert_eq!(plant_state("groups = ['target']").unwrap(), of_both);
    assert_eq!(plant_state("gauges = ['chamber', 'lock']").unwrap(), of_both, "the entries count together");
    assert_eq!(plant_state("segments = ['hall']").unwrap(), of_both);
    assert_eq!(plant_state("kinds = ['rise']").unwrap(), ["lock rises"], "of the whole plant");
    assert_eq!(plant_state("groups = ['target']\nkinds = ['rise', 'fault']").unwrap().len(), 3);
    let segment = plant_state("segments = ['hall']\nkinds = ['segment-down', 'stale']").unwrap();
    assert_eq!(segment, ["chamber: no data", "lock: no data", "segment hall: down", "spare: no data"]);
    let single = plant_state("gauges = ['chamber']\nkinds = ['above']\nalarms = ['spare: fault']").unwrap();
    assert_eq!(single, ["chamber high", "spare: fault"]);
}

#[test]
fn a_plant_state_has_defaults_and_ranges() {
    let given =
        |lines: &str| parse(&format!("{LABELLED}[[plant-state]]\nname = 'Vented'\ngauges = ['chamber']\n{lines}\n"));
    let state = given("").unwrap().plant_states.remove(0);
    let found = (state.name.as_str(), state.description.as_deref(), state.longest, state.role);
    assert_eq!(found, ("Vented", None, Duration::from_secs(86_400), profivac_web_server::auth::Role::Operator));
    let state = given("longest = '31 days'\nrole = 'engineer'\ndescription = 'open'").unwrap().plant_states.remove(0);
    assert_eq!((state.longest.as_secs(), state.role), (31 * 86_400, profivac_web_server::auth::Role::Engineer));
    for (lines, sentence) in [
        ("longest = '59 s'", "expected a time from 1m to 31 days, found 59s"),
        ("longest = '32 days'", "expected a time from 1m to 31 days, found 32d"),
        ("role = 'viewer'", "expected operator or engineer, found \"viewer\""),
        ("description = ''", "expected at least one visible character, found none"),
        ("kind = ['above']", "unknown field `kind`"),
    ] {
        let found = given(lines).unwrap_err().problem.to_string();
        assert!(found.contains(sentence), "{lines}: {found}");
    }
    let long = given(&format!("description = '{}'", "x".repeat(201))).unwrap_err().problem.to_string();
    assert_eq!(long, "expected a description of at most 200 characters, found 201; shorten it");
    let long = plant_state("gauges = ['chamber']\n[[plant-state]]\nname = 'a2345678901234567890123456789012345678901'");
    assert_eq!(long.unwrap_err(), "expected a plant state of at most 40 characters, found 41; shorten it");
    let many: String = (0..33).map(|n| format!("[[plant-state]]\nname = '{n}'\ngauges = ['chamber']\n")).collect();
    assert_eq!(problem(&format!("{LABELLED}{many}")), "expected at most 32 [[plant-state]], found 33; delete some");
    let twice = plant_state("gauges = ['chamber']\n[[plant-state]]\nname = 'Vented'\ngauges = ['chamber']");
    assert_eq!(twice.unwrap_err(), "the plant state \"Vented\" is defined twice; choose another name");
}

#[test]
fn a_plant_state_that_suppresses_nothing_is_refused_with_the_next_step() {
    for (lines, sentence) in [
        ("", "expected for the plant state \"Vented\" what it suppresses: one or more of gauges, groups, tags, "),
        ("kinds = []", "expected for the plant state \"Vented\" what it suppresses: "),
        (
            "gauges = ['chamber', 'spare']",
            "gauges: no alarm of the kinds above, below, rise, several, not-measurable is about \"spare\", so the entry suppresses \
             nothing; add an [[alarm]] about it, change kinds, or delete the entry",
        ),
        (
            "groups = ['store']",
            "groups: no alarm of the kinds above, below, rise, several, not-measurable is about \"store\"",
        ),
        ("zones = ['target zone']\nkinds = ['rise']", "zones: no alarm of the kinds rise is about \"target zone\""),
        (
            "gauges = ['lock']\nkinds = ['rise', 'below']",
            "kinds: the plant state \"Vented\" has no alarm of the kind below; delete it, or add the gauges of such an alarm",
        ),
        ("gauges = ['chambre']", "there is no gauge \"chambre\"; did you mean \"chamber\"?"),
        (
            "groups = ['targt']",
            "no gauge has the group \"targt\"; did you mean \"target\"?; add it to a [[segment.gauge]], or change the plant state",
        ),
        ("tags = ['x']", "no gauge has the tag \"x\"; add it to a [[segment.gauge]], or change the plant state"),
        (
            "zones = ['target']",
            "no gauge has the zone \"target\"; did you mean \"target zone\"?; add it to a [[volume]] with its gauges, ",
        ),
        (
            "segments = ['hal']",
            "there is no segment \"hal\"; write the name of a [[segment]], or add one; did you mean \"hall\"?",
        ),
        (
            "alarms = ['chamber hihg']",
            "there is no alarm \"chamber hihg\"; did you mean \"chamber high\"?; the page Alarms and ",
        ),
        (
            "kinds = ['abov']",
            "expected a kind of alarms, one of above, below, rise, several, point, not-measurable, fault, stale, segment-down, ",
        ),
        ("kinds = ['not-recording']", "expected a kind of alarms, one of above, "),
        (
            "alarms = ['station: not recording']",
            "no plant state suppresses the alarm \"station: not recording\": a station must record in every state; delete the entry",
        ),
        ("kinds = ['database-damaged']", "expected a kind of alarms, one of above, "),
        (
            "alarms = ['station: database damaged']",
            "no plant state suppresses the alarm \"station: database damaged\": a station must record in every state",
        ),
    ] {
        let found = plant_state(lines).unwrap_err();
        assert!(found.starts_with(sentence), "{lines}: {found}");
    }
    let error =
        parse(&format!("{LABELLED}[[plant-state]]\nname = 'Vented'\ngauges = ['chamber', 'spare']\n")).unwrap_err();
    assert_eq!((error.line, error.column), (40, 22));
}

/// A device file like bcg450 with this name and Ident_Number.
fn device(name: &str, ident: u16) -> String {
    format!("format = 1\nname = \"{name}\"\ntitle = \"{name}\"\nlike = \"bcg450\"\nident = {ident}\n")
}

#[test]
fn a_gauge_has_a_device_of_a_file_by_its_name_or_by_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hall.toml");
    std::fs::create_dir(folder.path().join("devices")).unwrap();
    std::fs::write(folder.path().join("devices/beside.toml"), device("beside", 0x1001)).unwrap();
    std::fs::write(folder.path().join("named.toml"), device("named", 0x1002)).unwrap();
    let keyed = FILE.replace("[station]", "[station]\ndevice-files = [\"named.toml\"]");
    for (text, written, expected) in [
        (FILE, "beside", "beside"),
        (&keyed, "named", "named"),
        (FILE, "named.toml", "named"),
        (&keyed, "bcg450", "bcg450"),
    ] {
        let text = text.replace("\"bcg450\"", &format!("{written:?}"));
        let config = crate::parse(&text, &path).unwrap();
        let segment = &config.segments[0];
        assert_eq!(segment.gauges[0].device.name, expected, "{written}");
        assert_eq!(segment.devices, config.devices);
        assert!(config.devices.named("beside").is_some(), "the folder beside the file needs no key");
    }
    let unknown = crate::parse(&FILE.replace("\"bcg450\"", "\"named\""), &path).unwrap_err().to_string();
    assert!(unknown.contains(":14:10: unknown device \"named\"") && unknown.contains("img400, beside"), "{unknown}");
}

#[test]
fn a_wrong_device_file_is_an_error_at_the_key_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hall.toml");
    let wrong = folder.path().join("wrong.toml");
    std::fs::write(&wrong, "format = 1\nname = 7\n").unwrap();
    let keyed = FILE.replace("[station]", "[station]\ndevice-files = [\"wrong.toml\"]");
    let said = crate::parse(&keyed, &path).unwrap_err().to_string();
    assert!(said.starts_with(&format!("{}:3:17: {}:2:", path.display(), wrong.display())), "{said}");
    let said = crate::parse(&FILE.replace("bcg450", "wrong.toml"), &path).unwrap_err().to_string();
    assert!(said.starts_with(&format!("{}:14:10: {}:2:", path.display(), wrong.display())), "{said}");
}

#[test]
fn a_device_file_that_changes_while_the_station_runs_counts_from_the_next_start_on() {
    let folder = tempfile::tempdir().unwrap();
    let (path, file) = (folder.path().join("hall.toml"), folder.path().join("own.toml"));
    let text = FILE.replace("bcg450", "own.toml");
    std::fs::write(&file, device("own", 0x1001)).unwrap();
    let running = crate::parse(&text, &path).unwrap();
    let mut again = crate::parse(&text, &path).unwrap();
    assert_eq!(crate::keep_devices(running.devices, &mut again), [""; 0]);
    assert!(running.segments[0].gauges[0].is_same_slave(&again.segments[0].gauges[0]));
    std::fs::write(&file, device("own", 0x1002)).unwrap();
    let mut changed = crate::parse(&text, &path).unwrap();
    assert_eq!(changed.segments[0].gauges[0].device.ident, 0x1002);
    assert_eq!(crate::keep_devices(running.devices, &mut changed), ["own"]);
    assert_eq!(changed.segments[0].gauges[0].device.ident, 0x1001);
    assert_eq!((changed.devices, changed.segments[0].devices), (running.devices, running.devices));
    // A device that the station did not know is taken as it is.
    assert_eq!(crate::keep_devices(profivac_devices::catalog::KnownDevices::BUILT_IN, &mut changed), [""; 0]);
    assert_eq!(changed.segments[0].gauges[0].device.ident, 0x1001);
}
