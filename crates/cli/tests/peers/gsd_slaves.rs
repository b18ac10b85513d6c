//! Slaves by their GSD files, which two independent masters bring to Data_Exchange: valves, an encoder and a transmitter.

use crate::common::{Folder, Program, octets};
use crate::peers::slave::Slave;
use crate::peers::{PROFIRUST, pyprofibus_master};
use crate::until::until;
use std::path::Path;

/// A slave of an invented file: as `simulate` has it, and as a master has it from the same file.
struct Case {
    spec: &'static str,
    ident: u16,
    cfg: &'static str,
    user_prm: &'static str,
    /// What the master sends, in the module of slot 1.
    outputs: &'static str,
    /// The line that sets the inputs, and what the master receives.
    line: &'static str,
    inputs: &'static str,
}

const CASES: [Case; 3] = [
    Case {
        spec: "valves.gsd@9:modules=3+7",
        ident: 0xF001,
        cfg: "20 11",
        user_prm: "80 00 00 01 01 F4",
        outputs: "A5",
        line: "input 9 2 16#1F 80",
        inputs: "1F 80",
    },
    Case {
        spec: "encoder.gsd@9:modules=2",
        ident: 0xF002,
        cfg: "F1",
        user_prm: "02 10 00",
        outputs: "00 01 E2 40",
        line: "input 9 1 u32:305419896",
        inputs: "12 34 56 78",
    },
    Case {
        spec: "pressure.gsd@9",
        ident: 0xF003,
        cfg: "42 84 08 05 42 84 08 05",
        user_prm: "00 00 00",
        outputs: "",
        line: "input 9 2 float:-1.5 80",
        inputs: "00 00 00 00 00 BF C0 00 00 80",
    },
];

impl Case {
    fn slave(&self) -> Slave {
        Slave {
            address: 9,
            ident: self.ident,
            cfg: octets(self.cfg),
            user_prm: octets(self.user_prm),
            outputs: octets(self.outputs).len(),
            inputs: octets(self.inputs).len(),
        }
    }

    /// The slave on a line of its own, beside a gauge.
    fn simulator(&self, folder: &Folder) -> Program {
        let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/support/gsd").join(self.spec);
        let program =
            Program::start(&["simulate", "--pty", &folder.name("line"), "bcg450@5", &files.display().to_string()]);
        program.ready();
        program
    }
}

#[test]
fn pyprofibus_exchanges_outputs_and_inputs_with_slaves_by_their_files() {
    for case in &CASES {
        let folder = Folder::new();
        let mut simulator = case.simulator(&folder);
        let master = pyprofibus_master::start_with(&folder.path("line"), &case.slave(), case.outputs);
        master.until_exchanging();
        assert_eq!(simulator.tell(case.line), "ok", "{}", case.spec);
        master.until(case.spec, |inputs| inputs == octets(case.inputs));
        let state = until(case.spec, || {
            let state = simulator.state(9);
            (state["modules"][0]["outputs"] == case.outputs).then_some(state)
        });
        assert_eq!((&state["state"], &state["master"]), (&"DATA-EXCH".into(), &2.into()), "{}", case.spec);
        assert_eq!(state["user_prm"], case.user_prm, "{}", case.spec);
    }
}

#[test]
fn profirust_reads_inputs_of_slaves_by_their_files() {
    for case in &CASES {
        let folder = Folder::new();
        let mut simulator = case.simulator(&folder);
        let master = PROFIRUST(&folder.path("line"), &case.slave());
        assert_eq!(simulator.tell(case.line), "ok", "{}", case.spec);
        master.until(case.spec, |inputs| inputs == octets(case.inputs));
    }
}

#[test]
fn the_user_reads_why_the_slave_refuses_a_master() {
    let folder = Folder::new();
    let simulator = CASES[0].simulator(&folder);
    let wrong = Slave { user_prm: octets("80 00 00 00 00 09"), ..CASES[0].slave() };
    let _master = pyprofibus_master::start_with(&folder.path("line"), &wrong, "00");
    simulator
        .wait_for_complaint("slave 9: refused Set_Prm: slot 1: Switching time cannot be 9; possible are 10 to 1000");
}
