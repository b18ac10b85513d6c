//! Slaves with a fault in the lock to their owner.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave(
        "lock.set-prm",
        "accepts Set_Prm of any master",
        Reacts(|| {
            Box::new(|line, octets| {
                if Frame::parse(octets).is_some_and(|request| is_valid_prm(&request) && request.sa != MASTER) {
                    leave(line);
                }
                line.send(octets)
            })
        }),
    ),
    slave(
        "lock.undisturbed",
        "takes Set_Prm of any master for one of its owner",
        ChangesRequest(|request| {
            if is_valid_prm(request) {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "lock.chk-cfg",
        "accepts Chk_Cfg of any master",
        ChangesRequest(|request| {
            if request.dsap == CHK_CFG {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "lock.exchange",
        "exchanges data with any master",
        ChangesRequest(|request| {
            if request.is_exchange() {
                request.sa = MASTER;
            }
        }),
    ),
];
