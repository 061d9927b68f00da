//! Whether what a controller was told, and what it made of that at its start, is still as it was.

use super::{Controller, Design};
use crate::{
    Scalar,
    estimator::{Merging, Model, Plausibility},
    integrity::{Part, Round, checksum_of, place_of},
    played::DefaultInput,
};

/// Checksums of a design, CRC-32/ISCSI, [`Design::checksums`]: of gains, arrival probabilities and trigger; and of all the rest,
/// which is preview gains, plant, noises, initial state, the actuator's settings, and what is believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Checksums([u32; 2]);

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Design<'_, T, NX, NU, NY> {
    /// What the checksum of the law is taken of.
    const fn law_part(&self, place: usize) -> Part<'_, T> {
        let Self { gains, trigger, arrives_at_once, .. } = self;
        let tables = gains.tables();
        match (place, trigger) {
            (0, _) => {
                let hold = matches!(gains.default_input(), DefaultInput::Hold) as u32;
                let of_trigger = match trigger {
                    Some(trigger) => trigger.period() as u32 + trigger.length() as u32,
                    None => 0,
                };
                let numbers = (tables.lx.len() ^ tables.m.len() ^ tables.arrival.len()) as u32;
                Part::Word(gains.length() as u32 ^ hold << 8 ^ of_trigger << 16 ^ numbers.rotate_left(9))
            }
            (1, _) => Part::Numbers(tables.lx.numbers()),
            (2, _) => Part::Numbers(tables.m.numbers()),
            (3, _) => Part::Numbers(tables.arrival.numbers()),
            (4, _) => Part::Numbers(core::slice::from_ref(arrives_at_once)),
            (5, Some(trigger)) => Part::Numbers(trigger.tables()[0]),
            (6, Some(trigger)) => Part::Numbers(trigger.tables()[1]),
            (7, Some(trigger)) => Part::Numbers(trigger.tables()[2]),
            (8, Some(trigger)) => Part::Numbers(core::slice::from_ref(trigger.send_cost())),
            _ => Part::End,
        }
    }

    /// What the checksum of the rest is taken of.
    const fn plant_part(&self, place: usize) -> Part<'_, T> {
        let Self { preview, model, plausibility, grid, .. } = self;
        let Model { a, b, c, process_noise, measurement_noise, initial_mean, initial_covariance } = model;
        match place {
            0 => Part::Numbers(a.data.0.as_flattened()),
            1 => Part::Numbers(b.data.0.as_flattened()),
            2 => Part::Numbers(c.data.0.as_flattened()),
            3 => Part::Numbers(process_noise.data.0.as_flattened()),
            4 => Part::Numbers(measurement_noise.data.0.as_flattened()),
            5 => Part::Numbers(initial_mean.data.0.as_flattened()),
            6 => Part::Numbers(initial_covariance.data.0.as_flattened()),
            7 => Part::Numbers(match preview {
                Some(preview) => preview.tables().sequence.numbers(),
                None => &[],
            }),
            8 => Part::Numbers(match preview {
                Some(preview) => preview.tables().displaced.numbers(),
                None => &[],
            }),
            9 => Part::Numbers(plausibility.gate.as_slice()),
            10 => Part::Numbers(match &plausibility.range {
                Some(range) => range.as_flattened(),
                None => &[],
            }),
            11 => Part::Word(word_of(plausibility)),
            12 => Part::Numbers(match grid {
                Some(grid) => grid.step.data.0.as_flattened(),
                None => &[],
            }),
            13 => {
                let merging = match self.merging {
                    Merging::Single => 0,
                    Merging::Imm => 1,
                    Merging::Gpb2 => 2,
                    Merging::Linear => 3,
                };
                let largest_count = match grid {
                    Some(grid) => grid.largest_count as u32,
                    None => 0,
                };
                let of_preview = match preview {
                    Some(preview) => (1 + preview.outputs() as u32) << 8 ^ (preview.samples() as u32) << 16,
                    None => 0,
                };
                let [measured, told] = [self.measurement_buffer as u32, self.acknowledgement_buffer as u32];
                Part::Word(measured ^ told.rotate_left(16) ^ merging << 14 ^ largest_count ^ of_preview)
            }
            _ => self.actuator.part(place - 14),
        }
    }
}

/// What of it is no number.
const fn word_of<T, const NY: usize>(plausibility: &Plausibility<T, NY>) -> u32 {
    let Plausibility { doubt_after, stuck_after, rejects_stuck, stale_after, lost_after, .. } = plausibility;
    let mut word = *stale_after as u32 | (*lost_after as u32) << 16;
    word ^= ((*doubt_after as u32) << 8 | *rejects_stuck as u32).rotate_left(10);
    let mut output = 0;
    while output < NY {
        word = word.rotate_left(7) ^ stuck_after[output] as u32;
        output += 1;
    }
    word
}

macro_rules! constants {
    ($scalar:ty) => {
        impl<const NX: usize, const NU: usize, const NY: usize> Design<'_, $scalar, NX, NU, NY> {
            /// Of constants, as [`Controller::check_memory`] expects them: CRC-32/ISCSI of all that is in them.
            ///
            /// Of large tables the compiler warns that this takes long; `#[allow(long_running_const_eval)]` says that it may.
            pub const fn checksums(&self) -> Checksums {
                Checksums([
                    checksum_of!(place => self.law_part(place)),
                    checksum_of!(place => self.plant_part(place)),
                ])
            }
        }
    };
}
constants!(f32);
constants!(f64);

/// How far the check of a controller's memory has come.
pub(super) struct Check {
    stage: Stage,
    round: Round,
    /// Of what was made at the start, once the first round has seen it.
    made: Option<u32>,
    /// Whether the law is another one than the design's.
    pub(super) is_law_replaced: bool,
    /// Whether memory has changed by itself.
    pub(super) is_damaged: bool,
}

/// What is being checked; the first two in the order of [`Checksums`].
#[derive(Debug, Clone, Copy)]
enum Stage {
    Law,
    Plant,
    Made,
}

impl core::fmt::Debug for Check {
    /// Without checksums: they tell where memory is, which says nothing of the controller.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { is_law_replaced, is_damaged, .. } = self;
        f.debug_struct("Check")
            .field("is_law_replaced", is_law_replaced)
            .field("is_damaged", is_damaged)
            .finish_non_exhaustive()
    }
}

impl Check {
    /// Of a controller that is being made.
    pub(super) const NEW: Self = Self {
        stage: Stage::Law,
        round: Round::START,
        made: None,
        is_law_replaced: false,
        is_damaged: false,
    };

    /// Of one that begins anew: memory that has changed is not trusted again.
    pub(super) fn restart(&mut self) {
        *self = Self { is_damaged: self.is_damaged, ..Self::NEW };
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'_, T, NX, NU, NY> {
    /// What was made at the start: constants of the filter, and where memory is.
    fn made_part(&self, place: usize) -> Part<'_, T> {
        match place {
            0 => {
                let memory = [&self.expected, &self.feedforward, &self.displaced, &self.room];
                let word = memory.iter().fold(0, |word, memory| word ^ place_of(memory));
                #[cfg(feature = "schedule")]
                let word = word ^ place_of(self.numbers).rotate_left(1);
                Part::Word(word ^ self.in_flight.word() ^ self.filter.word())
            }
            _ => self.filter.part(place - 1),
        }
    }

    /// Takes up to `numbers` more of what does not change through a checksum: the design's tables, constants and settings, and what
    /// was made of them at the start. Where one of the checksums is not as it was, the controller is lost. Returns whether a
    /// round has ended with this call.
    ///
    /// `expected`: [`Design::checksums`] of the constants that the design may be made of, computed when they were compiled: of
    /// memory that was damaged before the program began no other is right. A law or trigger that was set later is not checked,
    /// nor one of a bank, which has a check of its own.
    ///
    /// What was made at the start is compared with what the first round found. Before the first cycle call it with `usize::MAX`
    /// until a round has ended, and then in idle time.
    #[inline(never)]
    pub fn check_memory(&mut self, expected: &[Checksums], numbers: usize) -> bool {
        // The two count the same cycles, and each within its ring.
        let is_in_step = self.in_flight.proposed().tick == self.filter.tick();
        self.check.is_damaged |= !(is_in_step && self.filter.is_in_range() && self.in_flight.is_in_range());
        let (stage, mut round) = (self.check.stage, self.check.round);
        let found = round.go_on(numbers, &|place| match stage {
            Stage::Law => self.design.law_part(place),
            Stage::Plant => self.design.plant_part(place),
            Stage::Made => self.made_part(place),
        });
        self.check.round = round;
        let Some(found) = found else { return false };
        let is_right = match stage {
            Stage::Made => *self.check.made.get_or_insert(found) == found,
            Stage::Law if self.check.is_law_replaced => true,
            stage => expected.iter().any(|Checksums(sums)| sums.get(stage as usize) == Some(&found)),
        };
        self.check.is_damaged |= !is_right;
        self.check.stage = match stage {
            Stage::Law => Stage::Plant,
            Stage::Plant => Stage::Made,
            Stage::Made => Stage::Law,
        };
        matches!(stage, Stage::Made)
    }

    /// Something that looks after the memory has found it changed, such as an error-correcting memory, or the check of a bank: from
    /// now on the controller is lost.
    pub fn report_memory_fault(&mut self) {
        self.check.is_damaged = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Tick,
        actuator::Settings,
        checked::{Finite, Probabilities},
        gains::{Gains, Tables},
        health::{Cause, Health},
    };
    use nalgebra::{Matrix2, RowVector2, Vector1, Vector2};

    crate::controller_memory!(struct Memory: f64, 2, 1, 1; crate::controller::Sizes::of(2, 5, 1));

    const MODEL: Model<f64, 2, 1, 1> = Model {
        a: Matrix2::new(1.0, 0.1, 0.0, 1.0),
        b: Vector2::new(0.005, 0.1),
        c: RowVector2::new(1.0, 0.0),
        process_noise: Matrix2::new(1e-4, 0.0, 0.0, 1e-4),
        measurement_noise: Vector1::new(1e-4),
        initial_mean: Vector2::new(0.0, 0.0),
        initial_covariance: Matrix2::new(1.0, 0.0, 0.0, 1.0),
    };
    const DESIGN: Design<'static, f64, 2, 1, 1> = Design {
        gains: Gains::<f64, 2, 1>::new(
            2,
            DefaultInput::Zero,
            Tables {
                lx: Finite::<f64>::new(&[-3.0, -2.5, -2.5, -2.25]),
                m: Finite::<f64>::new(&[0.0, -0.5]),
                arrival: Probabilities::<f64>::new(&[0.5]),
            },
        ),
        model: &MODEL,
        actuator: Settings { default_input: DefaultInput::Zero, limits: None, safe: None },
        measurement_buffer: 4,
        acknowledgement_buffer: 4,
        preview: None,
        trigger: None,
        arrives_at_once: 0.5,
        merging: Merging::Single,
        plausibility: &Plausibility::NONE,
        grid: None,
    };
    const EXPECTED: [Checksums; 1] = [DESIGN.checksums()];

    #[test]
    fn a_bit_in_what_the_filter_made_of_the_plant_is_found_within_one_round() {
        for bit in [0, 31, 52, 63] {
            for place in 0.. {
                let mut memory = Memory::new();
                let mut controller = Controller::new(DESIGN, Tick(0), memory.lend()).expect("it fits");
                while !controller.check_memory(&EXPECTED, 3) {}
                assert!(!controller.health().is_lost());
                let change = |number: &mut f64| *number = f64::from_bits(number.to_bits() ^ 1 << bit);
                if !controller.filter.damage(place, change) {
                    assert_eq!(place, 5, "one output of two states, its noise, its mixing and its limit");
                    break;
                }
                while !controller.check_memory(&EXPECTED, 3) {}
                assert_eq!(controller.health(), Health::Lost(Cause::Memory), "number {place}, bit {bit}");
            }
        }
    }

    #[test]
    fn ends_of_memory_that_count_different_cycles_are_found_at_once() {
        let mut memory = Memory::new();
        let mut controller = Controller::new(DESIGN, Tick(0), memory.lend()).expect("it fits");
        controller.in_flight.push(false);
        controller.check_memory(&EXPECTED, 1);
        assert_eq!(controller.health(), Health::Lost(Cause::Memory));
    }
}
