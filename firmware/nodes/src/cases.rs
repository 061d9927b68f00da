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

use crate::closed_loop::{Loop, Outcome};

/// A loop to run: its name and its run.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// As in the table above.
    pub name: &'static str,
    /// Runs it from its fixed start to its fixed end.
    pub run: fn() -> Outcome,
}

/// Every case, in the order in which they are run.
pub const CASES: [Case; 5] = [
    Case { name: "pendulum", run: pendulum::run },
    Case { name: "pendulum_hold", run: pendulum_hold::run },
    Case { name: "pendulum_event", run: pendulum_event::run },
    Case { name: "drive_tracking", run: drive_tracking::run },
    Case { name: "drive_event", run: drive_event::run },
];

/// What the generator makes of a design, and its loop.
macro_rules! case {
    ($name:ident, $tracked:expr, $plateau:expr) => {
        #[allow(dead_code, unreachable_pub)]
        mod $name {
            include!(concat!(env!("OUT_DIR"), "/", stringify!($name), ".rs"));

            pub(super) fn run() -> super::Outcome {
                let closed_loop =
                    super::Loop { design: &DESIGN, actuator: ACTUATOR, tracked: $tracked, plateau: $plateau };
                closed_loop.run::<SEQUENCE_LENGTH, HISTORY>()
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
// A move of 5 mm: the position is tracked.
case!(drive_tracking, [[1.0, 0.0, 0.0]], [5.0]);
case!(drive_event, [[1.0, 0.0, 0.0]], [5.0]);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CYCLES;

    fn outcome(name: &str) -> Outcome {
        let case = CASES.iter().find(|case| case.name == name).expect("a case of that name");
        (case.run)()
    }

    #[test]
    fn the_rod_stays_upright_through_the_scripted_losses() {
        for name in ["pendulum", "pendulum_hold"] {
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
            assert_eq!((case.run)(), (case.run)(), "{}", case.name);
        }
    }
}
