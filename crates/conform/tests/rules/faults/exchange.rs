//! Slaves with a fault in data exchange, RD_Inp, RD_Outp or Global_Control.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave(
        "exchange.inputs",
        "sends an octet of inputs too few",
        ChangesAnswer(|request, answer| {
            if request.is_exchange() {
                answer.du.pop();
            }
        }),
    ),
    slave(
        "exchange.wrong-length",
        "ignores surplus outputs",
        ChangesRequest(|request| {
            if request.is_exchange() {
                request.du.truncate(2);
            }
        }),
    ),
    slave(
        "exchange.diagnosis-flag",
        "announces a diagnosis for ever",
        ChangesAnswer(|request, answer| {
            if request.is_exchange() && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    slave(
        "exchange.fdl-status",
        "ignores FDL status during data exchange",
        Answers(
            |slave, request, answer| {
                if request.function() == FDL_STATUS && is_exchanging(slave) { Received::Nothing } else { answer }
            },
        ),
    ),
    slave(
        "exchange.undisturbed",
        "leaves data exchange with Get_Cfg",
        Reacts(|| ends_exchange(|request| request.dsap == GET_CFG)),
    ),
    slave(
        "exchange.set-slave-add",
        "acknowledges Set_Slave_Add at any time",
        Answers(|_, request, answer| if request.dsap == SET_SLAVE_ADD && is_rs(&answer) { sc() } else { answer }),
    ),
    slave(
        "read.inputs-closed",
        "answers RD_Inp outside data exchange",
        Answers(|slave, request, answer| if request.dsap == RD_INP && is_waiting(slave) { sc() } else { answer }),
    ),
    slave(
        "read.outputs-closed",
        "answers RD_Outp outside data exchange",
        Answers(|slave, request, answer| if request.dsap == RD_OUTP && is_waiting(slave) { sc() } else { answer }),
    ),
    slave("read.inputs", "sends an octet too many for RD_Inp", Returns(RD_INP, |du| du.push(0))),
    slave(
        "read.inputs-image",
        "sends other inputs for RD_Inp than for Data_Exchange",
        Returns(RD_INP, |du| du[0] ^= 0x01),
    ),
    slave("read.inputs-any-master", "refuses the inputs to a second master", RefusesOthers(RD_INP)),
    slave("read.outputs", "sends an octet too many for RD_Outp", Returns(RD_OUTP, |du| du.push(0))),
    slave(
        "read.outputs-image",
        "sends other outputs for RD_Outp than it received",
        Returns(RD_OUTP, |du| du[0] ^= 0x01),
    ),
    slave(
        "control.broadcast",
        "acknowledges Global_Control to all slaves",
        Answers(|_, request, answer| if request.dsap == GLOBAL_CONTROL && request.da == 127 { sc() } else { answer }),
    ),
    slave(
        "control.single",
        "acknowledges Global_Control to itself",
        Answers(|_, request, answer| {
            if request.dsap == GLOBAL_CONTROL && request.da == ADDRESS && request.function() == 6 {
                sc()
            } else {
                answer
            }
        }),
    ),
    slave(
        "control.clear",
        "leaves data exchange with Clear_Data",
        Reacts(|| ends_exchange(|request| request.dsap == GLOBAL_CONTROL && request.du == [0x02, 0])),
    ),
    slave("control.sync", "does not report Sync_Mode", Reports(|du| du[TWO] &= !0x20)),
    slave("control.unsync", "ignores Unsync", ChangesRequest(|request| command(request, |octet| octet & !0x10))),
    slave(
        "control.owner",
        "obeys Global_Control of any master",
        ChangesRequest(|request| {
            if request.dsap == GLOBAL_CONTROL {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "control.group",
        "obeys Global_Control to any group",
        ChangesRequest(|request| {
            if request.dsap == GLOBAL_CONTROL {
                request.du[1] = 0;
            }
        }),
    ),
    slave("control.freeze", "does not report Freeze_Mode", Reports(|du| du[TWO] &= !0x10)),
    slave("control.unfreeze", "ignores Unfreeze", ChangesRequest(|request| command(request, |octet| octet & !0x04))),
];

/// Changes Control_Command.
fn command(request: &mut Frame, change: impl FnOnce(u8) -> u8) {
    if request.dsap == GLOBAL_CONTROL {
        request.du[0] = change(request.du[0]);
    }
}
