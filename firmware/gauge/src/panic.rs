//! The handler of a panic, which the linker demands. The check of the firmware proves that no image contains a panic.

use core::panic::PanicInfo;

/// Restarts; a panic must not keep the bus.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    profivac_board::restart()
}
