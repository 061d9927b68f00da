//! The designs whose loops are run on the board, and their names.
//!
//! Each shows something that the device does: see the table. What a loop is, is said in [`crate::closed_loop`].
//!
//! | case | what it shows |
//! |---|---|
//! | `pendulum` | the plain law, default input zero |
//! | `pendulum_hold` | an actuator that holds the input applied last |
//! | `pendulum_event` | packets sent only if they are worth it |
//! | `drive_tracking` | a reference that is followed with preview |
//! | `drive_event` | all at once: hold, reference, packets that must be worth it |
//! | `pendulum_late` | acknowledgements late and lost, later ones make good for them |
//! | `integrator` | the double integrator, every age acknowledged at once |
//! | `integrator_single` | no acknowledgement at all, all ages in one estimate |
//! | `integrator_imm` | the same, the age in the last cycle kept apart |
//! | `integrator_gpb2` | the same, the ages in the last two cycles kept apart |

use crate::closed_loop::{Feedback, Loop, Outcome};
use slqg::{controller::Design, estimator::Merging};

/// A loop to run: its name and its run.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// As in the table above.
    pub name: &'static str,
    /// Runs it from its fixed start to its fixed end; takes a clock, which counts upwards and may wrap.
    pub run: fn(fn() -> u32) -> Outcome,
}

/// Every case, in the order in which they are run.
pub const CASES: [Case; 11] = [
    Case { name: "pendulum", run: |clock| pendulum::run(clock, Merging::Single, Feedback::Instant) },
    Case {
        name: "pendulum_hold",
        run: |clock| pendulum_hold::run(clock, Merging::Single, Feedback::Instant),
    },
    Case {
        name: "pendulum_event",
        run: |clock| pendulum_event::run(clock, Merging::Single, Feedback::Instant),
    },
    Case {
        name: "drive_tracking",
        run: |clock| drive_tracking::run(clock, Merging::Single, Feedback::Instant),
    },
    Case { name: "drive_event", run: |clock| drive_event::run(clock, Merging::Single, Feedback::Instant) },
    Case {
        name: "pendulum_late",
        run: |clock| pendulum::run(clock, Merging::Imm, Feedback::Scripted(&LATE)),
    },
    Case { name: "integrator", run: |clock| integrator::run(clock, Merging::Single, Feedback::Instant) },
    Case { name: "integrator_single", run: |clock| integrator::run(clock, Merging::Single, Feedback::None) },
    Case { name: "integrator_linear", run: |clock| integrator::run(clock, Merging::Linear, Feedback::None) },
    Case { name: "integrator_imm", run: |clock| integrator::run(clock, Merging::Imm, Feedback::None) },
    Case { name: "integrator_gpb2", run: |clock| integrator::run(clock, Merging::Gpb2, Feedback::None) },
];

/// Delays of acknowledgements: a third of them lost, four in a row once in a while.
const LATE: [Option<u8>; 13] = [
    Some(0),
    None,
    Some(1),
    Some(0),
    Some(2),
    None,
    Some(0),
    None,
    None,
    None,
    None,
    Some(0),
    Some(3), //
];

/// What the generator makes of a design, and its loop.
macro_rules! case {
    ($name:ident, $tracked:expr, $plateau:expr) => {
        #[allow(dead_code, unreachable_pub)]
        mod $name {
            include!(concat!(env!("OUT_DIR"), "/", stringify!($name), ".rs"));

            slqg::controller_memory! {
                /// Memory for any way of merging.
                struct Wide: Scalar, STATES, INPUTS, OUTPUTS;
                slqg::controller::Sizes::of(SEQUENCE_LENGTH, HISTORY, SEQUENCE_LENGTH + 1)
            }

            pub(super) fn run(
                clock: fn() -> u32,
                merging: super::Merging,
                feedback: super::Feedback,
            ) -> super::Outcome {
                let design = super::Design { merging, ..DESIGN };
                let (tracked, plateau) = ($tracked, $plateau);
                let looped = super::Loop { design, actuator: ACTUATOR, tracked, plateau, feedback };
                let mut of_actuator = ACTUATOR_MEMORY;
                match merging {
                    super::Merging::Single | super::Merging::Linear => {
                        looped.run(Memory::new().lend(), &mut of_actuator, clock)
                    }
                    _ => looped.run(Wide::new().lend(), &mut of_actuator, clock),
                }
            }
        }
    };
    ($name:ident) => {
        case!($name, [[0.0; STATES]; 0], []);
    };
}
case!(pendulum);
case!(pendulum_hold);
case!(pendulum_event);
case!(integrator);
// A move of 5 mm: the position is tracked.
case!(drive_tracking, [[1.0, 0.0, 0.0]], [5.0]);
case!(drive_event, [[1.0, 0.0, 0.0]], [5.0]);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CYCLES;

    fn outcome(name: &str) -> Outcome {
        let case = CASES.iter().find(|case| case.name == name).expect("a case of that name");
        (case.run)(|| 0)
    }

    #[test]
    fn the_rod_stays_upright_through_the_scripted_losses() {
        for name in ["pendulum", "pendulum_hold", "pendulum_late"] {
            let outcome = outcome(name);
            assert!(outcome.largest[2] < 0.5, "{name}: {outcome:?}");
            assert!(outcome.state.iter().all(|value| value.abs() < 2.0), "{name}: {outcome:?}");
            assert_eq!(outcome.sent, CYCLES);
        }
    }

    #[test]
    fn dear_packets_keep_the_rod_off_the_ground_with_few_of_them() {
        let outcome = outcome("pendulum_event");
        assert!(outcome.largest[2] < 1.5, "{outcome:?}");
        assert!((1..CYCLES / 4).contains(&outcome.sent), "{outcome:?}");
    }

    #[test]
    fn the_drive_follows_its_reference_with_and_without_an_event_trigger() {
        for name in ["drive_tracking", "drive_event"] {
            let outcome = outcome(name);
            assert!(outcome.largest[0] > 4.0, "it moved, {name}: {outcome:?}");
            assert!(outcome.largest_error < 0.5, "and came back, {name}: {outcome:?}");
        }
        assert_eq!(outcome("drive_tracking").sent, CYCLES);
        assert!(outcome("drive_event").sent < CYCLES / 2);
    }

    #[test]
    fn a_run_is_the_same_every_time() {
        for case in CASES {
            assert_eq!((case.run)(|| 0), (case.run)(|| 0), "{}", case.name);
        }
    }

    #[test]
    fn the_integrator_is_held_without_acknowledgements_by_every_estimator() {
        for name in ["integrator", "integrator_single", "integrator_imm", "integrator_gpb2"] {
            let outcome = outcome(name);
            assert!(outcome.state.iter().all(|value| value.abs() < 20.0), "{name}: {outcome:?}");
        }
    }
}
