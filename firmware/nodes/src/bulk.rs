//! A node whose line is a pair of files on the host of a debugger (semihosting): for long runs in an emulator.
//!
//! Neither interrupts nor a timer: the node does what its host sends, and the host waits for it. A call to the host costs one
//! trap instead of one interrupt a byte.
#![allow(unsafe_code)]

use crate::board::{Board, Node, Notice, Usage};
use crate::{hardware, log, memory};
use core::cell::Cell;
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_semihosting::{debug, nr, syscall};
use slqg::wire::serial::{Unstuffer, stuff};

/// Bytes read at once. They lie on the stack all the time.
const CHUNK: usize = 32;
/// Longest name of a file.
const PATH: usize = 128;
/// Modes of the host's `fopen`: `rb`, `wb`.
const READ: usize = 1;
const WRITE: usize = 5;
/// The timer's largest value: it counts a cycle's instructions, and no cycle takes as many.
const RELOAD: u32 = 0x00ff_ffff;

/// Runs a node over the files `BASE.in` and `BASE.out`, `BASE` being the last word of the command line. Ends when there is
/// nothing more to read. Constants as those of [`crate::program::run`].
pub fn run<N: Node, const IN: usize, const STUFFED: usize>(mut node: N) -> ! {
    // For the log; the line's interrupts stay masked.
    hardware::start();
    let mut timer = unsafe { cortex_m::Peripherals::steal() }.SYST; // SAFETY: called once, nobody else uses the timer.
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(RELOAD);
    timer.clear_current();
    timer.enable_counter();
    let Some((input, output)) = open_both() else {
        debug::exit(debug::EXIT_FAILURE);
        loop {}
    };
    let mut board = Files::<STUFFED> { output, lost: 0 };
    let mut unstuffer = Unstuffer::<IN>::default();
    let mut chunk = [0; CHUNK];
    node.start(&mut board);
    while let Some(bytes) = read(input, &mut chunk) {
        for byte in bytes {
            if let Some(frame) = unstuffer.take(*byte) {
                node.take(frame, &mut board);
            }
        }
        board.lost = unstuffer.lost();
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

/// The board as the node sees it.
struct Files<const STUFFED: usize> {
    output: usize,
    lost: u32,
}

impl<const STUFFED: usize> Board for Files<STUFFED> {
    fn send(&mut self, frame: &[u8]) {
        let mut buffer = [0; STUFFED];
        if let Ok(bytes) = stuff(frame, &mut buffer) {
            // SAFETY: the block is handle, address and length of bytes that are there for the call.
            unsafe { syscall(nr::WRITE, &[self.output, bytes.as_ptr().expose_provenance(), bytes.len()]) };
        }
    }

    fn restart_period(&mut self) {}

    fn ticks(&self) -> u32 {
        // It counts down.
        RELOAD - SYST::get_current()
    }

    fn elapsed(&self, begin: u32) -> u32 {
        self.ticks().wrapping_sub(begin) & RELOAD
    }

    fn usage(&self) -> Usage {
        Usage { overruns: self.lost, ..memory::usage() }
    }

    fn note(&mut self, notice: Notice) {
        log::note(notice);
    }
}

/// The line: both of its files. What their names take of the stack is given back.
#[inline(never)]
fn open_both() -> Option<(usize, usize)> {
    let mut path = [0; PATH];
    Some((open(&mut path, b".in\0", READ)?, open(&mut path, b".out\0", WRITE)?))
}

/// Opens the file whose name is the last word of the command line and `extension`, a zero at its end.
fn open(path: &mut [u8; PATH], extension: &[u8], mode: usize) -> Option<usize> {
    let block = [Cell::new(path.as_mut_ptr().expose_provenance()), Cell::new(path.len())];
    // SAFETY: address and length of bytes that are there for the call; the host writes no more than that, and the length
    // to the cell.
    if unsafe { syscall(nr::GET_CMDLINE, &block) } != 0 {
        return None;
    }
    let len = block[1].get();
    let begin = path.get(..len)?.iter().rposition(|byte| *byte == b' ').map_or(0, |blank| blank + 1);
    path.get_mut(len..len + extension.len())?.copy_from_slice(extension);
    let name = path.get(begin..len + extension.len() - 1)?;
    // SAFETY: address of a name with a zero after it, mode, length of the name.
    let handle = unsafe { syscall(nr::OPEN, &[name.as_ptr().expose_provenance(), mode, name.len()]) };
    (handle != usize::MAX).then_some(handle)
}

/// Reads what is there, at least a byte; `None` at the end.
fn read(input: usize, chunk: &mut [u8; CHUNK]) -> Option<&[u8]> {
    // SAFETY: handle, address and length of bytes that are there for the call; the host writes no more than that.
    let left = unsafe { syscall(nr::READ, &[input, chunk.as_mut_ptr().expose_provenance(), chunk.len()]) };
    chunk.get(..chunk.len().checked_sub(left)?).filter(|bytes| !bytes.is_empty())
}
