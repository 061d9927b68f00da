//! What is left when the program fails: the output goes to zero, and the watchdog resets the part.
//!
//! During the reset the pin is an input: a resistor divider on the plant's side has to hold it half-way.

use crate::output;
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};

fn fail() -> ! {
    cortex_m::interrupt::disable();
    output::rest();
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    fail()
}

/// For example after the stack has overflowed.
// SAFETY: entered by hardware only; does not go back.
#[allow(unsafe_code)]
#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    fail()
}
