//! Reading is harmless: a tap on the same line receives every request of `list`, `read`, `dump`, `diff` and
//! `restore --dry-run`.

use crate::common::{End, Folder, Program, octets, run};
use profivac_devices::catalog::MODELS;
use profivac_explain::frame::{Chunk, Framer, TimeSource};
use profivac_wire::Telegram;
use profivac_wire::control::Control;
use std::time::Duration;

/// The address of a slave that marks the end of a recording: no tested command sends a request to it.
const LAST: (&str, &str) = ("10 7D 01 49 C7 16", "10 01 7D 00 7E 16");

/// One request: FC, DSAP and data unit.
type Asked = (u8, Option<u8>, Vec<u8>);

/// The requests to `address` in the received octets.
fn requests(received: &[u8], address: u8) -> Vec<Asked> {
    let (mut framer, mut pieces) = (Framer::new(TimeSource::Platform), Vec::new());
    framer.push(&Chunk { octets: received.to_vec(), ..Chunk::default() }, &mut pieces);
    framer.flush(&mut pieces);
    let asked = pieces.iter().filter_map(|piece| match Telegram::parse(&piece.octets) {
        Ok(Telegram::Data(frame)) if frame.da == address && matches!(frame.control(), Control::Request { .. }) => {
            Some((frame.fc, frame.dsap, frame.du.to_vec()))
        }
        _ => None,
    });
    asked.collect()
}

/// Runs a command and returns the requests that were received meanwhile.
fn received(port: &str, line: &str, command: &[&str]) -> Vec<Asked> {
    let mut listener = End::tcp(line);
    let output = run(&[&command[..1], &["--port", port, "--address", "5"], &command[1..]].concat());
    assert!(output.status.code() < Some(2), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    listener.send(LAST.0);
    let (mut received, last) = (Vec::new(), octets(LAST.1));
    while !received.windows(last.len()).any(|octets| octets == last) {
        let more = listener.receive_within(Duration::from_secs(20));
        assert!(!more.is_empty(), "{command:?}");
        received.extend(more);
    }
    requests(&received, 5)
}

/// Set_Prm, Chk_Cfg, Global_Control, Set_Slave_Add: they change a slave or take ownership.
const CLAIMING: [u8; 4] = [61, 62, 58, 55];

/// Slave_Diag, Get_Cfg, the resource manager of MS2 and its connections.
fn is_read_only(sap: u8) -> bool {
    matches!(sap, 0..=49 | 59 | 60) && !CLAIMING.contains(&sap)
}

#[test]
fn reading_takes_no_ownership_and_restores_the_selector() {
    for name in ["psg554", "bpg400", "hpg400", "bcg450", "tpg500", "img400"] {
        let model = MODELS.iter().find(|model| model.name == name).unwrap();
        let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", &format!("{name}@5"), "bcg450@125"]);
        let line = simulation.ready();
        let (port, folder) = (format!("tcp://{line}"), Folder::new());
        let file = folder.name("gauge.toml");
        let commands: [&[&str]; 6] = [
            &["list"],
            &["read", "0/25", "1/19"],
            &["dump"],
            &["dump", "--out", &file, "--force"],
            &["diff", &file],
            &["restore", "--dry-run", &file],
        ];
        for command in commands {
            // A device without MS2 cannot be read this way.
            if command.contains(&file.as_str()) && !model.features.dpv1 {
                continue;
            }
            let asked = received(&port, &line, command);
            let case = format!("{name} {command:?}");
            assert!(!asked.is_empty(), "{case}");
            for (fc, sap, du) in &asked {
                // FDL status, or a service that only reads. A request without access points would be Data_Exchange.
                assert!(fc & 0x0F == 9 || sap.is_some_and(is_read_only), "{case}: {fc:02X} {sap:?} {du:02X?}");
            }
            let written: Vec<_> =
                asked.iter().filter(|(_, sap, du)| matches!(sap, Some(0..=48)) && du.first() == Some(&0x5F)).collect();
            // Only the Channel Instance Selector is written, and it is restored.
            assert!(written.iter().all(|(_, _, du)| du.len() == 5), "{case}: {written:02X?}");
            if let (Some((_, _, last)), true) = (written.last(), command[0] == "dump") {
                assert_eq!(last.last(), Some(&1), "{case}: {written:02X?}");
            }
        }
    }
}
