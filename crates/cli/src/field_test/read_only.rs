//! A link that sends only requests that change nothing in a slave.
//!
//! The rules of `conform` begin with any request. The link passes the requests on that only read, and withholds the others:
//! a rule that needs one of them is not tested.

use profivac_conform::dialogue::Link;
use profivac_conform::probe::Received;
use profivac_host::port::PortError;
use profivac_wire::control::{Control, Function};
use profivac_wire::{BROADCAST, DataTelegram, Sap, Telegram};
use std::time::Duration;

/// Initiate, Idle, Abort and Read over MS2: they open, keep and close a connection, and read. profibus-wire 4.1.
const READING_FUNCTIONS: [u8; 4] = [0x57, 0x48, 0x58, 0x5E];

/// Sends only requests that change nothing.
pub struct ReadOnlyLink<'a>(pub &'a mut dyn Link);

impl Link for ReadOnlyLink<'_> {
    fn address(&self) -> u8 {
        self.0.address()
    }

    fn permits(&self, octets: &[u8]) -> bool {
        Request::of(octets) == Request::Reads
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        if self.permits(octets) { self.0.send_and_receive(octets) } else { Ok(Received::Nothing) }
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.0.wait(time)
    }

    fn take_disturbed(&mut self) -> bool {
        self.0.take_disturbed()
    }
}

/// What a request does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Request {
    /// It reads.
    Reads,
    /// It may change the slave, or is no request that a master sends.
    Other,
}

impl Request {
    fn of(octets: &[u8]) -> Self {
        match Telegram::parse(octets) {
            Ok(Telegram::Data(data)) if data.da != BROADCAST && data.sa != BROADCAST => Self::of_telegram(&data),
            Ok(Telegram::Data(_) | Telegram::ShortAck | Telegram::Token { .. }) | Err(_) => Self::Other,
        }
    }

    fn of_telegram(data: &DataTelegram<'_>) -> Self {
        let Control::Request { function, .. } = data.control() else { return Self::Other };
        match (function, Sap::from_octet(data.dsap)) {
            (Function::FdlStatus, _) => Self::Reads,
            (Function::SrdLow | Function::SrdHigh, sap) => Self::of_service(sap, data.du),
            _ => Self::Other,
        }
    }

    fn of_service(sap: Sap, du: &[u8]) -> Self {
        match (sap, du) {
            (Sap::SlaveDiag | Sap::GetCfg | Sap::RdInp | Sap::RdOutp | Sap::Other(_), []) => Self::Reads,
            (Sap::Ms2(_) | Sap::ResourceManager, []) => Self::Reads,
            (Sap::Ms2(_) | Sap::ResourceManager, [function, ..]) if READING_FUNCTIONS.contains(function) => Self::Reads,
            _ => Self::Other,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_conform::dialogue::octets;

    /// Keeps what it is given to send.
    #[derive(Default)]
    struct Line(Vec<Vec<u8>>);

    impl Link for Line {
        fn address(&self) -> u8 {
            0
        }

        fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
            self.0.push(octets.to_vec());
            Ok(Received::Damaged)
        }

        fn wait(&mut self, _: Duration) -> Result<(), PortError> {
            Ok(())
        }
    }

    const SRD: u8 = 0x6D;
    const RELEASE: [u8; 7] = [0x40, 0, 0, 0, 0, 0, 0];

    fn srd(sap: Sap, du: &[u8]) -> Vec<u8> {
        octets(5, 0, sap, SRD, du)
    }

    #[test]
    fn only_requests_that_read_reach_the_line() {
        let reading = [
            octets(5, 0, Sap::Default, 0x49, &[]),
            srd(Sap::SlaveDiag, &[]),
            srd(Sap::GetCfg, &[]),
            srd(Sap::Ms2(3), &[0x5E, 1, 2, 4]),
            srd(Sap::Ms2(3), &[]),
        ];
        let mut cut_off = srd(Sap::SlaveDiag, &[]);
        cut_off.pop();
        let other = [
            srd(Sap::Default, &[]),
            srd(Sap::Default, &[0]),
            srd(Sap::SetPrm, &[0x80, 0, 0, 11, 8, 0xE6, 0]),
            srd(Sap::SetPrm, &RELEASE),
            srd(Sap::ChkCfg, &[0x11]),
            srd(Sap::SetSlaveAdd, &[6, 8, 0xE6, 0]),
            srd(Sap::Ms1, &[0x5E, 1, 2, 4]),
            srd(Sap::Ms2(3), &[0x5F, 1, 2, 1, 0]),
            octets(127, 0, Sap::GlobalControl, 0x46, &[2, 0]),
            vec![0xDC, 5, 0],
            vec![0xE5],
            cut_off,
        ];
        for (requests, reads) in [(&reading[..], true), (&other[..], false)] {
            for request in requests {
                let mut line = Line::default();
                assert_eq!(ReadOnlyLink(&mut line).permits(request), reads, "{request:02X?}");
                let received = ReadOnlyLink(&mut line).send_and_receive(request).unwrap();
                assert_eq!(
                    (received == Received::Damaged, line.0.len()),
                    (reads, usize::from(reads)),
                    "{request:02X?}"
                );
            }
        }
    }
}
