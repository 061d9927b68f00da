//! A controller to simulate: which gains it has and which network it gets.
//!
//! There is one control algorithm, the core's. Controllers differ in what it is given: the collocated LQG controller is the
//! same algorithm on a network that loses and delays nothing, with sequences of one input designed for that network.

use gain_gen::{
    design::{Acknowledgement, Design, Link, MarkovLink, Network},
    solve::{
        ChannelLaw, Law, LoopProblem, Method, Outcome, PreviewGains, PreviewTooLong, Solution, Tracked,
        TriggerTables, finite_horizon, solve, solve_channel, tracking_task, trigger_tables,
    },
    stability::loses_sight,
};
use nalgebra::DVector;
use slqg::estimator::Merging;
use slqg_links::loop_bus::LoopPlan;
use std::str::FromStr;

/// Most tables of arrival probabilities that a simulated controller may choose from.
const MOST_TABLES: usize = 1 << 14;

/// The controllers that can be named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Sequence-based LQG on the design's network, with all that the design asks for. Thesis chapters 3 to 5.
    Slqg,
    /// The same, but it sends in every cycle, worth it or not.
    SlqgAlways,
    /// The same, but it takes the reference of the moment for all that is to come.
    SlqgNoPreview,
    /// The same, told the state of the channel to the actuator one cycle late, with gains for each of its states.
    SlqgChannel,
    /// Sequence-based LQG with the time-varying law of a task that ends with the run.
    SlqgTask,
    /// The same as the first, without any acknowledgement. Thesis 3.6.2, THEORY 8.
    SlqgUdp,
    /// The same, with the mean age rounded as the thesis has it, (3.43).
    SlqgUdpRounded,
    /// LQG at the plant, without a network: no controller on any network does better.
    Lqg,
}

impl Kind {
    /// Every controller there is.
    pub const ALL: [Self; 8] = [
        Self::Slqg,
        Self::SlqgAlways,
        Self::SlqgNoPreview,
        Self::SlqgChannel,
        Self::SlqgTask,
        Self::SlqgUdp,
        Self::SlqgUdpRounded,
        Self::Lqg,
    ];

    /// As on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slqg => "slqg",
            Self::SlqgAlways => "slqg-always",
            Self::SlqgNoPreview => "slqg-no-preview",
            Self::SlqgChannel => "slqg-channel",
            Self::SlqgTask => "slqg-task",
            Self::SlqgUdp => "slqg-udp",
            Self::SlqgUdpRounded => "slqg-udp-rounded",
            Self::Lqg => "lqg",
        }
    }

    /// Whether it is what it is for any length of the sequences.
    pub const fn ignores_length(self) -> bool {
        matches!(self, Self::Lqg)
    }
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|kind| kind.name()).collect();
            format!("no controller is called `{name}`; there are: {}", known.join(", "))
        })
    }
}

/// How much of the reference to come a controller knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foresight {
    /// As many samples as its gains take.
    Preview,
    /// The one of the moment.
    None,
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
    /// Cost of a packet, and what sending one is worth; `None` sends in every cycle.
    pub trigger: Option<(f64, TriggerTables)>,
    /// What a packet costs whether or not the controller minds; `None` where the design does not say.
    pub send_cost: Option<f64>,
    /// The reference from cycle 0 on, as far as it is looked ahead; empty where none is followed.
    pub reference: Vec<DVector<f64>>,
    /// Probability that a sequence arrives in the cycle it is sent in, as its estimator believes.
    pub arrives_at_once: f64,
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
}

/// Why a controller cannot be simulated.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ContenderError {
    /// No gains stabilise the loop.
    #[error("`{controller}` cannot stabilise the loop")]
    Unstable {
        /// The controller.
        controller: &'static str,
    },
    /// The design tracks something that it does not give.
    #[error("tracking.reference: missing; give the points in time that the simulation is to follow")]
    NoReference,
    /// The preview cannot be as long as asked.
    #[error(transparent)]
    Preview(#[from] PreviewTooLong),
    /// The controller differs from `slqg` in something that the design does not have.
    #[error("`{controller}` is `slqg` here: the design has no {table}; leave it out")]
    Pointless {
        /// The controller.
        controller: &'static str,
        /// The table it is about.
        table: &'static str,
    },
    /// There is no channel to know.
    #[error(
        "`slqg-channel` needs a link controller_to_actuator given as gilbert_elliott or markov: on others packets are \
         independent, and `slqg` is optimal"
    )]
    NoChannel,
    /// The channel's designs do not go with something else the design asks for.
    #[error("`slqg-channel` cannot go with {with}: {reason}; leave it out, or simulate `slqg`")]
    ChannelAlone {
        /// The key.
        with: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// The channel is too rich for the simulator.
    #[error(
        "`slqg-channel`: a channel of {states} states and sequences of {length} inputs make more than {MOST_TABLES} tables; \
         shorten the sequences"
    )]
    TooManyTables {
        /// States of the channel.
        states: usize,
        /// Inputs per sequence.
        length: usize,
    },
    /// A task cannot decide whether to send.
    #[error(
        "`slqg-task` cannot be event-triggered: what sending is worth is known for a loop that goes on; leave [event] out, or simulate `slqg`"
    )]
    TriggeredTask,
}

impl Contender {
    /// The controller `kind` designed for `design` and runs of `steps` cycles.
    ///
    /// # Errors
    /// If the controller cannot work with the design or its network.
    pub fn new(kind: Kind, design: &Design, steps: usize) -> Result<Self, ContenderError> {
        let controller = kind.name();
        makes_sense(kind, design)?;
        let mut problem = LoopProblem::of(design);
        let network = &design.network;
        let (actuator_link, sensor_link, measurement_buffer) = if kind == Kind::Lqg {
            problem.link = Link::perfect().delays;
            problem.length = 1;
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
            Acknowledgement::None | Acknowledgement::Over(_) => design.controller.estimator,
        };
        let mut contender = Self {
            kind,
            laws: Vec::new(),
            channel: None,
            feedforward: Vec::new(),
            preview: None,
            foresight: if kind == Kind::SlqgNoPreview { Foresight::None } else { Foresight::Preview },
            trigger: None,
            send_cost: design
                .event
                .as_ref()
                .map(|event| if kind == Kind::Lqg { 0.0 } else { event.send_cost }),
            reference: Vec::new(),
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
        };
        if kind == Kind::SlqgTask {
            contender.make_task(&problem, design, steps)?;
            return Ok(contender);
        }
        if kind == Kind::SlqgChannel {
            contender.know_channel(&problem, design)?;
            return Ok(contender);
        }
        let solution = solve(&problem, Method::InFlight);
        let blind = loses_sight(&design.plant, &contender.sensor_link.delays, measurement_buffer);
        if !solution.is_stabilising() || blind {
            return Err(ContenderError::Unstable { controller });
        }
        contender.make_steady(&problem, design, &solution, steps)?;
        contender.laws = vec![solution.law];
        Ok(contender)
    }

    /// Puts the controller on another network than it was designed for: it takes no notice.
    pub fn put_on(&mut self, network: &Network) {
        self.actuator_link = network.controller_to_actuator.clone();
        self.sensor_link = network.sensor_to_controller.clone();
        self.acknowledgement = network.acknowledgement.clone();
        self.bus = network.bus.clone();
    }

    fn make_task(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
        steps: usize,
    ) -> Result<(), ContenderError> {
        self.reference = reference(design, steps + 1)?;
        let task = match Tracked::of(design) {
            Some(tracked) => tracking_task(problem, &tracked, &self.reference),
            None => finite_horizon(problem, &design.cost.terminal, steps),
        };
        self.laws = task.laws;
        self.feedforward = task.tracked.map(|tracked| tracked.feedforward).unwrap_or_default();
        Ok(())
    }

    fn know_channel(&mut self, problem: &LoopProblem, design: &Design) -> Result<(), ContenderError> {
        let controller = self.kind.name();
        let channel = self.actuator_link.channel().ok_or(ContenderError::NoChannel)?;
        // The simulator looks arrival probabilities up by the states of all cycles that count.
        let tables = channel.states().checked_pow(problem.length.max(2) as u32 - 1);
        if tables.is_none_or(|tables| tables > MOST_TABLES) {
            return Err(ContenderError::TooManyTables { states: channel.states(), length: problem.length });
        }
        let solution = solve_channel(problem, channel);
        if solution.outcome != Outcome::Converged {
            return Err(ContenderError::Unstable { controller });
        }
        let law = solution.law;
        if loses_sight(&design.plant, &self.sensor_link.delays, self.measurement_buffer) {
            return Err(ContenderError::Unstable { controller });
        }
        self.laws = (0..law.channel_states()).map(|state| law.at(&[state])).collect();
        self.channel = Some(law);
        Ok(())
    }

    /// The state in which the channel to the actuator is most of the time; 0 without one.
    pub fn usual_channel_state(&self) -> usize {
        let shares = self.actuator_link.channel().map_or(&[] as &[f64], MarkovLink::shares);
        (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(0)
    }

    fn make_steady(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
        solution: &Solution,
        steps: usize,
    ) -> Result<(), ContenderError> {
        self.preview = PreviewGains::over(problem, design, solution).transpose()?;
        let ahead = self.preview.as_ref().map_or(0, |preview| preview.samples);
        self.reference = reference(design, steps + 1 + ahead)?;
        if !matches!(self.kind, Kind::SlqgAlways | Kind::Lqg) {
            let tables =
                design.event.as_ref().map(|event| (event.send_cost, trigger_tables(problem, solution)));
            self.trigger = tables.and_then(|(cost, tables)| Some((cost, tables?)));
        }
        Ok(())
    }
}

/// `z_k` for `k = 0..cycles`; nothing where the design tracks nothing.
fn reference(design: &Design, cycles: usize) -> Result<Vec<DVector<f64>>, ContenderError> {
    let Some(tracking) = &design.tracking else { return Ok(Vec::new()) };
    let at = |cycle| tracking.reference(cycle, design.plant.sample_time);
    (0..cycles).map(|cycle| at(cycle).ok_or(ContenderError::NoReference)).collect()
}

fn makes_sense(kind: Kind, design: &Design) -> Result<(), ContenderError> {
    let controller = kind.name();
    match kind {
        Kind::SlqgAlways if design.event.is_none() => {
            Err(ContenderError::Pointless { controller, table: "[event]" })
        }
        Kind::SlqgNoPreview if design.tracking.is_none() => {
            Err(ContenderError::Pointless { controller, table: "[tracking]" })
        }
        Kind::SlqgTask if design.event.is_some() => Err(ContenderError::TriggeredTask),
        Kind::SlqgChannel => {
            let (with, reason) = if design.event.is_some() {
                ("[event]", "what sending is worth is known for independent packets")
            } else if design.tracking.is_some() {
                ("[tracking]", "preview gains are known for independent packets")
            } else if design.network.acknowledgement != Acknowledgement::Instant {
                ("network.acknowledgement", "its gains are for ages known one cycle late")
            } else {
                return Ok(());
            };
            Err(ContenderError::ChannelAlone { with, reason })
        }
        _ => Ok(()),
    }
}
