//! A contender's constant data in the core's types, padded to a size class.
//!
//! Which class that is, is [`crate::size_class`]'s to say. Padding puts zeros where the class has more states, inputs or
//! outputs than the design.

use crate::{
    carrier::Carrier,
    contender::{Contender, Foresight, Kind},
    objective::Objective,
    plant::{TruePlant, padded},
    size_class::{MEMORY, SimScalar},
};
use gain_gen::{
    design::{Design, Steps},
    solve::{Law, PreviewGains, TriggerTables},
};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use slqg::{
    DefaultInput, Scalar,
    actuator::{Limits, Settings},
    controller::{self, Controller},
    estimator::{Merging, Model},
    event::{self, InvalidTrigger, packed_index},
    gains::{Gains, InvalidGains, Tables},
    tracking::{self, Feedforward, InvalidPreview},
    wire::can::{Grid, LARGEST_COUNT},
};
use slqg_links::loop_bus::Role;

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
}

/// A law's gains, by rows.
#[derive(Debug, Clone)]
struct LawTables<T> {
    lx: Vec<T>,
    m: Vec<T>,
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

/// Preview gains, by rows.
#[derive(Debug, Clone)]
struct PreviewTables<T> {
    samples: usize,
    sequence: Vec<T>,
    displaced: Vec<T>,
}

/// Tables of an event trigger.
#[derive(Debug, Clone)]
struct EventTables<T> {
    send_cost: T,
    state: Vec<T>,
    in_flight: Vec<T>,
    sequence: Vec<T>,
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
    trigger: Option<EventTables<T>>,
    /// `z_k` from cycle 0 on, beyond the end as far as it is looked ahead. Empty where no reference is followed.
    reference: Vec<SVector<T, NX>>,
    foresight: Foresight,
    model: Model<T, NX, NU, NY>,
    actuator: Settings<T, NU>,
    measurement_buffer: usize,
    acknowledgement_buffer: usize,
    arrives_at_once: T,
    merging: Merging,
    /// What inputs are rounded to.
    grid: Option<Grid<T, NU>>,
    /// What outputs are rounded to before they are sent.
    output_grid: Option<Grid<T, NY>>,
    /// Bytes of the frames on a bus, by role.
    carried: [usize; Role::COUNT],
    /// The plant to simulate.
    pub plant: TruePlant<NX, NU, NY>,
    /// What a run costs.
    pub objective: Objective<NX, NU>,
}

/// Where an index over padded blocks of `PADDED` stands among blocks of `size`; `None` in the padding.
fn unpadded<const PADDED: usize>(index: usize, size: usize) -> Option<usize> {
    (index % PADDED < size).then_some(index / PADDED * size + index % PADDED)
}

/// A matrix by rows, each of its indices in blocks that are padded from `(rows, columns)` to `(R, C)`.
fn table<T: Scalar, const R: usize, const C: usize>(matrix: &DMatrix<f64>, blocks: (usize, usize)) -> Vec<T> {
    let (rows, columns) = (matrix.nrows() / blocks.0 * R, matrix.ncols() / blocks.1 * C);
    let at = |index: usize| {
        let row = unpadded::<R>(index / columns, blocks.0)?;
        Some(matrix[(row, unpadded::<C>(index % columns, blocks.1)?)])
    };
    (0..rows * columns).map(|index| T::nearest(at(index).unwrap_or(0.0))).collect()
}

/// The upper triangle of a symmetric matrix over `count` inputs, padded from `inputs` to `NU` each.
fn triangle<T: Scalar, const NU: usize>(packed: &[f64], count: usize, inputs: usize) -> Vec<T> {
    let (size, padded) = (count * inputs, count * NU);
    let mut out = Vec::with_capacity(event::TableLengths::packed(padded));
    for row in 0..padded {
        for column in row..padded {
            let place = unpadded::<NU>(row, inputs).zip(unpadded::<NU>(column, inputs));
            out.push(T::nearest(place.map_or(0.0, |(row, column)| packed[packed_index(size, row, column)])));
        }
    }
    out
}

fn cast<T: Scalar, const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> SMatrix<T, R, C> {
    matrix.map(T::nearest)
}

impl<T: SimScalar, const NX: usize, const NU: usize, const NY: usize> Fitted<T, NX, NU, NY> {
    /// The contender's laws and the design's plant, padded to the class.
    pub fn new(design: &Design, contender: &Contender) -> Self {
        let inputs = design.plant.inputs();
        let first = &contender.laws[0];
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
                .map(|(send_cost, tables)| event_tables::<T, NX, NU>(*send_cost, tables, first)),
            reference: contender.reference.iter().map(vector).collect(),
            foresight: contender.foresight,
            model: model(design),
            actuator: actuator(design, first.default_input),
            measurement_buffer: contender.measurement_buffer,
            acknowledgement_buffer: contender.acknowledgement_buffer.min(MEMORY - 1),
            arrives_at_once: T::nearest(contender.arrives_at_once),
            merging: contender.merging,
            grid: grid(design, contender.kind, |steps| &steps.inputs),
            output_grid: grid(design, contender.kind, |steps| &steps.outputs),
            carried: contender.bus.as_ref().map_or([0; Role::COUNT], |plan| {
                plan.messages.map(|message| message.map_or(0, |message| message.bytes))
            }),
            plant: TruePlant::new(&design.plant),
            objective: Objective::new(design, &contender.reference),
        }
    }

    /// How frames are packed for a bus.
    pub fn carrier(&self) -> Carrier<T, NU, NY> {
        Carrier::new(self.grid.zip(self.output_grid), self.carried)
    }

    /// An output as the sensor sends it.
    pub fn sent(&self, output: &SVector<f64, NY>) -> SVector<T, NY> {
        let output = output.map(T::nearest);
        self.output_grid.as_ref().map_or(output, |grid| grid.round(&output))
    }

    fn gains(&self, law: usize, arrival: usize) -> Result<Gains<'_, T, NX, NU>, InvalidGains> {
        let LawTables { lx, m } = &self.laws[law];
        let tables = Tables { lx, m, arrival: &self.arrivals[arrival] };
        T::check_gains(self.length, self.default_input, tables)
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
        let preview = self.preview.as_ref().map(|gains| {
            let tables = tracking::Tables { sequence: &gains.sequence, displaced: &gains.displaced };
            T::check_preview(length, default_input, NX, gains.samples, tables)
        });
        let trigger = self.trigger.as_ref().map(|trigger| {
            let EventTables { send_cost, state, in_flight, sequence } = trigger;
            let tables = event::Tables { state, in_flight, sequence };
            T::check_trigger(length, default_input, *send_cost, tables)
        });
        Ok(controller::Design {
            gains: self.gains(0, 0)?,
            model: &self.model,
            actuator: self.actuator,
            measurement_buffer: self.measurement_buffer,
            acknowledgement_buffer: self.acknowledgement_buffer,
            preview: preview.transpose()?,
            trigger: trigger.transpose()?,
            arrives_at_once: self.arrives_at_once,
            merging: self.merging,
            grid: self.grid,
        })
    }

    /// Hands the controller what it is told before cycle `cycle`: the law of a task or of a channel, or the reference.
    /// `channel`: states of the channel in the cycles before, the newest first.
    ///
    /// # Panics
    /// If [`Fitted::design`] refuses the tables.
    pub fn prepare<'f, const N: usize, const H: usize, const E: usize>(
        &'f self,
        controller: &mut Controller<'f, T, NX, NU, NY, N, H, E>,
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
            let feedforward =
                Feedforward { inputs: inputs.iter().copied().collect(), ..Feedforward::default() };
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

fn law_tables<T: Scalar, const NX: usize, const NU: usize>(law: &Law) -> LawTables<T> {
    let (states, inputs) = (law.lx.ncols(), law.inputs());
    LawTables {
        lx: table::<T, NU, NX>(&law.lx, (inputs, states)),
        m: table::<T, NU, NU>(&law.m, (inputs, inputs)),
    }
}

fn preview_tables<T: Scalar, const NX: usize, const NU: usize>(
    gains: &PreviewGains,
    inputs: usize,
) -> PreviewTables<T> {
    let blocks = (inputs, gains.sequence.ncols() / gains.samples);
    PreviewTables {
        samples: gains.samples,
        sequence: table::<T, NU, NX>(&gains.sequence, blocks),
        displaced: table::<T, NU, NX>(&gains.displaced, blocks),
    }
}

fn event_tables<T: Scalar, const NX: usize, const NU: usize>(
    send_cost: f64,
    tables: &TriggerTables,
    law: &Law,
) -> EventTables<T> {
    let (states, inputs) = (law.lx.ncols(), law.inputs());
    let expected = law.default_input.in_flight(law.length);
    let state = DMatrix::from_row_slice(states, expected * inputs, &tables.state);
    let mut rest = tables.in_flight.as_slice();
    let mut in_flight = Vec::new();
    for left in (1..=expected).rev() {
        let (own, others) = rest.split_at(event::TableLengths::packed(left * inputs));
        in_flight.extend(triangle::<T, NU>(own, left, inputs));
        rest = others;
    }
    EventTables {
        send_cost: T::nearest(send_cost),
        state: table::<T, NX, NU>(&state, (states, inputs)),
        in_flight,
        sequence: triangle::<T, NU>(&tables.sequence, law.length, inputs),
    }
}

fn model<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design,
) -> Model<T, NX, NU, NY> {
    let plant = &design.plant;
    let mut measurement_noise = cast(&padded::<NY, NY>(&plant.measurement_noise));
    for output in plant.outputs()..NY {
        // A padded output has noise of its own, so that its innovation can be divided by.
        measurement_noise[(output, output)] = T::one();
    }
    let mean = DMatrix::from_column_slice(plant.states(), 1, plant.initial_mean.as_slice());
    Model {
        a: cast(&padded(&plant.a)),
        b: cast(&padded(&plant.b)),
        c: cast(&padded(&plant.c)),
        process_noise: cast(&padded(&plant.process_noise)),
        measurement_noise,
        initial_mean: cast(&padded(&mean)),
        initial_covariance: cast(&padded(&plant.initial_covariance)),
    }
}

fn actuator<T: Scalar, const NU: usize>(design: &Design, default_input: DefaultInput) -> Settings<T, NU> {
    Settings {
        default_input,
        limits: design.controller.input_limits.as_ref().map(|limits| Limits {
            min: SVector::from_fn(|i, _| limits.get(i).map_or(T::zero(), |&(min, _)| T::nearest(min))),
            max: SVector::from_fn(|i, _| limits.get(i).map_or(T::zero(), |&(_, max)| T::nearest(max))),
        }),
    }
}

/// What values are rounded to on the network; a padded one is zero, which is on every grid. Without a network nothing is.
fn grid<T: Scalar, const D: usize>(
    design: &Design,
    kind: Kind,
    of: impl Fn(&Steps) -> &[f64],
) -> Option<Grid<T, D>> {
    let steps = design.wire.steps().filter(|_| kind != Kind::Lqg);
    steps.map(|steps| Grid {
        step: SVector::from_fn(|i, _| of(steps).get(i).map_or(T::one(), |&step| T::nearest(step))),
        largest_count: LARGEST_COUNT,
    })
}
