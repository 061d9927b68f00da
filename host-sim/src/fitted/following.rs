//! What keeps the law up with a link that changes: the core's tuner, or being told.

use super::{Fitted, tables::LawTables};
use crate::contender::Contender;
use gain_gen::solve::LoopProblem;
use nalgebra::DMatrix;
use slqg::{
    Scalar,
    controller::{self, Controller, Law},
    gains::{Gains, InvalidGains},
    tuning::{Basis, Event, InvalidTuner, Parameters, Tuner, tuner_len},
};

/// What a self-tuning controller knows of its design, padded.
#[derive(Debug, Clone)]
pub(super) struct TuningTables<T> {
    state_cost: Vec<T>,
    input_cost: Vec<T>,
    survival: Vec<T>,
}

impl<T: Scalar> TuningTables<T> {
    pub(super) fn new<const NX: usize, const NU: usize>(problem: &LoopProblem) -> Self {
        let square = |matrix: &DMatrix<f64>, size: usize| -> Vec<T> {
            let at = |index: usize| matrix.get((index / size, index % size)).copied().unwrap_or(0.0);
            (0..size * size).map(|index| T::nearest(at(index))).collect()
        };
        Self {
            state_cost: square(&problem.q, NX),
            input_cost: square(&problem.r, NU),
            survival: problem.survival().iter().map(|&left| T::nearest(left)).collect(),
        }
    }
}

/// A law that comes into force in some cycle.
#[derive(Debug, Clone)]
pub(super) struct LaterLaw<T> {
    pub(super) cycle: usize,
    pub(super) law: LawTables<T>,
    pub(super) arrival: Vec<T>,
    pub(super) arrives_at_once: T,
}

impl<T: Scalar> LaterLaw<T> {
    pub(super) fn of<const NX: usize, const NU: usize>(contender: &Contender) -> Option<Self> {
        let (change, to_come) = contender.change.as_ref().zip(contender.to_come.as_ref())?;
        Some(Self {
            cycle: change.cycle,
            law: super::law_tables::<T, NX, NU>(&to_come.law),
            arrival: to_come.law.arrival.iter().map(|&p| T::nearest(p)).collect(),
            arrives_at_once: T::nearest(to_come.arrives_at_once),
        })
    }
}

/// Says in each cycle of a run which law is in force, if it is not the design's.
pub enum Following<'f, T, const NX: usize, const NU: usize> {
    /// The design's always is.
    Nothing,
    /// This one from a cycle on.
    Told(usize, Law<'f, T, NX, NU>),
    /// What the core finds.
    Tuned(Box<Tuner<'f, T, NX, NU>>),
}

impl<T: Scalar, const NX: usize, const NU: usize> Following<'_, T, NX, NU> {
    /// Takes what acknowledgements have told.
    pub fn observe<const NY: usize>(&mut self, controller: &Controller<'_, T, NX, NU, NY>) {
        if let Self::Tuned(tuner) = self {
            tuner.observe(controller);
        }
    }

    /// The law in force in cycle `cycle`; `None` for the design's.
    pub fn law(&self, cycle: usize) -> Option<Law<'_, T, NX, NU>> {
        match self {
            Self::Nothing => None,
            Self::Told(from, law) => (cycle >= *from).then_some(*law),
            Self::Tuned(tuner) => tuner.law(),
        }
    }

    /// What is done once the frame is sent: at most `slices` slices, until something has happened.
    pub fn work(&mut self, slices: usize) -> Option<Event<T>> {
        match self {
            Self::Tuned(tuner) => (0..slices).find_map(|_| tuner.slice()),
            Self::Nothing | Self::Told(..) => None,
        }
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Fitted<T, NX, NU, NY> {
    fn basis(&self) -> Option<Basis<'_, T>> {
        let TuningTables { state_cost, input_cost, survival } = self.tuning.as_ref()?;
        Some(Basis { state_cost, input_cost, survival, default_input: self.default_input })
    }

    /// Numbers of memory for [`Fitted::following`].
    pub fn tuning_memory(&self) -> usize {
        self.basis().map_or(0, |basis| tuner_len(&basis, NX, NU))
    }

    /// What keeps the law of a run up with its link.
    ///
    /// # Errors
    /// If the law is larger than what is solved for in a simulation.
    pub fn following<'f>(
        &'f self,
        design: &controller::Design<'_, T, NX, NU, NY>,
        memory: &'f mut [T],
    ) -> Result<Following<'f, T, NX, NU>, InvalidTuner> {
        if let Some(basis) = self.basis() {
            let tuner = Tuner::new(design, basis, Parameters::DEFAULT, memory)?;
            return Ok(Following::Tuned(Box::new(tuner)));
        }
        let later = self.later.as_ref().and_then(|later| Some((later.cycle, self.later_law(later).ok()?)));
        Ok(later.map_or(Following::Nothing, |(cycle, law)| Following::Told(cycle, law)))
    }

    fn later_law<'f>(&'f self, later: &'f LaterLaw<T>) -> Result<Law<'f, T, NX, NU>, InvalidGains> {
        let LaterLaw { law: LawTables { lx, m }, arrival, arrives_at_once, .. } = later;
        let tables = slqg::gains::Tables::check(lx, m, arrival)?;
        let gains = Gains::check(self.length, self.default_input, tables)?;
        Ok(Law { gains, arrives_at_once: *arrives_at_once })
    }

    /// Whether [`Fitted::following`] will do.
    pub(super) fn check_following(
        &self,
        design: &controller::Design<'_, T, NX, NU, NY>,
    ) -> Result<(), super::Unfit> {
        if let Some(later) = &self.later {
            self.later_law(later)?;
        }
        self.following(design, &mut vec![T::zero(); self.tuning_memory()])?;
        Ok(())
    }
}
