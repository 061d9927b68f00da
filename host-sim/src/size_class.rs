//! From matrices of any size to the core's static types: the one place where a size class is chosen.
//!
//! The core's dimensions are const generics. A design is padded with zeros to the smallest class that holds it; padded
//! states, inputs and outputs stay exactly zero, so results do not depend on the class. A class has room for as many
//! tracked outputs as states. The padding itself is done in [`crate::fitted`].

use gain_gen::design::{Design, DeviceScalar, Misfit};
use slqg::{Scalar, estimator::MOST_STATES};

/// Most inputs a simulated sequence may have.
pub const LONGEST_SEQUENCE: usize = 32;
/// Most states, inputs and outputs of a simulated plant: the largest class.
const LARGEST: (usize, usize, usize) = (MOST_STATES, 8, 32);
/// Most cycles a simulated estimator remembers: a measurement may be one less late.
pub const MEMORY: usize = 64;

/// Why a design does not fit any class.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TooLarge {
    /// The plant is too large.
    #[error(
        "plant: found {states} states, {inputs} inputs and {outputs} outputs; the simulator runs what a device runs, which \
         takes up to {}, {} and {}; reduce the model, or let gain-gen alone have it",
        LARGEST.0, LARGEST.1, LARGEST.2
    )]
    Plant {
        /// States found.
        states: usize,
        /// Inputs found.
        inputs: usize,
        /// Outputs found.
        outputs: usize,
    },
    /// More tracked outputs than states of the largest class.
    #[error("tracking.z: found {0} tracked outputs; the simulator takes up to {max}", max = LARGEST.0)]
    TrackedOutputs(usize),
    /// Sequences are too long.
    #[error("controller.sequence_length: found {0}; the simulator takes up to {LONGEST_SEQUENCE}")]
    Sequence(usize),
    /// The measurement buffer is too long.
    #[error("controller.measurement_buffer: found {0}; the simulator takes up to {max}", max = MEMORY - 1)]
    MeasurementBuffer(usize),
    /// Frames are too long for the CAN frames that the design names.
    #[error(transparent)]
    Frames(#[from] Misfit),
}

/// Work to be done in a size class.
pub trait InSizeClass {
    /// What comes of it.
    type Output;
    /// Does it with the core's types of this class.
    fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output;
}

/// Checks that some class holds the design, without doing anything in it.
///
/// # Errors
/// If none does.
pub fn check(design: &Design) -> Result<(), TooLarge> {
    struct Nothing;
    impl InSizeClass for Nothing {
        type Output = ();
        fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) {}
    }
    dispatch(design, Nothing)
}

/// Does `work` in the smallest class that holds the design, with the scalar the device computes in.
///
/// # Errors
/// If no class holds the design.
pub fn dispatch<W: InSizeClass>(design: &Design, work: W) -> Result<W::Output, TooLarge> {
    let plant = &design.plant;
    let tracked = design.tracking.as_ref().map_or(0, |tracking| tracking.outputs());
    let size = (plant.states().max(tracked), plant.inputs(), plant.outputs());
    let settings = &design.controller;
    if let Some(misfit) = design.misfit() {
        return Err(misfit.into());
    }
    if settings.sequence_length > LONGEST_SEQUENCE {
        return Err(TooLarge::Sequence(settings.sequence_length));
    }
    if settings.measurement_buffer >= MEMORY {
        return Err(TooLarge::MeasurementBuffer(settings.measurement_buffer));
    }
    macro_rules! smallest_class {
        ($(($nx:literal, $nu:literal, $ny:literal)),*) => {
            $(if size.0 <= $nx && size.1 <= $nu && size.2 <= $ny {
                return Ok(match settings.scalar {
                    DeviceScalar::F32 => work.run::<f32, $nx, $nu, $ny>(),
                    DeviceScalar::F64 => work.run::<f64, $nx, $nu, $ny>(),
                });
            })*
        };
    }
    smallest_class!((2, 1, 2), (4, 1, 2), (4, 2, 4), (8, 4, 8), (16, 8, 16), (32, 8, 32));
    if plant.states() <= LARGEST.0 && tracked > LARGEST.0 {
        return Err(TooLarge::TrackedOutputs(tracked));
    }
    Err(TooLarge::Plant { states: plant.states(), inputs: size.1, outputs: size.2 })
}
