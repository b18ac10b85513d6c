//! Counts instructions: the handlers of the bus are called with telegrams, octet by octet, as the interrupts do.
//!
//! QEMU with `-icount shift=10` executes an instruction in 1024 ns, which are 25.6 ticks of the timer. The entry and the end of an
//! interrupt, which the processor does without instructions, are not in it.

use crate::gauge::{adopt, character, publish, start_bus, work};
use core::sync::atomic::{AtomicU32, Ordering};
use profivac_board as board;
use profivac_devices::profile::beside::Application;
use profivac_devices::profile::{Behaviour, BlockDevice};
use profivac_devices::store::Store;
use profivac_dp::link::Baud;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};

/// A request, by its access points and data unit.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// The name in the table.
    pub name: &'static str,
    /// Destination and source access point.
    pub saps: Option<(u8, u8)>,
    /// The data unit.
    pub du: &'static [u8],
}

/// The longest time in which the main context has held the work context up, in ticks.
static LONGEST_HOLD: AtomicU32 = AtomicU32::new(0);

/// The main context has held the work context up for these ticks.
pub(crate) fn work_was_held(ticks: u32) {
    let longest = LONGEST_HOLD.load(Ordering::Relaxed).max(ticks);
    LONGEST_HOLD.store(longest, Ordering::Relaxed);
}

/// The address of the gauge.
const ADDRESS: u8 = 5;
/// The address of the master.
const MASTER: u8 = 2;

/// The instructions in these ticks: 10 in 256.
const fn instructions(ticks: u32) -> u32 {
    ticks.wrapping_mul(10) / 256
}

/// Sends the requests in turn, and prints for each the instructions from its last octet to its answer, and those of the application
/// after it; then those of an octet.
pub fn measure<B: Behaviour, S: Store>(device: &mut BlockDevice<B, S>, requests: &[Request]) {
    start_bus(device, Some(Baud::B1500000));
    let mut application = Application::new(device);
    let mut fcb = false;
    let empty = time(|| {});
    let (mut octets, mut sum, mut worst) = (0_u32, 0_u32, 0_u32);
    for (number, request) in requests.iter().enumerate() {
        fcb = !fcb;
        let count = if number == 0 { FrameCount::First } else { FrameCount::Counted(fcb) };
        let fc = Control::Request { function: Function::SrdHigh, count }.to_octet();
        let (dsap, ssap) = request.saps.unzip();
        let telegram = Telegram::Data(DataTelegram { da: ADDRESS, sa: MASTER, dsap, ssap, fc, du: request.du });
        let mut target = [0; MAX_TELEGRAM];
        let length = telegram.emit(&mut target).unwrap_or(0);
        board::pause(2_000_000);
        let Some((last, first)) = target.get(..length).and_then(<[u8]>::split_last) else { return };
        for octet in first {
            let cost = time(|| character(Ok(*octet))).saturating_sub(empty);
            octets = octets.wrapping_add(1);
            sum = sum.wrapping_add(cost);
            worst = worst.max(cost);
        }
        let answer = time(|| {
            character(Ok(*last));
            work();
        });
        // Without interrupts the answer never leaves, and the flash would wait for its end.
        board::cancel();
        let after = time(|| {
            adopt(&mut application);
            publish(&mut application);
            // Nothing has come: the slave prepares its next answer.
            work();
        });
        row(request.name, &[answer.saturating_sub(empty), after.saturating_sub(empty)]);
    }
    let passing = time(|| SimulatedTime::advance(&mut application)).saturating_sub(empty);
    row("advance and sense", &[0, passing]);
    row("longest hold", &[0, instructions(LONGEST_HOLD.load(Ordering::Relaxed))]);
    row("octet, mean and worst", &[sum.checked_div(octets).unwrap_or(0), worst]);
    let (free, used) = board::free_stack();
    row("stack, free and used", &[free, used]);
    row("end", &[]);
}

struct SimulatedTime;

impl SimulatedTime {
    fn advance<B: Behaviour, S: Store>(application: &mut Application<'_, B, S>) {
        use profivac_devices::SimulatedDevice;
        application.device_mut().advance(0.01);
        application.device_mut().sense(0, 0.1);
    }
}

/// The instructions of an action.
#[inline(never)]
fn time(action: impl FnOnce()) -> u32 {
    let before = board::ticks();
    action();
    instructions(board::ticks().wrapping_sub(before))
}

/// Prints a row: the name, and numbers in hexadecimal digits.
fn row(name: &str, numbers: &[u32]) {
    board::print(name.as_bytes());
    board::print(b":");
    crate::diagnostics::numbers(numbers);
}
