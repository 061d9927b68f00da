//! The main loop of a node on its board: bytes through interrupts and queues, the cycle timer, the watchdog.
//!
//! What the UART's registers are is told in `boards/`; what frames mean is the node's. If the program fails, it leaves the
//! plant with the safe input, as far as it can, and waits for the watchdog to reset the board.
#![allow(unsafe_code)]

use crate::board::{Board, Node, Notice, Usage};
use crate::{design::SAMPLE_TIME, hardware, log, memory};
use core::cell::RefCell;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::{NVIC, SYST, syst::SystClkSource};
use cortex_m_rt::{ExceptionFrame, exception};
use critical_section::Mutex;
use heapless::{Deque, Vec};
use slqg::wire::serial::{Unstuffer, stuff, stuffed_len};

/// Bytes that may wait on either side of the line: two of the longest frames.
const QUEUE: usize = 256;
/// Longest frame that is sent while something fails.
const LAST_WORDS: usize = 64;
/// Seconds without the main loop after which the watchdog bites.
const WATCHDOG_SECONDS: u32 = 1;

/// Cycles of the processor in a control cycle.
const PERIOD: u64 = (SAMPLE_TIME * hardware::CORE_HZ as f64) as u64;
/// The timer has 24 bits: how often it runs down in a control cycle, and from where.
const ROUNDS: u32 = (PERIOD >> 24) as u32 + 1;
const RELOAD: u32 = (PERIOD / ROUNDS as u64) as u32;

/// Bytes between the interrupts and the main loop.
struct Line {
    received: Deque<u8, QUEUE>,
    to_send: Deque<u8, QUEUE>,
    overruns: u32,
}

static LINE: Mutex<RefCell<Line>> =
    Mutex::new(RefCell::new(Line { received: Deque::new(), to_send: Deque::new(), overruns: 0 }));
/// The frame that leaves the plant safe when the program has failed.
static SAFE: Mutex<RefCell<Vec<u8, LAST_WORDS>>> = Mutex::new(RefCell::new(Vec::new()));
/// Times the timer has run down.
static ROUNDS_OVER: AtomicU32 = AtomicU32::new(0);

/// Runs a node, for ever. `IN` and `OUT` are the longest frames that it takes and sends, in bytes; `STUFFED` is
/// [`stuffed_len`] of `OUT`.
pub fn run<N: Node, const IN: usize, const STUFFED: usize>(mut node: N) -> ! {
    hardware::start();
    let mut board = Machine::<STUFFED> { timer: start_timer(), lost: 0 };
    let mut safe = [0; LAST_WORDS];
    critical_section::with(|cs| {
        let frame = node.safe_frame(&mut safe);
        *SAFE.borrow_ref_mut(cs) = Vec::from_slice(frame).unwrap_or_default();
    });
    for number in hardware::INTERRUPTS {
        // SAFETY: the queues are set up; their handler shares them with this loop through a mutex only.
        unsafe { NVIC::unmask(Interrupt(*number)) };
    }
    hardware::WATCHDOG.start(hardware::CORE_HZ * WATCHDOG_SECONDS);
    defmt::info!("started");
    let mut unstuffer = Unstuffer::<IN>::default();
    node.start(&mut board);
    let mut rounds = ROUNDS_OVER.load(Ordering::Relaxed);
    loop {
        hardware::WATCHDOG.feed();
        while let Some(byte) = critical_section::with(|cs| LINE.borrow_ref_mut(cs).received.pop_front()) {
            if let Some(frame) = unstuffer.take(byte) {
                node.take(frame, &mut board);
            }
        }
        board.lost = unstuffer.lost();
        if ROUNDS_OVER.load(Ordering::Relaxed).wrapping_sub(rounds) >= ROUNDS {
            rounds = rounds.wrapping_add(ROUNDS);
            node.period_over(&mut board);
        }
        // With interrupts masked nothing comes between the look and the sleep; a pending one wakes even so.
        cortex_m::interrupt::free(|_| {
            let idle = critical_section::with(|cs| LINE.borrow_ref_mut(cs).received.is_empty());
            if idle && ROUNDS_OVER.load(Ordering::Relaxed).wrapping_sub(rounds) < ROUNDS {
                cortex_m::asm::wfi();
            }
        });
    }
}

/// The board as the node sees it. `STUFFED`: bytes that its longest frame takes on the line.
struct Machine<const STUFFED: usize> {
    timer: SYST,
    lost: u32,
}

impl<const STUFFED: usize> Board for Machine<STUFFED> {
    fn send(&mut self, frame: &[u8]) {
        let mut buffer = [0; STUFFED];
        let Ok(bytes) = stuff(frame, &mut buffer) else { return };
        critical_section::with(|cs| {
            let line = &mut *LINE.borrow_ref_mut(cs);
            if line.to_send.capacity() - line.to_send.len() < bytes.len() {
                line.overruns = line.overruns.saturating_add(1);
                return;
            }
            for byte in bytes {
                // There is room, as has just been seen.
                let _ = line.to_send.push_back(*byte);
            }
            transmit(line);
        });
    }

    fn restart_period(&mut self) {
        self.timer.clear_current();
    }

    fn ticks(&self) -> u32 {
        ROUNDS_OVER.load(Ordering::Relaxed).wrapping_mul(RELOAD).wrapping_sub(SYST::get_current())
    }

    fn elapsed(&self, begin: u32) -> u32 {
        self.ticks().wrapping_sub(begin)
    }

    fn usage(&self) -> Usage {
        let queues = critical_section::with(|cs| LINE.borrow_ref(cs).overruns);
        Usage { overruns: queues.saturating_add(self.lost), ..memory::usage() }
    }

    fn note(&mut self, notice: Notice) {
        log::note(notice);
    }
}

fn start_timer() -> SYST {
    // SAFETY: called once, before anything else could use the timer.
    let mut timer = unsafe { cortex_m::Peripherals::steal() }.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(RELOAD - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
    timer
}

/// Puts on the line what it has room for.
fn transmit(line: &mut Line) {
    while let Some(byte) = line.to_send.front() {
        if !hardware::LINE.transmit(*byte) {
            return;
        }
        line.to_send.pop_front();
    }
}

/// An interrupt by its number.
#[derive(Clone, Copy)]
struct Interrupt(u16);

// SAFETY: the numbers come from the board's file, and do not change.
unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self.0
    }
}

unsafe extern "C" {
    /// The function below, as the processor calls it.
    #[link_name = "DefaultHandler"]
    fn default_handler();
}

/// Interrupts that a board may have: the nodes use the first few, and a full table would be a kilobyte of flash.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 16] = [default_handler; 16];

#[exception]
fn SysTick() {
    ROUNDS_OVER.store(ROUNDS_OVER.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

/// The line's interrupts; any other exception is a failure.
// SAFETY: entered by hardware only; shares the queues through a mutex.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    if !u16::try_from(number).is_ok_and(|number| hardware::INTERRUPTS.contains(&number)) {
        defmt::error!("exception {=i16}", number);
        fail();
    }
    hardware::clear_interrupts();
    critical_section::with(|cs| {
        let line = &mut *LINE.borrow_ref_mut(cs);
        while let Some(byte) = hardware::LINE.receive() {
            if line.received.push_back(byte).is_err() {
                line.overruns = line.overruns.saturating_add(1);
            }
        }
        transmit(line);
    });
}

/// Leaves the plant safe, and waits for the watchdog.
fn fail() -> ! {
    cortex_m::interrupt::disable();
    critical_section::with(|cs| {
        // Whoever held it has failed, and will not go on.
        let Ok(frame) = SAFE.borrow(cs).try_borrow() else { return };
        let mut buffer = [0; stuffed_len(LAST_WORDS)];
        let Ok(bytes) = stuff(&frame, &mut buffer) else { return };
        // A zero first: it ends the frame that was under way.
        for byte in core::iter::once(&0).chain(bytes) {
            while !hardware::LINE.transmit(*byte) {}
        }
    });
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    // Without the message: formatting it would be half of the image.
    defmt::error!("panic");
    fail()
}

/// For example after the stack has overflowed.
// SAFETY: entered by hardware only; does not go back.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    fail()
}
