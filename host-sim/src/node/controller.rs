//! The controller node: the core's [`Controller`], one cycle at a time on the wall clock.
//!
//! It begins with the first measurement it hears, not before: until then it could only guess. The control law, the estimate
//! and the bytes are the core's; what is decided here is when they run.

use super::{
    arrivals::Arrivals,
    clock::{Due, Pacer, WallTime, tick_of},
    clock_offset::{ClockOffset, Way},
    event_loop::{Channel, Node, Outbox},
    statistics::{Figure, Punctuality, Section},
};
use crate::{fitted::Fitted, size_class::LONGEST_SEQUENCE};
use nalgebra::SMatrix;
use slqg::{
    Scalar, Tick,
    controller::{Controller, Design, Memory},
    estimator::Model,
    wire::{self, decode_acknowledgement, decode_measurement},
};

/// Frames kept for one cycle; more are a flood, and lost.
const INBOX: usize = 256;

/// A controller in real time.
#[derive(Debug)]
pub struct ControllerNode<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    fitted: &'f Fitted<T, NX, NU, NY>,
    /// What the core begins with, and begins anew with.
    first: Design<'f, T, NX, NU, NY>,
    again: Design<'f, T, NX, NU, NY>,
    pacer: Pacer,
    core: Controller<'f, T, NX, NU, NY>,
    /// Not while no measurement says that there is anything to control.
    has_begun: bool,
    /// Frames since the last cycle. The core takes none of a cycle that it has not caught up with.
    inbox: Vec<Vec<u8>>,
    frame: Vec<u8>,
    punctuality: Punctuality,
    measurements: Arrivals,
    acknowledgements: Arrivals,
    plant_clock: ClockOffset,
    actuator_clock: ClockOffset,
    starts: u64,
    lost_estimates: u64,
    sent: u64,
    rejected: u64,
    overflowed: u64,
}

impl<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize> ControllerNode<'f, T, NX, NU, NY> {
    /// A node that waits for its first measurement. `first` is the design of `fitted`, perhaps with another model to begin
    /// with; where the node begins anew, it is `again`.
    ///
    /// # Errors
    /// If the design does not fit together, or does not fit the memory.
    pub fn new(
        fitted: &'f Fitted<T, NX, NU, NY>,
        first: Design<'f, T, NX, NU, NY>,
        again: Design<'f, T, NX, NU, NY>,
        pacer: Pacer,
        punctuality: Punctuality,
        memory: Memory<'f, T, NX, NU, NY>,
    ) -> Result<Self, slqg::controller::InvalidDesign> {
        let mut core = Controller::new(first, Tick(0), memory)?;
        core.restart(again, Tick(0))?;
        Ok(Self {
            fitted,
            first,
            again,
            pacer,
            core,
            has_begun: false,
            inbox: Vec::new(),
            frame: vec![0; wire::control_len(NU, LONGEST_SEQUENCE, T::BYTES)],
            punctuality,
            measurements: Arrivals::default(),
            acknowledgements: Arrivals::default(),
            plant_clock: ClockOffset::new(Way::Link),
            actuator_clock: ClockOffset::new(Way::Link),
            starts: 0,
            lost_estimates: 0,
            sent: 0,
            rejected: 0,
            overflowed: 0,
        })
    }

    /// The core, once it has begun.
    pub fn core(&self) -> Option<&Controller<'f, T, NX, NU, NY>> {
        Some(&self.core).filter(|_| self.has_begun)
    }

    /// A core whose first cycle is that of the newest measurement in the inbox that is not later than it may be.
    fn begin(&mut self, cycle: u64) {
        let now = tick_of(cycle);
        let measured = |frame: &Vec<u8>| decode_measurement::<T, NY>(frame).ok().map(|frame| frame.tick);
        let usable =
            |tick: &Tick| now.age_of(*tick).is_some_and(|age| age as usize <= self.first.measurement_buffer);
        let ticks = self.inbox.iter().filter_map(measured).filter(usable);
        let Some(first) = ticks.min_by_key(|tick| now.since(*tick)) else { return };
        let design = if self.starts == 0 { self.first } else { self.again };
        self.core.restart(design, first).expect("checked when the node was made");
        self.has_begun = true;
        self.fitted.prepare(&mut self.core, 0, std::iter::empty());
        self.starts += 1;
    }

    fn cycle(&mut self, cycle: u64, outbox: &mut Outbox) {
        if !self.has_begun {
            self.begin(cycle);
        }
        let inbox = std::mem::take(&mut self.inbox);
        if !self.has_begun {
            self.rejected += inbox.len() as u64;
            return;
        }
        let core = &mut self.core;
        let counted = core.counts().begun_anew;
        // A measurement that the core begins with may be of an earlier cycle than the current one.
        let (own, others): (Vec<_>, Vec<_>) = inbox.iter().partition(|frame| {
            decode_measurement::<T, NY>(frame).is_ok_and(|measured| measured.tick == core.tick())
        });
        for frame in own {
            self.rejected += u64::from(core.receive(frame).is_err());
        }
        catch_up(core, tick_of(cycle));
        for frame in others {
            self.rejected += u64::from(core.receive(frame).is_err());
        }
        if let Ok(Some(frame)) = core.cycle(&mut self.frame) {
            outbox.push((Channel::Control, frame.to_vec()));
            self.sent += 1;
        }
        self.lost_estimates += u64::from(core.counts().begun_anew - counted);
    }
}

/// `model` for a controller that begins in the middle: the state of a loop that runs is as far from its initial mean as
/// that is from zero, each on its own. The diagonal of `initial_covariance + process_noise + mean mean'`, times `more`, is
/// added to the initial covariance, so that nothing is taken for certain that is not.
pub fn uncertain<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    model: &Model<T, NX, NU, NY>,
    more: T,
) -> Model<T, NX, NU, NY> {
    let mean = &model.initial_mean;
    let spread = model.initial_covariance + model.process_noise + mean * mean.transpose();
    let added = SMatrix::from_diagonal(&(spread.diagonal() * more));
    Model { initial_covariance: model.initial_covariance + added, ..model.clone() }
}

/// Runs the cycles before `tick` that nobody woke up in.
fn catch_up<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    core: &mut Controller<'_, T, NX, NU, NY>,
    tick: Tick,
) {
    while tick.is_after(core.tick()) {
        core.commit(false);
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Node
    for ControllerNode<'_, T, NX, NU, NY>
{
    fn next(&self) -> Option<WallTime> {
        Some(self.pacer.next())
    }

    fn act(&mut self, now: WallTime, outbox: &mut Outbox) {
        let due = self.pacer.due(now);
        self.punctuality.note(due);
        match due {
            Due::Nothing => {}
            Due::Act { cycle, .. } => self.cycle(cycle, outbox),
            Due::BeginAnew { cycle, .. } => {
                self.has_begun = false;
                self.cycle(cycle, outbox);
            }
        }
    }

    fn receive(&mut self, packet: &[u8], now: WallTime) {
        let timetable = self.pacer.timetable();
        if let Ok(measured) = decode_measurement::<T, NY>(packet) {
            self.measurements.note(measured.tick, timetable, now);
            self.plant_clock.note(measured.tick, timetable, now);
        } else if let Ok(told) = decode_acknowledgement::<T>(packet) {
            self.acknowledgements.note(told.tick, timetable, now);
            self.actuator_clock.note(told.tick, timetable, now);
        } else {
            self.rejected += 1;
            return;
        }
        if self.inbox.len() < INBOX {
            self.inbox.push(packet.to_vec());
        } else {
            self.overflowed += 1;
        }
    }

    fn cycles(&self) -> u64 {
        self.punctuality.cycles()
    }

    fn progress(&self) -> String {
        let state = if self.has_begun { "controls" } else { "waits for a measurement" };
        format!("cycle {}, {} missed: {state}", self.cycles(), self.punctuality.misses())
    }

    fn findings(&self) -> Vec<String> {
        let clocks = [(&self.plant_clock, "plant"), (&self.actuator_clock, "actuator")];
        clocks.into_iter().filter_map(|(clock, whose)| clock.sentence(whose)).collect()
    }

    fn sections(&self) -> Vec<Section> {
        let controller = vec![
            ("starts", Figure::Count(self.starts)),
            ("lost_estimates", Figure::Count(self.lost_estimates)),
            ("sent", Figure::Count(self.sent)),
            ("rejected", Figure::Count(self.rejected)),
            ("overflowed", Figure::Count(self.overflowed)),
            ("plant_clock_ahead", self.plant_clock.figure()),
            ("actuator_clock_ahead", self.actuator_clock.figure()),
        ];
        vec![
            self.punctuality.section(),
            ("controller", controller),
            ("measurements", self.measurements.figures()),
            ("acknowledgements", self.acknowledgements.figures()),
        ]
    }
}
