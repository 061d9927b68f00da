//! The two ends of the loop as the simulator drives them: what comes in, what goes out.
//!
//! [`CoreEnds`] are the core's controller and actuator in this process. Ends that run elsewhere, on a microcontroller, are
//! [`crate::pil`]'s. Plant and links are [`crate::closed_loop`]'s: no end sees them.

use crate::{
    contender::Contender,
    decision::Decision,
    fitted::{Fitted, Following},
    lent::Lent,
    size_class::LONGEST_SEQUENCE,
};
use slqg::{
    Scalar, Tick,
    actuator::{Actuator, Applied},
    controller::{Controller, Law},
    estimator::Estimate,
    tuning, wire,
};
use std::convert::Infallible;

/// What was applied in a cycle, and the acknowledgement frame that tells of it; none if nobody was there to tell.
pub type Played<'e, T, const NU: usize> = (Applied<T, NU>, Option<&'e [u8]>);

/// Controller and actuator, with frames between them and the links.
pub trait Ends<T: Scalar, const NX: usize, const NU: usize> {
    /// Why they stopped.
    type Error;
    /// Cycle `cycle` begins, before anything arrives.
    ///
    /// # Errors
    /// If an end that should be there does not come.
    fn begin(&mut self, _cycle: usize) -> Result<(), Self::Error> {
        Ok(())
    }
    /// The controller takes a frame. What it refuses it counts.
    fn to_controller(&mut self, packet: &[u8]);
    /// The controller runs cycle `cycle`; returns its frame, if it sends one. `channel`: states of the channel to the actuator
    /// in the cycles before, the newest first.
    ///
    /// # Errors
    /// If the controller has stopped.
    fn control(
        &mut self,
        cycle: usize,
        channel: impl Iterator<Item = usize>,
    ) -> Result<Option<&[u8]>, Self::Error>;
    /// The actuator takes a frame. What it refuses it counts.
    fn to_actuator(&mut self, packet: &[u8]);
    /// The actuator applies the input of this cycle.
    ///
    /// # Errors
    /// If the actuator has stopped.
    fn play(&mut self) -> Result<Played<'_, T, NU>, Self::Error>;
    /// The controller's estimate of the state.
    fn estimate(&self) -> &Estimate<T, NX>;
    /// What the controller did in this cycle if it tunes itself.
    fn tuning(&self) -> Option<tuning::Event<T>> {
        None
    }
    /// Frames that either end refused.
    fn rejected(&self) -> u64;
}

/// The core's ends, in this process.
pub struct CoreEnds<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    fitted: &'f Fitted<T, NX, NU, NY>,
    contender: &'f Contender,
    controller: Controller<'f, T, NX, NU, NY>,
    decision: Decision<T, NU>,
    following: Following<'f, T, NX, NU>,
    tuning: Option<tuning::Event<T>>,
    actuator: Actuator<'f, T, NU>,
    frame: Vec<u8>,
}

impl<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize> CoreEnds<'f, T, NX, NU, NY> {
    /// Ends whose first cycle is 0. `memory` is for these ends.
    ///
    /// # Panics
    /// If the fitted controller's tables are no gains, which [`Fitted::design`] tells beforehand.
    pub fn new(
        fitted: &'f Fitted<T, NX, NU, NY>,
        contender: &'f Contender,
        memory: &'f mut Lent<T, NX, NU, NY>,
    ) -> Self {
        let design = fitted.design().expect("checked before the first run");
        let (of_controller, of_actuator, of_tuner) = memory.lend();
        let mut controller =
            Controller::new(design, Tick(0), of_controller).expect("memory was made for this design");
        controller.round_age(contender.rounds_age);
        Self {
            fitted,
            contender,
            controller,
            decision: Decision::new(fitted),
            following: fitted.following(&design, of_tuner).expect("checked before the first run"),
            tuning: None,
            actuator: Actuator::new(design.actuator, Tick(0), of_actuator),
            frame: vec![0; frame_capacity::<T>(NU, NY)],
        }
    }

    /// The controller has lost its memory and begins anew with cycle `tick`, as one that joins a loop that runs.
    pub fn restart_controller(&mut self, tick: Tick) {
        let design = self.fitted.joining_design().expect("checked before the first run");
        self.controller.restart(design, tick).expect("the same design but for where it begins");
        self.controller.round_age(self.contender.rounds_age);
        self.decision = Decision::new(self.fitted);
        if let Following::Told(..) = self.following {
            self.following = Following::Nothing;
        }
    }

    /// The law is another one from the next cycle on. It lasts until the controller is restarted.
    pub fn replace_law(&mut self, law: Law<'f, T, NX, NU>) {
        self.following = Following::Told(0, law);
    }

    /// The actuator has lost its memory and begins anew with cycle `tick`.
    pub fn restart_actuator(&mut self, tick: Tick) {
        self.actuator.restart(tick);
    }
}

/// Bytes of the longest frame between ends of a size class.
pub fn frame_capacity<T: Scalar>(inputs: usize, outputs: usize) -> usize {
    wire::control_len(inputs, LONGEST_SEQUENCE, T::BYTES)
        .max(wire::measurement_len(outputs, T::BYTES))
        .max(wire::LONGEST_ACKNOWLEDGEMENT)
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Ends<T, NX, NU>
    for CoreEnds<'_, T, NX, NU, NY>
{
    type Error = Infallible;

    fn to_controller(&mut self, packet: &[u8]) {
        // Refusals are counted at the ends.
        let _ = self.controller.receive(packet);
    }

    fn control(
        &mut self,
        cycle: usize,
        channel: impl Iterator<Item = usize>,
    ) -> Result<Option<&[u8]>, Infallible> {
        self.fitted.prepare(&mut self.controller, cycle, channel);
        self.following.observe(&self.controller);
        let sequence = match self.following.law(cycle) {
            None => self.decision.cycle(&mut self.controller, &mut self.frame),
            Some(law) => self
                .controller
                .cycle_under(&law, &mut self.frame)
                .expect("laws of one length, and room for every frame"),
        };
        let len = sequence.map(<[u8]>::len);
        // Once the frame is there to be sent.
        self.tuning = self.following.work(self.contender.slices);
        Ok(len.map(|len| &self.frame[..len]))
    }

    fn to_actuator(&mut self, packet: &[u8]) {
        let _ = self.actuator.receive(packet);
    }

    fn play(&mut self) -> Result<Played<'_, T, NU>, Infallible> {
        let applied = self.actuator.step();
        let told = self.actuator.acknowledgement(self.contender.acknowledged_cycles).expect("it has played");
        let frame =
            wire::encode_acknowledgement::<T>(&told, &mut self.frame).expect("the buffer holds every frame");
        Ok((applied, Some(frame)))
    }

    fn estimate(&self) -> &Estimate<T, NX> {
        self.controller.estimator().posterior()
    }

    fn tuning(&self) -> Option<tuning::Event<T>> {
        self.tuning
    }

    fn rejected(&self) -> u64 {
        u64::from(self.controller.counts().rejected_frames) + u64::from(self.actuator.rejected_frames())
    }
}
