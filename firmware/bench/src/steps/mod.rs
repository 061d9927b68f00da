//! Instructions of every step of a cycle, by design and sequence length.
//!
//! Where the whole loop of [`crate::CASES`] loses and delays frames as a link does, here every measurement is fresh and every
//! acknowledgement there in time, so that a step does the same work in every cycle; only control frames are lost, so that the
//! ages differ.
//!
//! | file | what lives there |
//! |---|---|
//! | `run` | a loop that does each cycle twice: as a whole, and step by step |
//! | `apart` | the controller's and the actuator's cycle in pieces |
//! | `stopwatch` | the steps, and their time |
//! | `bounds` | the multiply-adds they cannot do without |

mod apart;
mod bounds;
mod run;
mod stopwatch;

use crate::Time;
use run::Loop;
use slqg::{controller::Design, estimator::Merging};

/// What a step has taken.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// The design that the loop was made of.
    pub design: &'static str,
    /// Inputs of a sequence, `N`.
    pub length: usize,
    /// The step's name.
    pub step: &'static str,
    /// Over all cycles in which it was done.
    pub time: Time,
    /// Multiply-adds it cannot do without in the longest case; `None` where there is no arithmetic.
    pub multiply_adds: Option<usize>,
}

/// Runs a loop of every design, and tells what each step took by `clock`, which counts upwards and may wrap.
///
/// # Panics
/// If the steps one by one do not come to the frames of the cycle as a whole.
pub fn each_step_cost(clock: fn() -> u32, each: &mut dyn FnMut(Cost)) {
    double_integrator_4::run(clock, each);
    double_integrator_8::run(clock, each);
    critical_4::run(clock, each);
    critical_8::run(clock, each);
    pendulum_4::run(clock, each);
    pendulum_8::run(clock, each);
    drive_tracking_4::run(clock, each);
    drive_tracking_8::run(clock, each);
    pendulum_event_4::run(clock, each);
    pendulum_event_8::run(clock, each);
    pendulum_schedule_4::run(clock, each);
    pendulum_schedule_8::run(clock, each);
    unacknowledged_4::run(clock, each);
    unacknowledged_8::run(clock, each);
    unacknowledged_imm_4::run(clock, each);
    unacknowledged_imm_8::run(clock, each);
}

/// What the generator makes of a design for sequences of one length, and its loop.
macro_rules! design {
    ($module:ident, $source:ident, $name:literal, $reference:expr, $merging:ident, $estimates:expr, $acknowledged:expr) => {
        #[allow(dead_code, unreachable_pub)]
        mod $module {
            include!(concat!(env!("OUT_DIR"), "/", stringify!($source), ".rs"));

            pub(super) fn run(clock: fn() -> u32, each: &mut dyn FnMut(super::Cost)) {
                let design = super::Design { merging: super::Merging::$merging, ..DESIGN };
                let (reference, acknowledged) = ($reference, $acknowledged);
                slqg::controller_memory! {
                    struct Room: Scalar, STATES, INPUTS, OUTPUTS;
                    slqg::controller::Sizes::of(SEQUENCE_LENGTH, HISTORY, $estimates).with_numbers(match &DESIGN.trigger {
                        Some(trigger) => trigger.numbers_len(),
                        None => 0,
                    })
                }
                let (mut whole, mut apart) = (Room::new(), Room::new());
                let (mut of_whole, mut of_apart) = (ACTUATOR_MEMORY, ACTUATOR_MEMORY);
                super::Loop { name: $name, design, actuator: ACTUATOR, reference, acknowledged }.count(
                    (whole.lend(), &mut of_whole),
                    (apart.lend(), &mut of_apart),
                    clock,
                    each,
                );
            }
        }
    };
    ($module:ident, $name:literal) => {
        design!($module, $module, $name, [], Single, 1, true);
    };
}
design!(double_integrator_4, "double_integrator");
design!(double_integrator_8, "double_integrator");
design!(critical_4, "critical");
design!(critical_8, "critical");
design!(pendulum_4, "pendulum");
design!(pendulum_8, "pendulum");
// A set point of 5 mm, handed over in every cycle as a reference that moves.
design!(drive_tracking_4, drive_tracking_4, "drive_tracking", [5.0], Single, 1, true);
design!(drive_tracking_8, drive_tracking_8, "drive_tracking", [5.0], Single, 1, true);
design!(pendulum_event_4, "pendulum_event");
design!(pendulum_event_8, "pendulum_event");
// The same with a trigger that takes later packets to follow a schedule.
design!(pendulum_schedule_4, "pendulum_schedule");
design!(pendulum_schedule_8, "pendulum_schedule");
design!(unacknowledged_4, double_integrator_4, "unacknowledged", [], Single, 1, false);
design!(unacknowledged_8, double_integrator_8, "unacknowledged", [], Single, 1, false);
design!(unacknowledged_imm_4, double_integrator_4, "unacknowledged_imm", [], Imm, SEQUENCE_LENGTH + 1, false);
design!(unacknowledged_imm_8, double_integrator_8, "unacknowledged_imm", [], Imm, SEQUENCE_LENGTH + 1, false);

#[cfg(test)]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn steps_one_by_one_come_to_the_frames_of_the_whole_cycle_in_every_design() {
        let mut designs = 0;
        each_step_cost(|| 0, &mut |cost| designs += usize::from(cost.step == "controller-cycle"));
        assert_eq!(designs, 16);
    }

    #[test]
    fn reading_the_clock_is_not_counted() {
        static NOW: AtomicU32 = AtomicU32::new(u32::MAX - 50);
        pendulum_4::run(|| NOW.fetch_add(7, Ordering::Relaxed), &mut |cost| {
            assert_eq!((cost.time.total, cost.time.longest), (0, 0), "{}", cost.step);
        });
    }

    #[test]
    fn the_pendulums_law_multiplies_every_gain_once() {
        let mut found = None;
        pendulum_8::run(|| 0, &mut |cost| {
            if cost.step == "law" {
                found = cost.multiply_adds;
            }
        });
        assert_eq!(found, Some(8 * (4 + 7)));
    }
}
