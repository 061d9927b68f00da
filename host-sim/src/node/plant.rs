//! The plant node: the true plant with its noise, one cycle at a time on the wall clock.
//!
//! It is held still until the first input comes out of a sequence, as one holds a pendulum until it is controlled. What an input does over a
//! cycle is [`crate::plant`]'s, what it costs [`crate::objective`]'s.

use super::{
    applied::AppliedInput,
    clock::{Due, Pacer, WallTime, tick_of},
    clock_offset::{ClockOffset, Way},
    event_loop::{Channel, Node, Outbox},
    statistics::{Figure, Punctuality, Section},
};
use crate::{
    objective::Objective,
    plant::{PlantRun, TruePlant},
};
use nalgebra::SVector;
use slqg::{
    Age, Scalar,
    wire::{Measurement, encode_measurement, measurement_len},
};
use std::{collections::BTreeMap, marker::PhantomData};

/// State beyond this many times its initial or noise scale counts as diverged.
const DIVERGED: f64 = 1e6;

/// A plant in real time, whose measurements are of scalar `T`.
#[derive(Debug)]
pub struct PlantNode<'p, T, const NX: usize, const NU: usize, const NY: usize> {
    plant: PlantRun<'p, NX, NU, NY>,
    objective: &'p Objective<NX, NU>,
    /// Beyond it the plant has diverged.
    bound: f64,
    /// The design's own, without padding.
    inputs: usize,
    pacer: Pacer,
    punctuality: Punctuality,
    /// The cycle that the state is of; `None` while the plant is held.
    cycle: Option<u64>,
    /// Inputs that have come, by the cycle they are for.
    come: BTreeMap<u64, SVector<f64, NU>>,
    last_input: SVector<f64, NU>,
    cycles: u64,
    held: u64,
    cost: f64,
    largest: f64,
    received: u64,
    rejected: u64,
    /// Cycles whose input had not come when they were over.
    late_inputs: u64,
    actuator_clock: ClockOffset,
    scalar: PhantomData<T>,
}

impl<'p, T: Scalar, const NX: usize, const NU: usize, const NY: usize> PlantNode<'p, T, NX, NU, NY> {
    /// A plant that is held, its state drawn with `seed`; it has `inputs` inputs.
    pub fn new(
        plant: &'p TruePlant<NX, NU, NY>,
        objective: &'p Objective<NX, NU>,
        inputs: usize,
        seed: u64,
        pacer: Pacer,
        punctuality: Punctuality,
    ) -> Self {
        Self {
            bound: DIVERGED * plant.scale(),
            plant: PlantRun::new(plant, seed, 0),
            objective,
            inputs,
            pacer,
            punctuality,
            cycle: None,
            come: BTreeMap::new(),
            last_input: SVector::zeros(),
            cycles: 0,
            held: 0,
            cost: 0.0,
            largest: 0.0,
            received: 0,
            rejected: 0,
            late_inputs: 0,
            actuator_clock: ClockOffset::new(Way::Wire),
            scalar: PhantomData,
        }
    }

    /// The true state.
    pub fn state(&self) -> &SVector<f64, NX> {
        self.plant.state()
    }

    /// Mean stage cost of the cycles since the plant was let go; `None` before.
    pub fn cost_per_cycle(&self) -> Option<f64> {
        (self.cycles > 0).then(|| self.cost / self.cycles as f64)
    }

    /// Lets the state go on until `cycle` begins, with the inputs that have come for the cycles before it.
    fn go_on(&mut self, cycle: u64) {
        let from = match self.cycle {
            Some(from) => from,
            // Held until now: an input of the controller for the last cycle lets it go from there.
            None if self.come.contains_key(&(cycle - 1)) => cycle - 1,
            None => {
                self.held += 1;
                return;
            }
        };
        for over in from..cycle {
            match self.come.remove(&over) {
                Some(input) => self.last_input = input,
                None => self.late_inputs += 1,
            }
            // The weights of a set point are the same in every cycle.
            self.cost += self.objective.stage(0, self.plant.state(), &self.last_input);
            self.plant.step(&self.last_input);
            self.cycles += 1;
            self.largest = self.largest.max(self.plant.state().norm());
        }
        self.cycle = Some(cycle);
        self.come = self.come.split_off(&cycle);
    }

    fn measure(&mut self, cycle: u64, outbox: &mut Outbox) {
        let output = self.plant.measure().map(T::nearest);
        // A sender never puts a value on the wire that is not finite.
        if !output.iter().all(|value| value.is_finite()) {
            return;
        }
        let mut frame = vec![0; measurement_len(NY, T::BYTES)];
        let measurement = Measurement { tick: tick_of(cycle), output };
        if let Ok(frame) = encode_measurement(&measurement, &mut frame) {
            outbox.push((Channel::Measurement, frame.to_vec()));
        }
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Node for PlantNode<'_, T, NX, NU, NY> {
    fn next(&self) -> Option<WallTime> {
        Some(self.pacer.next())
    }

    fn act(&mut self, now: WallTime, outbox: &mut Outbox) {
        let due = self.pacer.due(now);
        self.punctuality.note(due);
        match due {
            Due::Nothing => {}
            Due::Act { cycle, .. } => {
                self.go_on(cycle);
                self.measure(cycle, outbox);
            }
            Due::BeginAnew { cycle, .. } => {
                // For so long nothing moved: time stood still for the plant.
                self.cycle = self.cycle.map(|_| cycle);
                self.come.clear();
                self.measure(cycle, outbox);
            }
        }
    }

    fn receive(&mut self, packet: &[u8], now: WallTime) {
        self.received += 1;
        let applied = AppliedInput::decode(packet).filter(|applied| applied.input.len() == self.inputs);
        let timetable = self.pacer.timetable();
        let of = |applied: &AppliedInput| timetable.cycle_of(applied.tick, now);
        let place = applied.as_ref().and_then(of);
        let (Some(applied), Some(cycle)) = (applied, place) else {
            self.rejected += 1;
            return;
        };
        self.actuator_clock.note(applied.tick, timetable, now);
        // Of a cycle that is over for the plant, or of one that has not begun.
        let begun = timetable.cycle(now);
        if cycle > begun || cycle < self.cycle.unwrap_or(begun.saturating_sub(1)) {
            self.rejected += 1;
            return;
        }
        if self.cycle.is_none() && applied.age == Age::Empty {
            // Nobody controls the plant yet.
            return;
        }
        let input = SVector::from_fn(|row, _| applied.input.get(row).copied().unwrap_or(0.0));
        self.come.insert(cycle, input);
    }

    fn cycles(&self) -> u64 {
        self.cycles
    }

    fn is_over(&self) -> bool {
        let size = self.plant.state().norm();
        size.is_nan() || size > self.bound
    }

    fn progress(&self) -> String {
        let misses = self.punctuality.misses();
        match self.cost_per_cycle() {
            None => format!("held until it is controlled, {misses} missed"),
            Some(cost) => format!(
                "cycle {}, {misses} missed: cost per cycle {cost:.5}, state {:.4}, {} late inputs",
                self.cycles,
                self.plant.state().norm(),
                self.late_inputs
            ),
        }
    }

    fn findings(&self) -> Vec<String> {
        self.actuator_clock.sentence("actuator").into_iter().collect()
    }

    fn sections(&self) -> Vec<Section> {
        let plant = vec![
            ("cycles", Figure::Count(self.cycles)),
            ("held", Figure::Count(self.held)),
            ("cost_per_cycle", Figure::Number(self.cost_per_cycle())),
            ("largest_state", Figure::Number(Some(self.largest))),
            ("state_now", Figure::Number(Some(self.plant.state().norm()))),
            ("diverged", Figure::Flag(self.is_over())),
        ];
        let inputs = vec![
            ("received", Figure::Count(self.received)),
            ("rejected", Figure::Count(self.rejected)),
            ("late_inputs", Figure::Count(self.late_inputs)),
            ("actuator_clock_ahead", self.actuator_clock.figure()),
        ];
        vec![self.punctuality.section(), ("plant", plant), ("applied_inputs", inputs)]
    }
}
