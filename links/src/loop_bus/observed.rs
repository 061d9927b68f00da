//! The delays that a loop's frames meet on a bus, found by running it: what gains are designed with.

use super::{LoopBus, LoopPlan, Role};
use crate::{can::SettingsError, recording::Recording};
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Times that the loop is started anew, in another phase of the other traffic.
const STARTS: u64 = 64;
/// Cycles that each start is observed for.
const CYCLES: usize = 256;
/// Cycles after that, in which late frames may still arrive.
const REST: usize = 64;

/// What becomes of the frames of each role on the bus; `None` for a role that goes elsewhere. Frames carry random bytes.
/// A frame that is still under way when the observation is over counts as lost.
///
/// # Errors
/// Settings with which no bus can run.
pub fn observe(plan: &LoopPlan) -> Result<[Option<Recording>; Role::COUNT], SettingsError> {
    let mut fates: [Vec<Option<usize>>; Role::COUNT] = Default::default();
    for start in 0..STARTS {
        let mut random = ChaCha8Rng::seed_from_u64(start);
        let mut bus = LoopBus::new(plan, ChaCha8Rng::from_rng(&mut random))?;
        let mut bytes = [0; crate::can::LARGEST_PAYLOAD];
        for _ in 0..CYCLES + REST {
            for role in [Role::Measurement, Role::Control, Role::Acknowledgement] {
                if role == Role::Control {
                    bus.take(Role::Measurement);
                }
                if role == Role::Acknowledgement {
                    bus.take(Role::Control);
                }
                if let Some(message) = plan.message(role) {
                    random.fill_bytes(&mut bytes[..message.bytes]);
                    bus.send(role, &bytes[..message.bytes], &[]);
                }
            }
            bus.next_cycle();
        }
        for role in Role::ALL {
            let decided = bus.fates(role);
            let of_cycle = |cycle| decided.get(cycle).copied().flatten().flatten();
            fates[role as usize].extend((0..CYCLES).map(of_cycle));
        }
    }
    let recorded = |role: Role| plan.message(role).map(|_| Recording::new(fates[role as usize].clone()));
    Ok(Role::ALL.map(recorded))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        can::{Attempts, Background, Errors, Format, Id, Settings},
        loop_bus::Message,
    };

    fn plan(load: f64) -> LoopPlan {
        let ids = [0x7f0, 0x7f1, 0x7f2].map(|value| Id::base(value).expect("an identifier"));
        let mut settings = Settings::new(500_000, 6);
        settings.sources = Background::load(load, 500_000, &ids, 3..6).expect("other traffic").sources;
        LoopPlan {
            settings,
            sample_time: 10_000_000,
            controller_at: 1_000_000,
            actuator_at: 2_000_000,
            messages: ids.map(|id| Some(Message { id, bytes: 8 })),
            format: Format::Classic,
            attempts: Attempts::Unlimited,
            replaces: false,
        }
    }

    #[test]
    fn without_other_traffic_and_errors_nothing_is_ever_late() {
        for recording in observe(&plan(0.0)).expect("a bus").into_iter().flatten() {
            assert_eq!(recording.shares().expect("arrivals").probabilities(), [1.0]);
            assert_eq!(recording.cycles() as u64, STARTS * CYCLES as u64);
        }
    }

    #[test]
    fn other_traffic_makes_frames_late_and_more_of_it_later() {
        let punctual = |load: f64| {
            observe(&plan(load))
                .expect("a bus")
                .map(|recording| recording.expect("on the bus").shares().expect("arrivals").probability(0))
        };
        let (some, much) = (punctual(0.6), punctual(0.9));
        for role in 0..Role::COUNT {
            assert!(much[role] <= some[role], "{some:?} {much:?}");
        }
        assert!(much[1] < 0.8, "{much:?}");
    }

    #[test]
    fn a_frame_that_is_tried_once_is_lost_with_its_first_error() {
        let mut plan = plan(0.0);
        // A frame of 8 bytes has about 115 bits: one in ten meets an error.
        plan.settings.errors = Errors::Independent { probability: 0.001 };
        plan.attempts = Attempts::Once;
        for recording in observe(&plan).expect("a bus").into_iter().flatten() {
            let loss = recording.shares().expect("arrivals").loss();
            assert!((0.08..0.14).contains(&loss), "{loss}");
        }
    }
}
