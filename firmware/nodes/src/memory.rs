//! How much memory the program has used: variables, and the stack by the paint it has scrubbed off.
#![allow(unsafe_code)]

use crate::board::Usage;
use core::ptr::addr_of;

/// What the stack is painted with before the program runs.
const PAINT: u32 = cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static __sdata: u32;
    static __sheap: u32;
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Stack and variables, in bytes; overruns are not known here.
pub(crate) fn usage() -> Usage {
    // Only addresses are taken: the linker script places the symbols, and they hold nothing.
    let (end, start) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let words = (start.addr() - end.addr()) / size_of::<u32>();
    // SAFETY: the words between end and start of the stack are memory; that they are read while others are written to by
    // interrupts at most makes the answer older.
    let untouched = (0..words).take_while(|&word| unsafe { end.add(word).read_volatile() } == PAINT).count();
    let variables = addr_of!(__sheap).addr() - addr_of!(__sdata).addr();
    Usage { stack: ((words - untouched) * size_of::<u32>()) as u32, variables: variables as u32, overruns: 0 }
}
