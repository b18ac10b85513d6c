//! A program without std, without alloc, with every inner crate in it. See `xtask/src/purity.rs`.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

// Naming a crate makes it part of the library.
use profivac_devices as _;
use profivac_dp as _;
use profivac_wire as _;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
