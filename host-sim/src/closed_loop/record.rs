//! What one cycle of a run was, for pictures: state, estimate, input, and what became of the frames.
//!
//! What becomes of frames is decided elsewhere; here it is written down.

use crate::{contender::Contender, size_class::LONGEST_SEQUENCE};
use gain_gen::design::Acknowledgement;
use nalgebra::SVector;
use slqg::{Scalar, estimator::Estimate, tuning, wire};
use slqg_links::{
    loop_bus::{LoopBus, Role},
    path::Fate,
};

/// A frame that one of the ends took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// What it is.
    pub role: Role,
    /// The cycle it was sent in.
    pub sent: usize,
}

/// One cycle of a run, for pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleRecord {
    /// True state.
    pub state: Vec<f64>,
    /// The controller's estimate of it.
    pub estimate: Vec<f64>,
    /// Standard deviation of its error, as the controller has it.
    pub deviation: Vec<f64>,
    /// Input applied.
    pub input: Vec<f64>,
    /// Tracked output and what it is to be; empty where nothing is tracked.
    pub tracked: Vec<(f64, f64)>,
    /// Age of the sequence the input came from; `None` for the default input.
    pub age: Option<usize>,
    /// What became of the control frame; `None` if none was sent.
    pub control_frame: Option<Fate>,
    /// What became of the measurement frame; `None` in the first cycle, which has none.
    pub measurement_frame: Option<Fate>,
    /// What became of the acknowledgement frame; `None` if there is no way back for it. Taken a cycle later than its delay
    /// says, as it is about a cycle that is over.
    pub acknowledgement_frame: Option<Fate>,
    /// Frames taken in this cycle, in their order. Only where links make copies of packets; elsewhere fates tell.
    pub arrivals: Vec<Arrival>,
}

impl CycleRecord {
    /// Fills in what became of frames that were on a bus, where that was decided later than they were sent.
    pub fn learn_fates(&mut self, bus: Option<&LoopBus>, cycle: usize) {
        let open = [
            (Role::Control, &mut self.control_frame),
            (Role::Measurement, &mut self.measurement_frame),
            (Role::Acknowledgement, &mut self.acknowledgement_frame),
        ];
        for (role, fate) in open {
            let decided = bus.and_then(|bus| bus.fates(role).get(cycle).copied().flatten());
            if let (Some(Fate::Open), Some(decided)) = (&fate, decided) {
                *fate = Some(decided.map_or(Fate::Lost, Fate::Delayed));
            }
        }
    }
}

/// One cycle of a run, as it happens, in the size class.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'s, T: Scalar, const NX: usize, const NU: usize> {
    /// True state.
    pub state: &'s SVector<f64, NX>,
    /// The controller's estimate of it.
    pub estimate: &'s Estimate<T, NX>,
    /// Input applied.
    pub input: &'s SVector<f64, NU>,
    /// What the cycle costs.
    pub stage_cost: f64,
    /// What a controller did that tunes itself.
    pub tuning: Option<tuning::Event<T>>,
    /// Tracked outputs and what they are to be.
    pub tracked: Option<[SVector<f64, NX>; 2]>,
    /// Age of the sequence the input came from; `None` for the default input.
    pub age: Option<usize>,
    /// What became of the control frame; `None` if none was sent.
    pub control_frame: Option<Fate>,
    /// What became of the measurement frame; `None` in the first cycle.
    pub measurement_frame: Option<Fate>,
    /// What became of the acknowledgement frame; `None` if there is no way back for it.
    pub acknowledgement_frame: Option<Fate>,
    /// Frames taken in this cycle, where links make copies.
    pub arrivals: &'s [Arrival],
}

impl<T: Scalar, const NX: usize, const NU: usize> Snapshot<'_, T, NX, NU> {
    /// To keep.
    pub fn to_record(&self) -> CycleRecord {
        let pairs = |[z, reference]: [SVector<f64, NX>; 2]| -> Vec<_> {
            z.iter().copied().zip(reference.iter().copied()).collect()
        };
        CycleRecord {
            state: self.state.iter().copied().collect(),
            estimate: self.estimate.mean.iter().map(|value| value.widen()).collect(),
            deviation: self
                .estimate
                .covariance()
                .diagonal()
                .iter()
                .map(|value| value.widen().sqrt())
                .collect(),
            input: self.input.iter().copied().collect(),
            tracked: self.tracked.map(pairs).unwrap_or_default(),
            age: self.age,
            control_frame: self.control_frame,
            measurement_frame: self.measurement_frame,
            acknowledgement_frame: self.acknowledgement_frame,
            arrivals: self.arrivals.to_vec(),
        }
    }
}

/// What the ends take in a cycle, noted where links make copies: fates do not tell of those.
pub(super) struct Arrivals {
    pub(super) taken: Vec<Arrival>,
    are_noted: bool,
}

impl Arrivals {
    pub(super) fn new(contender: &Contender) -> Self {
        let told = match &contender.acknowledgement {
            Acknowledgement::Over(link) => Some(link),
            Acknowledgement::Instant | Acknowledgement::None => None,
        };
        let links = [Some(&contender.sensor_link), Some(&contender.actuator_link), told];
        let links = || links.iter().flatten();
        let are_noted = links().any(|link| link.duplicates > 0.0);
        // A packet and its copy may come from each of the cycles that packets are late by.
        let most = links().map(|link| 2 * (link.largest_delay() + 1)).sum();
        Self { taken: Vec::with_capacity(if are_noted { most } else { 0 }), are_noted }
    }

    pub(super) fn note<T: Scalar, const NU: usize, const NY: usize>(&mut self, frame: &[u8]) {
        if !self.are_noted {
            return;
        }
        let sent = if let Ok(measurement) = wire::decode_measurement::<T, NY>(frame) {
            Some((Role::Measurement, measurement.tick))
        } else if let Ok(sequence) =
            wire::decode_control::<T, NU>(frame, &mut [SVector::zeros(); LONGEST_SEQUENCE])
        {
            Some((Role::Control, sequence.tick))
        } else {
            let told = wire::decode_acknowledgement::<T>(frame).ok();
            told.map(|acknowledgement| (Role::Acknowledgement, acknowledgement.tick))
        };
        // Runs begin at tick 0.
        self.taken.extend(sent.map(|(role, tick)| Arrival { role, sent: tick.0 as usize }));
    }
}
