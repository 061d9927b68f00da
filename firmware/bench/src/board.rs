//! The reference board, an Arm MPS2 with a Cortex-M4F: what the nodes need of it beyond memory.
//!
//! Text, the command line and the exit status go through semihosting, so a debugger or QEMU must be attached; on a
//! board alone the first call ends in a fault. All unsafe code of this crate is in this file.
#![allow(unsafe_code)]

use core::cell::Cell;
use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::{debug, hprintln, nr, syscall};

/// Reads the command line that the debugger passes on (semihosting `SYS_GET_CMDLINE`).
///
/// QEMU joins its `arg=` values with blanks, the first of them by convention the program's name. `None` when there is
/// no command line, when it does not fit into `buffer` with its closing zero, or when it is not UTF-8.
pub fn command_line(buffer: &mut [u8]) -> Option<&str> {
    // The host writes the length back, hence cells: the block changes behind a shared reference.
    let block = [Cell::new(buffer.as_mut_ptr().expose_provenance()), Cell::new(buffer.len())];
    // SAFETY: `block` is the pair (address, size) that this operation asks for. The host writes at most `size` bytes
    // to `address`, which is exclusively borrowed for the call and initialised before it, and the length to `block`.
    let status = unsafe { syscall(nr::GET_CMDLINE, &block) };
    if status != 0 {
        return None;
    }
    core::str::from_utf8(buffer.get(..block[1].get())?).ok()
}

/// The CMSDK timer 0 of the board: control register, and the value that counts down from the reload value.
const TIMER_CONTROL: *mut u32 = core::ptr::without_provenance_mut(0x4000_0000);
const TIMER_VALUE: *mut u32 = core::ptr::without_provenance_mut(0x4000_0004);
const TIMER_RELOAD: *mut u32 = core::ptr::without_provenance_mut(0x4000_0008);

/// Starts the timer that [`ticks`] reads. It ticks once a cycle of the system clock, 25 MHz.
pub fn start_timer() {
    // SAFETY: these are the registers of the board's timer 0, which nothing else uses; any value may be written.
    unsafe {
        TIMER_RELOAD.write_volatile(u32::MAX);
        TIMER_VALUE.write_volatile(u32::MAX);
        TIMER_CONTROL.write_volatile(1);
    }
}

/// Ticks since the timer was started; wraps.
pub fn ticks() -> u32 {
    // SAFETY: as above; reading has no effect.
    u32::MAX - unsafe { TIMER_VALUE.read_volatile() }
}

/// Ends the program, with exit status 0 or 1 where QEMU runs it.
pub fn exit(success: bool) -> ! {
    debug::exit(if success { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    // A debugger may let the processor go on.
    loop {
        cortex_m::asm::wfi();
    }
}

/// A panic is a failed run, never a hang: whoever waits for the exit status gets one.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    hprintln!("{}", info);
    exit(false)
}

/// The same for a fault, for example after the stack has overflowed.
// SAFETY: entered by hardware only; the handler touches nothing that the faulting code may hold half-changed, except
// the semihosting stream handle, which is one word.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    hprintln!("hard fault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr());
    exit(false)
}
