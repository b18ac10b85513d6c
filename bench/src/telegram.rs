//! One telegram from and to a buffer.

use profirust::fdl;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::hint::black_box;

/// 41 octets in all: 32 of data, as Data_Exchange carries them.
const DATA: [u8; 32] = *b"thirty-two octets of cyclic data";

const FRAME: DataTelegram<'_> = DataTelegram {
    da: 5,
    sa: 2,
    dsap: None,
    ssap: None,
    fc: Control::Request { function: Function::SrdHigh, count: FrameCount::Counted(true) }.to_octet(),
    du: &DATA,
};

/// The telegram on the wire.
pub fn octets() -> Vec<u8> {
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(FRAME).emit(&mut out).unwrap_or(0);
    out[..length].to_vec()
}

pub fn decode(times: u32) {
    let octets = octets();
    for _ in 0..times {
        let _ = black_box(Telegram::parse(black_box(&octets)));
    }
}

pub fn decode_peer(times: u32) {
    let octets = octets();
    for _ in 0..times {
        let _ = black_box(fdl::Telegram::deserialize(black_box(&octets)));
    }
}

pub fn encode(times: u32) {
    let mut out = [0; MAX_TELEGRAM];
    for _ in 0..times {
        let _ = black_box(black_box(Telegram::Data(FRAME)).emit(black_box(&mut out)));
    }
}

pub fn encode_peer(times: u32) {
    let mut out = [0; MAX_TELEGRAM];
    let header = || fdl::DataTelegramHeader {
        da: 5,
        sa: 2,
        dsap: None,
        ssap: None,
        fc: fdl::FunctionCode::new_srd_high(fdl::FrameCountBit::High),
    };
    for _ in 0..times {
        let transmit = fdl::TelegramTx::new(black_box(&mut out));
        black_box(transmit.send_data_telegram(black_box(header()), DATA.len(), |du| du.copy_from_slice(&DATA)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_implementations_encode_the_same_telegram() {
        let octets = octets();
        assert_eq!(octets.len(), 41);
        assert_eq!(Telegram::parse(&octets), Ok(Telegram::Data(FRAME)));
        let Some(Ok((fdl::Telegram::Data(theirs), 41))) = fdl::Telegram::deserialize(&octets) else {
            panic!("refused")
        };
        assert_eq!((theirs.h.da, theirs.h.sa, theirs.pdu), (5, 2, &DATA[..]));
    }
}
