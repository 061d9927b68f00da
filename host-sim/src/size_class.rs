//! From matrices of any size to the core's static types: the one place where a size class is chosen.
//!
//! The core's dimensions are const generics. A design is padded with zeros to the smallest class that holds it; padded
//! states, inputs and outputs stay exactly zero, so results do not depend on the class.

use crate::contender::Contender;
use crate::plant::{TruePlant, padded};
use gain_gen::design::{Design, DeviceScalar};
use nalgebra::{DMatrix, SMatrix, SVector};
use slqg::{
    Scalar,
    actuator::{Limits, Settings},
    controller,
    estimator::Model,
    gains::{Gains, InvalidGains, Tables},
};

/// Most inputs a simulated sequence may have: the capacity of every class.
pub const LONGEST_SEQUENCE: usize = 32;
/// Cycles the simulated estimator remembers: a measurement may be one less late.
pub const MEMORY: usize = 64;

/// Why a design does not fit any class.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TooLarge {
    /// The plant is too large.
    #[error(
        "the plant has {states} states, {inputs} inputs and {outputs} outputs; the simulator takes up to 16, 8 and 16"
    )]
    Plant {
        /// States found.
        states: usize,
        /// Inputs found.
        inputs: usize,
        /// Outputs found.
        outputs: usize,
    },
    /// Sequences are too long.
    #[error("controller.sequence_length: found {0}; the simulator takes up to {LONGEST_SEQUENCE}")]
    Sequence(usize),
    /// The measurement buffer is too long.
    #[error("controller.measurement_buffer: found {0}; the simulator takes up to {max}", max = MEMORY - 1)]
    MeasurementBuffer(usize),
}

/// Scalars whose gains can be checked; bridges the core's per-type constructors.
pub trait SimScalar: Scalar {
    /// [`Gains::check`] for this scalar.
    ///
    /// # Errors
    /// Says why the tables are no gains.
    fn check_gains<'a, const NX: usize, const NU: usize>(
        length: usize,
        default_input: slqg::DefaultInput,
        tables: Tables<'a, Self>,
    ) -> Result<Gains<'a, Self, NX, NU>, InvalidGains>;
}

macro_rules! sim_scalar {
    ($scalar:ty) => {
        impl SimScalar for $scalar {
            fn check_gains<'a, const NX: usize, const NU: usize>(
                length: usize,
                default_input: slqg::DefaultInput,
                tables: Tables<'a, Self>,
            ) -> Result<Gains<'a, Self, NX, NU>, InvalidGains> {
                Gains::<$scalar, NX, NU>::check(length, default_input, tables)
            }
        }
    };
}
sim_scalar!(f32);
sim_scalar!(f64);

/// Work to be done in a size class.
pub trait InSizeClass {
    /// What comes of it.
    type Output;
    /// Does it with the core's types of this class.
    fn run<T: SimScalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output;
}

/// Checks that some class holds the design, without doing anything in it.
///
/// # Errors
/// If none does.
pub fn check(design: &Design) -> Result<(), TooLarge> {
    struct Nothing;
    impl InSizeClass for Nothing {
        type Output = ();
        fn run<T: SimScalar, const NX: usize, const NU: usize, const NY: usize>(self) {}
    }
    dispatch(design, Nothing)
}

/// Does `work` in the smallest class that holds the design, with the scalar the device computes in.
///
/// # Errors
/// If no class holds the design.
pub fn dispatch<W: InSizeClass>(design: &Design, work: W) -> Result<W::Output, TooLarge> {
    let plant = &design.plant;
    let size = (plant.states(), plant.inputs(), plant.outputs());
    let settings = &design.controller;
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
    smallest_class!((2, 1, 2), (4, 1, 2), (4, 2, 4), (8, 4, 8), (16, 8, 16));
    Err(TooLarge::Plant { states: size.0, inputs: size.1, outputs: size.2 })
}

/// A controller's constant data in the core's types.
#[derive(Debug, Clone)]
pub struct Fitted<T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    length: usize,
    default_input: slqg::DefaultInput,
    lx: Vec<T>,
    m: Vec<T>,
    arrival: Vec<T>,
    model: Model<T, NX, NU, NY>,
    actuator: Settings<T, NU>,
    measurement_buffer: usize,
    /// The plant to simulate.
    pub plant: TruePlant<NX, NU, NY>,
    /// State weight, of the size class.
    pub q: SMatrix<f64, NX, NX>,
    /// Terminal weight, of the size class.
    pub terminal: SMatrix<f64, NX, NX>,
    /// Input weight, of the size class.
    pub r: SMatrix<f64, NU, NU>,
}

impl<T: SimScalar, const NX: usize, const NU: usize, const NY: usize> Fitted<T, NX, NU, NY> {
    /// The contender's law and the design's plant, padded to the class.
    pub fn new(design: &Design, contender: &Contender) -> Self {
        let law = &contender.law;
        let (nx, nu, in_flight) =
            (design.plant.states(), law.inputs(), law.default_input.in_flight(law.length));
        // Row and column of a table over inputs, back in the table without padding.
        let block = |index: usize| (index % NU < nu).then_some(index / NU * nu + index % NU);
        let entry = |matrix: &DMatrix<f64>, row: Option<usize>, column: Option<usize>| match (row, column) {
            (Some(row), Some(column)) => T::nearest(matrix[(row, column)]),
            _ => T::zero(),
        };
        let rows = law.length * NU;
        let table = |matrix: &DMatrix<f64>, columns: usize, column_of: &dyn Fn(usize) -> Option<usize>| {
            (0..rows * columns)
                .map(|index| entry(matrix, block(index / columns), column_of(index % columns)))
                .collect::<Vec<T>>()
        };
        let plant = &design.plant;
        let mut measurement_noise = cast(&padded::<NY, NY>(&plant.measurement_noise));
        for output in plant.outputs()..NY {
            // A padded output has noise of its own, so that its innovation can be divided by.
            measurement_noise[(output, output)] = T::one();
        }
        let mean = DMatrix::from_column_slice(plant.states(), 1, plant.initial_mean.as_slice());
        Self {
            length: law.length,
            default_input: law.default_input,
            lx: table(&law.lx, NX, &|column| (column < nx).then_some(column)),
            m: table(&law.m, in_flight * NU, &block),
            arrival: law.arrival.iter().map(|&value| T::nearest(value)).collect(),
            model: Model {
                a: cast(&padded(&plant.a)),
                b: cast(&padded(&plant.b)),
                c: cast(&padded(&plant.c)),
                process_noise: cast(&padded(&plant.process_noise)),
                measurement_noise,
                initial_mean: cast(&padded(&mean)),
                initial_covariance: cast(&padded(&plant.initial_covariance)),
            },
            actuator: Settings {
                default_input: law.default_input,
                limits: design.controller.input_limits.as_ref().map(|limits| Limits {
                    min: SVector::from_fn(|i, _| {
                        limits.get(i).map_or(T::zero(), |&(min, _)| T::nearest(min))
                    }),
                    max: SVector::from_fn(|i, _| {
                        limits.get(i).map_or(T::zero(), |&(_, max)| T::nearest(max))
                    }),
                }),
            },
            measurement_buffer: contender.measurement_buffer,
            plant: TruePlant::new(plant),
            q: padded(&design.cost.q),
            terminal: padded(&design.cost.terminal),
            r: padded(&design.cost.r),
        }
    }

    /// The controller's constant data.
    ///
    /// # Errors
    /// If a gain does not fit the scalar.
    pub fn design(&self) -> Result<controller::Design<'_, T, NX, NU, NY>, InvalidGains> {
        let tables = Tables { lx: &self.lx, m: &self.m, arrival: &self.arrival };
        Ok(controller::Design {
            gains: T::check_gains(self.length, self.default_input, tables)?,
            model: &self.model,
            actuator: self.actuator,
            measurement_buffer: self.measurement_buffer,
        })
    }
}

fn cast<T: Scalar, const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> SMatrix<T, R, C> {
    matrix.map(T::nearest)
}
