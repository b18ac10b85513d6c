//! Commands of one octet on the console of the emulator, for the check.
//!
//! | Octet | Effect |
//! |---|---|
//! | `s` | prints the free octets of RAM and the deepest stack |
//! | `c` | prints the counters of the bus |
//! | `o` | prints the number of operations of the flash, and of those while an answer waited or was being sent |
//! | `l` | prints the lights: bus, fault |
//! | `x`, `y` | sets the rate to 12 Mbit/s, which the port does not have, and back |
//! | `g` | after a power cut: begins to work |
//! | 128 + N | lets the power fail before the flash operation N from now |

use crate::counters;
use crate::gauge::set_rate;
use profivac_board as board;
use profivac_board::flash;
use profivac_dp::link::Baud;

/// After a power cut the gauge prints an empty line and stays silent until a `g` comes, so that it executes no request that a
/// master repeats.
pub fn wait_after_power_cut() {
    if !flash::power_has_failed() {
        return;
    }
    numbers(&[]);
    while board::console_octet() != Some(b'g') {
        board::discard();
    }
    board::discard();
}

/// Executes the commands that have arrived.
pub fn serve() {
    while let Some(octet) = board::console_octet() {
        match octet {
            b's' => {
                let (free, used) = board::free_stack();
                numbers(&[free, used]);
            }
            b'c' => {
                let counters = counters();
                numbers(&[counters.damaged, counters.lost, counters.late]);
            }
            b'l' => numbers(&board::lights().map(u32::from)),
            b'x' | b'y' => {
                set_rate(if octet == b'x' { Baud::B12000000 } else { Baud::B19200 }, board::ticks());
                numbers(&[]);
            }
            b'o' => numbers(&[flash::operations(), flash::disturbing()]),
            0x80.. => {
                flash::cut_power_after(u32::from(octet & 0x7F));
                numbers(&[]);
            }
            _ => {}
        }
    }
}

/// Prints the numbers in hexadecimal digits, and ends the line.
pub fn numbers(numbers: &[u32]) {
    for number in numbers {
        for shift in (0..u32::BITS).step_by(4).rev() {
            let digit = (number >> shift & 0xF) as u8;
            board::print(&[if digit < 10 {
                b'0'.wrapping_add(digit)
            } else {
                b'a'.wrapping_sub(10).wrapping_add(digit)
            }]);
        }
        board::print(b" ");
    }
    board::print(b"\n");
}
