//! The log: messages in defmt's format, over the board's second UART. `defmt-print -e IMAGE` reads them on the host.
#![allow(unsafe_code)]

use crate::board::Notice;
use crate::hardware;
use core::cell::UnsafeCell;
use critical_section::RestoreState;
use slqg::health::{Cause, Health};
use slqg::wire::TuningStep;

/// One message at a time, interrupts masked.
struct State {
    encoder: UnsafeCell<(defmt::Encoder, RestoreState)>,
}

// SAFETY: used only between acquire and release, within a critical section.
unsafe impl Sync for State {}

static STATE: State = State { encoder: UnsafeCell::new((defmt::Encoder::new(), RestoreState::invalid())) };

#[defmt::global_logger]
struct Log;

// SAFETY: a critical section lasts from acquire to release, so that messages do not mix. A message within a message can
// come from a panic while one is written: the frame that was under way is then damaged, which the reader sees.
unsafe impl defmt::Logger for Log {
    fn acquire() {
        // SAFETY: released in `release`; the section makes the access to the state the only one.
        unsafe {
            let token = critical_section::acquire();
            let (encoder, restore) = &mut *STATE.encoder.get();
            *restore = token;
            encoder.start_frame(write);
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: called after acquire, within its section, which ends here.
        unsafe {
            let (encoder, restore) = &mut *STATE.encoder.get();
            encoder.end_frame(write);
            critical_section::release(*restore);
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: called between acquire and release.
        unsafe { (*STATE.encoder.get()).0.write(bytes, write) }
    }
}

fn write(bytes: &[u8]) {
    for byte in bytes {
        // Until there is room.
        while !hardware::LOG.transmit(*byte) {}
    }
}

/// Puts a notice into the log.
pub(crate) fn note(notice: Notice) {
    match notice {
        Notice::Aligned(tick) => defmt::info!("first cycle {=u32}", tick.0),
        Notice::Realigned(tick) => defmt::warn!("begins anew with cycle {=u32}", tick.0),
        Notice::ClockRefused(tick) => defmt::warn!("the clock jumps to cycle {=u32}: not taken", tick.0),
        Notice::Health(Health::Nominal) => defmt::info!("nominal"),
        Notice::Health(Health::Degraded(cause)) => defmt::warn!("degraded: {=istr}", told(cause)),
        Notice::Health(Health::Lost(cause)) => defmt::warn!("lost: {=istr}", told(cause)),
        Notice::Safe => defmt::warn!("no cycle for too long: safe input"),
        Notice::Gains(verdict) => defmt::info!("gains: verdict {=u8}", verdict as u8),
        Notice::Tuned(TuningStep::Started) => defmt::info!("the link has changed: solving"),
        Notice::Tuned(TuningStep::Switched) => defmt::info!("new gains in force"),
        Notice::Tuned(TuningStep::Kept) => defmt::warn!("no gains found: those in force stay"),
        #[cfg(feature = "authentication")]
        Notice::Alarm(alarm) => defmt::warn!("too many frames refused: {=u8}", alarm as u8),
        Notice::Rejected(kind) => defmt::debug!("frame of kind {=u8} changed nothing", kind),
    }
}

/// As text of this crate: with formats of the core's own, programs of other boards would need defmt's linker script. The host has
/// it, not the board's flash.
fn told(cause: Cause) -> defmt::Str {
    match cause {
        Cause::NotMeasured => defmt::intern!("no measurement that could be believed for too long"),
        Cause::Implausible(_) => defmt::intern!("an output does not fit the estimate"),
        Cause::Stuck(_) => defmt::intern!("an output reads the same for too long"),
        Cause::BegunAnew => defmt::intern!("the estimate began anew"),
        Cause::NotFinite => defmt::intern!("no finite sequence could be computed"),
        Cause::RunOut => defmt::intern!("the buffer has run out"),
        Cause::Memory => defmt::intern!("memory has changed by itself"),
    }
}
