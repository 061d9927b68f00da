//! A contender's constant data in the core's types, padded to a size class.
//!
//! Which class that is, is [`crate::size_class`]'s to say. Padding puts zeros where the class has more states, inputs or
//! outputs than the design. The tables are padded in `tables`, what both ends are told beside them in `ends`.

mod ends;
mod following;
mod tables;

use crate::{
    carrier::Carrier,
    contender::{Constrained, Contender, Deadband, Foresight},
    objective::Objective,
    plant::TruePlant,
    recovery::Recovery,
    size_class::MEMORY,
};
use ends::{actuator, grid, joining, model, plausibility};
use following::{LaterLaw, TuningTables};
use gain_gen::{design::Design, emit::design_id};
use nalgebra::{DVector, SVector};
use slqg::{
    DefaultInput, Scalar,
    actuator::Settings,
    blob::DesignId,
    controller::{self, Controller},
    estimator::{Merging, Model, Plausibility},
    event::{self, InvalidTrigger, Trigger},
    gains::{Gains, InvalidGains, Tables},
    tracking::{self, Feedforward, InvalidPreview, Preview},
    tuning::InvalidTuner,
    wire::can::Grid,
};
use slqg_links::loop_bus::Role;
use tables::{
    EventTables, LawTables, OverSchedule, PreviewTables, SendingTables, law_tables, preview_tables,
    sending_tables,
};

pub use following::Following;

/// Why a contender cannot be computed in the device's scalar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unfit {
    /// The law.
    #[error(transparent)]
    Gains(#[from] InvalidGains),
    /// The preview gains.
    #[error(transparent)]
    Preview(#[from] InvalidPreview),
    /// The tables of the event trigger.
    #[error(transparent)]
    Trigger(#[from] InvalidTrigger),
    /// The law that is solved for on the device.
    #[error(transparent)]
    Tuner(#[from] InvalidTuner),
}

/// Which law is in force in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Schedule {
    /// The only one.
    Constant,
    /// The cycle's own.
    Cycle,
    /// That of the channel's state in the cycle before, with arrival probabilities for its states in those before that.
    Channel {
        /// States of the channel.
        states: usize,
        /// Taken for a cycle of which nothing is known.
        usual: usize,
    },
}

/// A controller's constant data in the core's types.
#[derive(Debug, Clone)]
pub struct Fitted<T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    length: usize,
    default_input: DefaultInput,
    schedule: Schedule,
    /// One, one for each cycle, or one for each state of the channel.
    laws: Vec<LawTables<T>>,
    /// With one law for each cycle, `Uff` for each: `N` inputs. Empty where no reference is followed.
    feedforward: Vec<Vec<SVector<T, NU>>>,
    /// One table, or one for all states of the channel in as many cycles as packets count.
    arrivals: Vec<Vec<T>>,
    preview: Option<PreviewTables<T>>,
    trigger: Option<SendingTables<T>>,
    deadband: Option<Deadband>,
    /// What is solved in every cycle.
    constrained: Option<Constrained>,
    /// What the core solves its own gains from.
    tuning: Option<TuningTables<T>>,
    /// The law that it is told in some cycle.
    later: Option<LaterLaw<T>>,
    /// `z_k` from cycle 0 on, beyond the end as far as it is looked ahead. Empty where no reference is followed.
    reference: Vec<SVector<T, NX>>,
    foresight: Foresight,
    model: Model<T, NX, NU, NY>,
    /// The same for a controller that joins a loop that runs.
    joining: Model<T, NX, NU, NY>,
    actuator: Settings<T, NU>,
    measurement_buffer: usize,
    acknowledgement_buffer: usize,
    arrives_at_once: T,
    merging: Merging,
    plausibility: Plausibility<T, NY>,
    /// Whose frames are on the bus.
    design: DesignId,
    /// What inputs are rounded to.
    grid: Option<Grid<T, NU>>,
    /// What outputs are rounded to before they are sent.
    output_grid: Option<Grid<T, NY>>,
    /// Bytes of the frames on a bus, by role.
    carried: [usize; Role::COUNT],
    /// The plant to simulate.
    pub plant: TruePlant<NX, NU, NY>,
    /// From where its inputs lead back.
    pub recovery: Recovery<NX>,
    /// What a run costs.
    pub objective: Objective<NX, NU>,
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Fitted<T, NX, NU, NY> {
    /// The contender's laws, the design's plant for a model and the one it meets, padded to the class.
    pub fn new(design: &Design, contender: &Contender) -> Self {
        let inputs = design.plant.inputs();
        let plant = contender.plant.as_ref().unwrap_or(&design.plant);
        let first = &contender.laws[0];
        let noise = contender.filter_noise.as_ref().unwrap_or(&design.plant.process_noise);
        let vector = |value: &DVector<f64>| {
            SVector::from_fn(|row, _| T::nearest(value.get(row).copied().unwrap_or(0.0)))
        };
        let input =
            |block: &[f64]| SVector::from_fn(|row, _| T::nearest(block.get(row).copied().unwrap_or(0.0)));
        let (schedule, arrivals) = match &contender.channel {
            Some(law) => {
                let (states, usual) = (law.channel_states(), contender.usual_channel_state());
                (Schedule::Channel { states, usual }, law.arrival_tables())
            }
            None if contender.laws.len() > 1 => (Schedule::Cycle, vec![first.arrival.clone()]),
            None => (Schedule::Constant, vec![first.arrival.clone()]),
        };
        Self {
            length: first.length,
            default_input: first.default_input,
            laws: contender.laws.iter().map(|law| law_tables::<T, NX, NU>(law)).collect(),
            feedforward: contender
                .feedforward
                .iter()
                .map(|cycle| cycle.as_slice().chunks(inputs).map(input).collect())
                .collect(),
            schedule,
            arrivals: arrivals.iter().map(|table| table.iter().map(|&p| T::nearest(p)).collect()).collect(),
            preview: contender.preview.as_ref().map(|gains| preview_tables::<T, NX, NU>(gains, inputs)),
            trigger: contender
                .trigger
                .as_ref()
                .map(|(send_cost, sending)| sending_tables::<T, NX, NU>(*send_cost, sending, first)),
            deadband: contender.deadband,
            constrained: contender.constrained.clone(),
            tuning: contender.tuning.as_ref().map(|basis| TuningTables::new::<NX, NU>(&basis.problem)),
            later: LaterLaw::of::<NX, NU>(contender),
            reference: contender.reference.iter().map(vector).collect(),
            foresight: contender.foresight,
            model: model(design, noise),
            joining: joining(design, noise),
            actuator: actuator(design, first.default_input),
            measurement_buffer: contender.measurement_buffer,
            acknowledgement_buffer: contender.acknowledgement_buffer.min(MEMORY - 1),
            arrives_at_once: T::nearest(contender.arrives_at_once),
            merging: contender.merging,
            plausibility: plausibility(design, &contender.acknowledgement, contender.merging),
            design: design_id(design),
            grid: grid(design, contender.kind, |steps| &steps.inputs),
            output_grid: grid(design, contender.kind, |steps| &steps.outputs),
            carried: contender.bus.as_ref().map_or([0; Role::COUNT], |plan| {
                plan.messages.map(|message| message.map_or(0, |message| message.bytes))
            }),
            plant: TruePlant::new(plant),
            recovery: Recovery::of(plant, design.controller.input_limits.as_deref()),
            objective: Objective::new(design, &contender.reference),
        }
    }

    /// How frames are packed for a bus.
    pub fn carrier(&self) -> Carrier<T, NU, NY> {
        Carrier::new(self.design, self.grid.zip(self.output_grid), self.carried)
    }

    /// An output as the sensor sends it.
    pub fn sent(&self, output: &SVector<f64, NY>) -> SVector<T, NY> {
        let output = output.map(T::nearest);
        self.output_grid.as_ref().map_or(output, |grid| grid.round(&output))
    }

    fn gains(&self, law: usize, arrival: usize) -> Result<Gains<'_, T, NX, NU>, InvalidGains> {
        self.check_gains(&self.laws[law], arrival)
    }

    fn check_gains<'f>(
        &'f self,
        LawTables { lx, m }: &'f LawTables<T>,
        arrival: usize,
    ) -> Result<Gains<'f, T, NX, NU>, InvalidGains> {
        let tables = Tables::check(lx, m, &self.arrivals[arrival])?;
        Gains::check(self.length, self.default_input, tables)
    }

    /// The rule that sends by the change of the inputs, if there is one.
    pub fn deadband(&self) -> Option<Deadband> {
        self.deadband
    }

    /// What is solved in every cycle, if anything is.
    pub fn constrained(&self) -> Option<&Constrained> {
        self.constrained.as_ref()
    }

    /// The controller's constant data.
    ///
    /// # Errors
    /// If a number does not fit the scalar.
    pub fn design(&self) -> Result<controller::Design<'_, T, NX, NU, NY>, Unfit> {
        for law in 1..self.laws.len() {
            self.gains(law, 0)?;
        }
        for arrival in 1..self.arrivals.len() {
            self.gains(0, arrival)?;
        }
        let (length, default_input) = (self.length, self.default_input);
        let preview = self.preview.as_ref().map(|gains| -> Result<_, InvalidPreview> {
            let tables = tracking::Tables::check(&gains.sequence, &gains.displaced)?;
            Preview::check(length, default_input, NX, gains.samples, tables)
        });
        let trigger = self.trigger.as_ref().map(|trigger| -> Result<_, InvalidTrigger> {
            match trigger {
                SendingTables::Worth(EventTables { send_cost, state, in_flight, sequence }) => {
                    let tables = event::Tables::check(state, in_flight, sequence)?;
                    Trigger::check(length, default_input, *send_cost, tables)
                }
                SendingTables::WorthOverSchedule(tables) => {
                    let OverSchedule { send_cost, period, in_flight, decided, phases } = tables;
                    let tables = event::ScheduleTables::check(*period, in_flight, decided, phases)?;
                    Trigger::check_schedule(length, default_input, *send_cost, tables)
                }
                SendingTables::Every { send_cost, period } => {
                    Ok(Trigger::fixed(length, default_input, *send_cost, *period))
                }
            }
        });
        let design = controller::Design {
            gains: self.gains(0, 0)?,
            model: &self.model,
            actuator: self.actuator,
            measurement_buffer: self.measurement_buffer,
            acknowledgement_buffer: self.acknowledgement_buffer,
            preview: preview.transpose()?,
            trigger: trigger.transpose()?,
            arrives_at_once: self.arrives_at_once,
            merging: self.merging,
            plausibility: &self.plausibility,
            grid: self.grid,
        };
        self.check_following(&design)?;
        Ok(design)
    }

    /// The same for a controller that joins a loop that runs, whose state it does not know.
    ///
    /// # Errors
    /// As [`Fitted::design`].
    pub fn joining_design(&self) -> Result<controller::Design<'_, T, NX, NU, NY>, Unfit> {
        Ok(controller::Design { model: &self.joining, ..self.design()? })
    }

    /// The reference from cycle 0 on, and how many samples after the current cycle are known; none is followed, or it was
    /// taken account of beforehand: `None`.
    pub fn reference(&self) -> Option<(&[SVector<T, NX>], usize)> {
        self.preview.as_ref().map(|preview| (&*self.reference, preview.samples))
    }

    /// Hands the controller what it is told before cycle `cycle`: the law of a task or of a channel, or the reference.
    /// `channel`: states of the channel in the cycles before, the newest first.
    ///
    /// # Panics
    /// If [`Fitted::design`] refuses the tables.
    pub fn prepare<'f>(
        &'f self,
        controller: &mut Controller<'f, T, NX, NU, NY>,
        cycle: usize,
        channel: impl Iterator<Item = usize>,
    ) {
        let law = match self.schedule {
            Schedule::Constant => None,
            Schedule::Cycle => (cycle < self.laws.len()).then_some((cycle, 0)),
            Schedule::Channel { states, usual } => {
                let mut known = channel.chain(std::iter::repeat(usual)).take(self.length.max(2) - 1);
                let newest = known.next().unwrap_or(usual);
                let place = |before: usize, (state, weight)| before + state * weight;
                let weights = std::iter::successors(Some(states), |weight| Some(weight * states));
                Some((newest, known.zip(weights).fold(newest, place)))
            }
        };
        if let Some((law, arrival)) = law {
            let gains = self.gains(law, arrival).expect("checked with the design");
            controller.set_gains(gains).expect("laws of one length");
        }
        if let Some(inputs) = self.feedforward.get(cycle) {
            let feedforward = Feedforward { inputs, ..Feedforward::NONE };
            controller.set_feedforward(feedforward).expect("finite inputs");
        }
        if let Some(preview) = &self.preview {
            let known = match self.foresight {
                Foresight::Preview => cycle + 1..cycle + 1 + preview.samples,
                Foresight::None => cycle..cycle + 1,
            };
            controller.follow(&self.reference[known]).expect("samples of the tracked output");
        }
    }
}
