//! `--via ms1` and `--via pkw`: announced, refused where another master owns the slave, unit kept, unlocked at the end.

use crate::common::{End, Program, run, sd2};
use crate::gauge_commands::Line;

/// Slave_Diag of a slave without an owner that waits for parameters.
const FREE: &str = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16";

#[test]
fn every_access_path_reads_the_same() {
    let mut line = Line::with(&["--pressure", "5e-6 mbar", "bcg450@5:unit=torr", "pcg550@6", "img400@7", "hpg400@8"]);
    line.output("write", 5, &["execute"]);
    for (address, target, printed) in [
        (5, "pirani.safe-state", "pirani.safe-state = zero\n"),
        (5, "cdg.overrange", "cdg.overrange = 1125.0925 Torr\n"),
        (6, "trip-point.1/low-trip-point", "trip-point.1/low-trip-point = 5e-5 mbar\n"),
        (7, "channel.3/safe-value", "channel.3/safe-value = 0 hPa\n"),
        (8, "hp.full-scale", "hp.full-scale = 1 mbar\n"),
    ] {
        assert_eq!(line.output("read", address, &[target]), printed, "ms2 {address}");
        for way in ["ms1", "pkw"] {
            let done = line.run("read", address, &["--via", way, "--own", target]);
            assert_eq!((done.code, done.out.as_str()), (0, printed), "{way} {address}: {}", done.err);
            assert!(
                done.err
                    .contains("gets its parameters from this master now, keeps its unit, and is unlocked at the end"),
                "{}",
                done.err
            );
        }
    }
    let mut end = End::pty(&line.folder.path("line"));
    end.insist(&sd2(5, 60, 0x6D, ""), FREE);
    assert_eq!(line.output("read", 5, &["pirani.data-units"]), "pirani.data-units = Torr\n");
    assert!(line.simulation.state(5).is_object());
}

#[test]
fn every_access_path_writes() {
    let line = Line::with(&["bcg450@5", "tpg500@6"]);
    for (way, from, to) in [("ms1", "zero", "full-scale"), ("pkw", "full-scale", "zero")] {
        let printed = line.output("write", 5, &["--via", way, "--own", "pirani.safe-state", to]);
        assert_eq!(printed, format!("pirani.safe-state: {from} -> {to}\n"));
    }
    let pkw = ["--via", "pkw", "--own"];
    let write = |target, value| line.output("write", 6, &[&pkw[..], &[target, value]].concat());
    assert_eq!(write("a2.filter-time-constant", "fast"), "a2.filter-time-constant: medium -> fast\n");
    let closed = "tpg300 or tpg500 at address 6, relay.1/upper-threshold (slot 5, index 21): writing was refused with code 17: instruction \
                  not allowed in this state; open the set first: write relay.1/threshold-validation open-for-changes, and \
                  valid afterwards\n";
    let done = line.run("write", 6, &[&pkw[..], &["relay.1/upper-threshold", "5e-3 mbar"]].concat());
    assert_eq!(done.code, 1);
    assert!(done.err.ends_with(closed), "{}", done.err);
}

/// The data type of pressures is a setting too: parameterising the gauge must not change it.
#[test]
fn unit_and_data_type_are_kept() {
    let line = Line::with(&["img400@7:unit=pascal", "bcg450@5"]);
    line.output("write", 5, &["pirani.data-type", "integer"]);
    for way in ["ms1", "pkw"] {
        line.output("read", 7, &["--via", way, "--own", "channel.1/safe-state"]);
        line.output("read", 5, &["--via", way, "--own", "pirani.safe-state"]);
        let img = line.output("read", 7, &["channel.1/data-type", "channel.1/data-units"]);
        assert_eq!(img, "channel.1/data-type = float\nchannel.1/data-units = Pascal\n", "{way}");
        assert_eq!(line.output("read", 5, &["pirani.data-type"]), "pirani.data-type = integer\n", "{way}");
    }
}

#[test]
fn a_slave_of_another_master_is_refused() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = simulation.ready();
    let port = format!("tcp://{address}");
    let mut master = End::tcp(&address);
    master.ask(&sd2(5, 61, 0x5D, "80 00 00 0B 08 E6 00 00 00 00 05 1C"), "E5");
    for way in ["ms1", "pkw"] {
        let failed = run(&["read", "--port", &port, "--address", "5", "--via", way, "--own", "0/25"]);
        assert_eq!(failed.status.code(), Some(1));
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!(message, "profivac: the slave at address 5 belongs to master 2\n");
    }
    // Reading by MS2 does not disturb the other master.
    let read = run(&["read", "--port", &port, "--address", "5", "0/25"]);
    assert_eq!(read.status.code(), Some(0), "{}", String::from_utf8_lossy(&read.stderr));
}

#[test]
fn a_script_must_give_own_for_a_slave() {
    let line = Line::with(&["bcg450@5"]);
    let own = "--via ms1 and pkw take ownership of the gauge and set its parameters; without a terminal add --own";
    line.fails("read", 5, &["--via", "ms1", "0/25"], 2, own);
    let mut end = End::pty(&line.folder.path("line"));
    end.insist(&sd2(5, 60, 0x6D, ""), FREE);
}

#[test]
fn the_error_names_an_access_path_that_the_device_lacks() {
    let line = Line::with(&["tpg300@6", "pcg550@5"]);
    let done = line.run("read", 6, &["--via", "ms1", "--own", "a1.pressure-unit"]);
    assert_eq!(done.code, 1);
    assert!(done.err.ends_with("tpg300 or tpg500 at address 6: it has no MS1; say --via pkw\n"), "{}", done.err);
    let done = line.run("read", 5, &["--via", "pkw", "--own", "serial-number"]);
    assert_eq!(done.code, 1);
    assert!(done.err.contains("code 13: a text cannot be read this way"), "{}", done.err);
}

/// A controller has its values in the cyclic data and its unit in the parameter channel.
#[test]
fn a_controller_is_monitored() {
    let line = Line::with(&["--pressure", "5e-6 mbar", "tpg500@6:a1=pirani,b2=none"]);
    let done = run(&["monitor", "--port", &line.path, "--own", "--for", "1.5", "--json", "6"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let printed = String::from_utf8(done.stdout).unwrap();
    let rows: Vec<serde_json::Value> = printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let summary = |row: &serde_json::Value| {
        (row["instance"].as_u64().unwrap(), row["pressure"].as_f64(), row["remarks"][0].clone())
    };
    assert_eq!(summary(&rows[0]), (1, None, "under range".into()));
    assert_eq!((&rows[0]["quality"], rows[0]["limit_mbar"].as_f64()), (&"underrange".into(), Some(8e-4)));
    assert_eq!(summary(&rows[2]), (3, Some(5e-6), serde_json::Value::Null));
    assert_eq!(summary(&rows[3]), (4, None, "no gauge".into()));
}
