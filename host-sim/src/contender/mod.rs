//! A controller to simulate: which gains it has and which network it gets.
//!
//! There is one control algorithm, the core's. Controllers differ in what it is given: the collocated LQG controller is the
//! same algorithm on a network that loses and delays nothing, with sequences of one input designed for that network, and a
//! predicted nominal controller is the same algorithm with other tables. `docs/controllers.md` compares them.
//!
//! | file | what lives there |
//! |---|---|
//! | `kind` | names, and what is to be said of each controller in a line |
//! | `refusal` | why a controller cannot be simulated |
//! | `steady` | one optimal law for a link: the project's own, LQG at the plant, hold, losses without delays |
//! | `task` | one law for each cycle of a task that ends |
//! | `channel` | one law for each state of a channel |
//! | `adapting` | a link that changes: the law found by the core itself, or known beforehand |
//! | `nominal` | the tables of a nominal controller that predicts its own loop |
//! | `mpc` | the plan of model predictive control, as tables or as a problem to solve in every cycle |
//! | `outage` | cycles in which the links bring nothing |
//! | `deadband` | the rule that sends by the change of the inputs |
//!
//! What is decided on the host in each cycle, beside the core, is [`crate::decision`]'s.

mod adapting;
mod channel;
mod deadband;
mod kind;
mod mpc;
mod nominal;
mod outage;
mod refusal;
mod steady;
mod task;

use gain_gen::{
    design::{Acknowledgement, Design, Link, Network, Plant},
    solve::{ChannelLaw, Law, LoopProblem, PreviewGains, ScheduledTrigger, TriggerTables},
    stability::loses_sight,
};
use nalgebra::{DMatrix, DVector};
use slqg::estimator::Merging;
use slqg_links::loop_bus::LoopPlan;

pub use adapting::{Change, DEFAULT_SLICES, LawToCome, TuningBasis};
pub use deadband::{DEFAULT_DEADBAND, Deadband};
pub use kind::Kind;
pub use mpc::Constrained;
pub use outage::{NoOutage, Outage};
pub use refusal::ContenderError;

/// How much of the reference to come a controller knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foresight {
    /// As many samples as its gains take.
    Preview,
    /// The one of the moment.
    None,
}

/// What decides whether a packet is sent.
#[derive(Debug, Clone)]
pub enum Sending {
    /// What it is worth if every later one is sent.
    Worth(TriggerTables),
    /// What it is worth if later ones follow a schedule.
    WorthOverSchedule(ScheduledTrigger),
    /// The clock: it is sent once in so many cycles.
    Every(usize),
}

/// A controller with its gains and its network.
#[derive(Debug, Clone)]
pub struct Contender {
    /// Which controller.
    pub kind: Kind,
    /// Its control law: one, for a task one for each cycle, or one for each state of the channel.
    pub laws: Vec<Law>,
    /// The law that knows the channel, of which `laws` are the parts; `None` for others.
    pub channel: Option<ChannelLaw>,
    /// For a task that follows a reference: `Uff` of each cycle, `N nu`.
    pub feedforward: Vec<DVector<f64>>,
    /// What it makes of a reference, with one law.
    pub preview: Option<PreviewGains>,
    /// How much of the reference it knows.
    pub foresight: Foresight,
    /// Cost of a packet, and what decides whether one is sent; `None` sends in every cycle.
    pub trigger: Option<(f64, Sending)>,
    /// Sends by the change of the inputs; `None` for others.
    pub deadband: Option<Deadband>,
    /// The problem it solves in every cycle, with a law of zeros beside it; `None` for others.
    pub constrained: Option<Constrained>,
    /// What it solves its own gains from; `None` for others.
    pub tuning: Option<TuningBasis>,
    /// Slices of that which fit into a cycle.
    pub slices: usize,
    /// What becomes of its link to the actuator during a run.
    pub change: Option<Change>,
    /// When its links bring nothing.
    pub outages: Vec<Outage>,
    /// The law it then changes to, if it is told; `None` for others.
    pub to_come: Option<LawToCome>,
    /// What a packet costs whether or not the controller minds; `None` where the design does not say.
    pub send_cost: Option<f64>,
    /// The reference from cycle 0 on, as far as it is looked ahead; empty where none is followed.
    pub reference: Vec<DVector<f64>>,
    /// Probability that a sequence arrives in the cycle it is sent in, as its estimator believes.
    pub arrives_at_once: f64,
    /// The plant that it meets; `None`: the design's, which its estimator has for a model in any case.
    pub plant: Option<Plant>,
    /// Its link to the actuator.
    pub actuator_link: Link,
    /// Its link from the sensor.
    pub sensor_link: Link,
    /// The bus that links share which are on one.
    pub bus: Option<LoopPlan>,
    /// Most cycles a measurement may be late and still count.
    pub measurement_buffer: usize,
    /// What becomes of the acknowledgements.
    pub acknowledgement: Acknowledgement,
    /// Most cycles ago that an acknowledgement may tell of and still count.
    pub acknowledgement_buffer: usize,
    /// Cycles that each of them tells.
    pub acknowledged_cycles: usize,
    /// What its estimator keeps apart.
    pub merging: Merging,
    /// Whether it takes the mean age, rounded, for certain.
    pub rounds_age: bool,
    /// Process noise as its filter is told it, `nx x nx`; `None`: the plant's.
    pub filter_noise: Option<DMatrix<f64>>,
}

impl Contender {
    /// The controller `kind` designed for `design` and runs of `steps` cycles.
    ///
    /// # Errors
    /// If the controller cannot work with the design or its network.
    pub fn new(kind: Kind, design: &Design, steps: usize) -> Result<Self, ContenderError> {
        refusal::makes_sense(kind, design)?;
        let mut contender = Self::without_law(kind, design);
        let problem = LoopProblem::of(design);
        match kind {
            Kind::SlqgTask => contender.make_task(&problem, design, steps)?,
            Kind::SlqgChannel => contender.know_channel(&problem, design)?,
            Kind::Nominal | Kind::ExpectedInput | Kind::Deadband => {
                contender.predict_loop(&problem, design, steps)?;
            }
            Kind::Mpc => contender.plan_ahead(&problem, design)?,
            Kind::Slqg
            | Kind::SlqgAlways
            | Kind::SlqgPeriodic
            | Kind::SlqgNoPreview
            | Kind::SlqgTuning
            | Kind::SlqgTold
            | Kind::SlqgUdp
            | Kind::SlqgUdpRounded
            | Kind::Lqg
            | Kind::HoldLast
            | Kind::LqgLoss => contender.make_steady(problem, design, steps)?,
        }
        Ok(contender)
    }

    /// All but the law and what goes with it.
    fn without_law(kind: Kind, design: &Design) -> Self {
        let network = &design.network;
        let (actuator_link, sensor_link, measurement_buffer) = if kind == Kind::Lqg {
            (Link::perfect(), Link::perfect(), 0)
        } else {
            let buffer = design.controller.measurement_buffer;
            (network.controller_to_actuator.clone(), network.sensor_to_controller.clone(), buffer)
        };
        let acknowledgement = match kind {
            Kind::Lqg => Acknowledgement::Instant,
            Kind::SlqgUdp | Kind::SlqgUdpRounded => Acknowledgement::None,
            _ => network.acknowledgement.clone(),
        };
        let merging = match acknowledgement {
            // Every age is known: there is nothing to keep apart.
            Acknowledgement::Instant => Merging::Single,
            Acknowledgement::None | Acknowledgement::Over(_) => match (kind, design.estimator()) {
                (Kind::Slqg, estimator) => estimator,
                // Their gains are not made for a mean input.
                (_, Merging::Linear) => Merging::Single,
                (_, estimator) => estimator,
            },
        };
        let price = |send_cost| if kind == Kind::Lqg { 0.0 } else { send_cost };
        Self {
            kind,
            laws: Vec::new(),
            channel: None,
            feedforward: Vec::new(),
            preview: None,
            foresight: if kind == Kind::SlqgNoPreview { Foresight::None } else { Foresight::Preview },
            trigger: None,
            deadband: None,
            constrained: None,
            tuning: None,
            slices: DEFAULT_SLICES,
            change: None,
            outages: Vec::new(),
            to_come: None,
            send_cost: design.event.as_ref().map(|event| price(event.send_cost)),
            reference: Vec::new(),
            plant: None,
            arrives_at_once: actuator_link.delays.arrival(0),
            actuator_link,
            sensor_link,
            bus: network.bus.clone().filter(|_| kind != Kind::Lqg),
            measurement_buffer,
            acknowledgement_buffer: acknowledgement.reach(network.acknowledged_cycles),
            acknowledgement,
            acknowledged_cycles: network.acknowledged_cycles,
            merging,
            rounds_age: kind == Kind::SlqgUdpRounded,
            filter_noise: None,
        }
    }

    /// Puts the controller on another network than it was designed for: it takes no notice.
    pub fn put_on(&mut self, network: &Network) {
        self.actuator_link = network.controller_to_actuator.clone();
        self.sensor_link = network.sensor_to_controller.clone();
        self.acknowledgement = network.acknowledgement.clone();
        self.bus = network.bus.clone();
    }

    /// No controller stabilises what its filter cannot follow.
    fn must_see(&self, design: &Design) -> Result<(), ContenderError> {
        if loses_sight(&design.plant, &self.sensor_link.delays, self.measurement_buffer) {
            return Err(self.unstable());
        }
        Ok(())
    }

    fn unstable(&self) -> ContenderError {
        ContenderError::Unstable { controller: self.kind.name() }
    }

    /// Takes `z_k` for the cycles of a run of `steps` and for what its preview looks ahead; nothing where the design tracks
    /// nothing.
    fn learn_reference(&mut self, design: &Design, steps: usize) -> Result<(), ContenderError> {
        let Some(tracking) = &design.tracking else { return Ok(()) };
        let ahead = self.preview.as_ref().map_or(0, |preview| preview.samples);
        let at = |cycle| tracking.reference(cycle, design.plant.sample_time);
        let samples = (0..steps + 1 + ahead).map(|cycle| at(cycle).ok_or(ContenderError::NoReference));
        self.reference = samples.collect::<Result<_, _>>()?;
        Ok(())
    }
}
