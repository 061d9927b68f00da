//! [`Tuner`]: beside a controller, what is done when.
//!
//! It listens to the acknowledgements, notices that the link is no longer the one in force, has it solved for slice by slice,
//! and switches to the new law once that is proved to stabilise the loop. Estimating is in `delays`, solving in `solver`.

use super::{
    Basis, Counts, DelayEstimate, Event, InvalidTuner, Kept, Parameters, Progress, Solver, delays, threshold,
    workspace_len,
};
use crate::{
    Scalar, Tick,
    bank::{self, Bank, InvalidLaw},
    blob::Shape,
    controller::{Controller, Design, Law},
    synthesis::InvalidProblem,
};

/// Looks at the distance in the time of one memory.
const LOOKS: u32 = 64;
/// Memories after which what was observed before a change no longer counts.
const SETTLED: u32 = 4;

/// Learns the link and keeps the law up with it.
///
/// Each cycle, in this order: the controller takes what has come; [`Tuner::observe`]; the controller's
/// [`Controller::cycle_under`] the law of [`Tuner::law`], or [`Controller::cycle`] while that is `None`; and once the frame
/// is sent, [`Tuner::slice`].
///
/// ```
/// use slqg::DefaultInput;
/// use slqg::tuning::{Basis, Parameters, Tuner, tuner_len};
/// # use slqg::actuator::Settings;
/// # use slqg::controller::{Controller, Design, Sizes};
/// # use slqg::estimator::{Merging, Model, Plausibility};
/// # use slqg::nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
/// # use slqg::{Age, Tick, wire::Acknowledgement};
/// # use slqg::checked::{Finite, Probabilities};
/// # use slqg::gains::{Gains, Tables};
/// # const LAW: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(
/// #     2,
/// #     DefaultInput::Zero,
/// #     Tables {
/// #         lx: Finite::<f32>::new(&[-3.0, -2.5, -2.5, -2.25]),
/// #         m: Finite::<f32>::new(&[0.0, -0.5]),
/// #         arrival: Probabilities::<f32>::new(&[0.5]),
/// #     },
/// # );
/// # let model = Model {
/// #     a: Matrix2::new(1.0, 0.1, 0.0, 1.0),
/// #     b: Vector2::new(0.005, 0.1),
/// #     c: RowVector2::new(1.0, 0.0),
/// #     process_noise: Matrix2::identity() * 1e-4,
/// #     measurement_noise: Vector1::new(1e-4),
/// #     initial_mean: Vector2::zeros(),
/// #     initial_covariance: Matrix2::identity(),
/// # };
/// # let design = Design {
/// #     gains: LAW,
/// #     model: &model,
/// #     actuator: Settings { default_input: DefaultInput::Zero, limits: None, safe: None },
/// #     measurement_buffer: 4,
/// #     acknowledgement_buffer: 4,
/// #     preview: None,
/// #     trigger: None,
/// #     arrives_at_once: 0.5,
/// #     merging: Merging::Single,
/// #     plausibility: &Plausibility::NONE,
/// #     grid: None,
/// # };
/// # slqg::controller_memory!(struct Memory: f32, 2, 1, 1; Sizes::of(2, 5, 1));
/// # let mut memory = Memory::new();
/// # let mut controller = Controller::new(design, Tick(0), memory.lend()).expect("a design that fits");
/// # let mut buffer = [0; 64];
///
/// // The law of the design is for a link on which three packets of four arrive within a cycle, half of all at once.
/// const BASIS: Basis<'static, f32> = Basis {
///     state_cost: &[1.0, 0.0, 0.0, 0.1],
///     input_cost: &[0.1],
///     survival: &[0.5, 0.25],
///     default_input: DefaultInput::Zero,
/// };
/// let mut memory = [0.0; tuner_len(&BASIS, 2, 1)];
/// let mut tuner = Tuner::<f32, 2, 1>::new(&design, BASIS, Parameters::DEFAULT, &mut memory).expect("it fits");
/// for cycle in 0..600_u32 {
///     if let Some(last) = cycle.checked_sub(1) {
///         // From now on all arrive at once.
///         controller.acknowledged(&Acknowledgement::of(Tick(last), Age::Steps(0))).expect("it was sent");
///     }
///     tuner.observe(&controller);
///     match tuner.law() {
///         Some(law) => controller.cycle_under(&law, &mut buffer).expect("it fits"),
///         None => controller.cycle(&mut buffer).expect("there is room"),
///     };
///     tuner.slice();
/// }
/// assert!(tuner.law().expect("the link is another, and solved for").arrives_at_once > 0.9);
/// ```
#[derive(Debug)]
pub struct Tuner<'m, T, const NX: usize, const NU: usize> {
    parameters: Parameters,
    delays: DelayEstimate<'m, T>,
    /// Its link is the one being solved for; while it is idle, the last one that was.
    solver: Solver<'m, T, NX, NU>,
    bank: Bank<'m, T, NX, NU>,
    /// Survival function of the link that the law in force is for.
    in_force: &'m mut [T],
    /// Room for that of a link to be solved for.
    survival: &'m mut [T],
    /// Most cycles ago that an acknowledgement may tell of: what is not known by then never will be.
    acknowledgement_buffer: u32,
    /// The cycle observed last.
    observed: Option<Tick>,
    /// Cycles until the next look at the distance.
    until_look: u32,
    /// Cycles until the estimate has forgotten what was before the last change.
    unsettled: u32,
    counts: Counts,
}

/// Numbers that a [`Tuner`] is lent as memory, for sequences of this length of a plant of these dimensions.
pub const fn tuner_len<T>(basis: &Basis<'_, T>, states: usize, inputs: usize) -> usize {
    let length = basis.survival.len();
    let shape = Shape { length, states, inputs, default_input: basis.default_input };
    let kept = delays::memory_len(length) + 2 * length + bank::memory_len(&shape);
    workspace_len(&basis.dimensions(states, inputs)) + kept
}

impl<'m, T: Scalar, const NX: usize, const NU: usize> Tuner<'m, T, NX, NU> {
    /// A tuner for a controller of `design`, whose law is for `basis`. `memory` needs [`tuner_len`] numbers.
    ///
    /// # Errors
    /// If the design has tables that would not follow the link, or something does not fit.
    pub fn new<const NY: usize>(
        design: &Design<'_, T, NX, NU, NY>,
        basis: Basis<'m, T>,
        parameters: Parameters,
        memory: &'m mut [T],
    ) -> Result<Self, InvalidTuner> {
        if design.preview.is_some() {
            return Err(InvalidTuner::Preview);
        }
        if design.trigger.is_some() {
            return Err(InvalidTuner::Trigger);
        }
        let (length, default_input) = (design.gains.length(), design.gains.default_input());
        if basis.survival.len() != length || basis.default_input != default_input {
            return Err(InvalidTuner::Basis);
        }
        if parameters.memory == 0 {
            return Err(InvalidTuner::Parameters);
        }
        if memory.len() < tuner_len(&basis, NX, NU) {
            return Err(InvalidTuner::Problem(InvalidProblem::Workspace));
        }
        let (of_solver, rest) = memory.split_at_mut(workspace_len(&basis.dimensions(NX, NU)));
        let (of_delays, rest) = rest.split_at_mut(delays::memory_len(length));
        let (in_force, rest) = rest.split_at_mut(length);
        let (survival, of_bank) = rest.split_at_mut(length);
        let solver = Solver::new(design.model, basis, parameters.most_steps, of_solver)
            .map_err(InvalidTuner::Problem)?;
        in_force.copy_from_slice(basis.survival);
        let number = |value: u32| T::nearest(f64::from(value));
        let (prior, fades) = (number(parameters.prior_packets), number(parameters.memory));
        Ok(Self {
            delays: DelayEstimate::new(basis.survival, prior, fades, of_delays).ok_or(InvalidTuner::Basis)?,
            bank: Bank::new(length, default_input, of_bank).ok_or(InvalidTuner::Basis)?,
            solver,
            in_force,
            survival,
            // Even an instant one tells of the cycle before.
            acknowledgement_buffer: u32::try_from(design.acknowledgement_buffer.max(1)).unwrap_or(u32::MAX),
            observed: None,
            until_look: 0,
            unsettled: 0,
            counts: Counts::default(),
            parameters,
        })
    }

    /// Takes what has become known of the link, between the last frame of a cycle and the controller's cycle.
    ///
    /// A cycle is looked at when acknowledgements can tell no more of it, so each counts once, in order, and it makes no
    /// difference which of them came when.
    pub fn observe<const NY: usize>(&mut self, controller: &Controller<'_, T, NX, NU, NY>) {
        let now = controller.tick();
        if self.observed.replace(now) == Some(now) {
            return;
        }
        let cycle = now - self.acknowledgement_buffer;
        let sent = |ago: usize| u32::try_from(ago).is_ok_and(|ago| controller.has_sent(cycle - ago));
        self.delays.told(controller.acknowledged_age(cycle), sent);
        self.until_look = self.until_look.saturating_sub(1);
        self.unsettled = self.unsettled.saturating_sub(1);
    }

    /// Whether gains are being computed: the next [`Tuner::slice`] has something to do.
    pub fn is_solving(&self) -> bool {
        !self.solver.is_idle()
    }

    /// Does one slice of what there is to do: after the frame, at least once a cycle, and while [`Tuner::is_solving`] as
    /// often as there is time. Most of the time it does nothing.
    pub fn slice(&mut self) -> Option<Event<T>> {
        if self.solver.is_idle() {
            return self.look();
        }
        count(&mut self.counts.slices);
        let outcome = match self.solver.slice() {
            Progress::Idle | Progress::Working => return None,
            Progress::Solved(solved) => self.switch().map(|()| solved).map_err(Kept::Law),
            Progress::Unsolved(why) => Err(Kept::Unsolved(why)),
        };
        Some(match outcome {
            Ok(solved) => {
                count(&mut self.counts.switched);
                Event::Switched(solved)
            }
            Err(why) => {
                count(&mut self.counts.kept);
                // Nothing better is to be expected before there is something new to go by.
                self.until_look = self.parameters.memory;
                Event::Kept(why)
            }
        })
    }

    /// Begins to solve if the link has changed by more than chance explains.
    fn look(&mut self) -> Option<Event<T>> {
        if self.until_look > 0 {
            return None;
        }
        self.until_look = (self.parameters.memory / LOOKS).max(1);
        let length = self.solver.survival().len();
        let threshold = threshold(length, T::nearest(f64::from(self.parameters.caution)));
        let is_another = self.delays.renew(threshold);
        let distance = self.delays.distance(self.in_force);
        let has_changed = distance > threshold;
        if is_another || has_changed {
            self.unsettled = self.parameters.memory.saturating_mul(SETTLED);
        }
        // While the estimate still forgets what was before, the law follows it closely.
        if !has_changed && (self.unsettled == 0 || distance <= T::nearest(length as f64)) {
            return None;
        }
        self.delays.fill_survival(self.survival);
        self.solver.begin(self.survival);
        count(&mut self.counts.started);
        Some(Event::Started { distance })
    }

    fn switch(&mut self) -> Result<(), InvalidLaw> {
        self.solver.write_law(self.bank.spare());
        let survival = self.solver.survival();
        self.bank.switch(T::one() - survival.first().copied().unwrap_or_else(T::one))?;
        self.in_force.copy_from_slice(survival);
        Ok(())
    }

    /// The law in force; `None` while that of the design is.
    pub fn law(&self) -> Option<Law<'_, T, NX, NU>> {
        self.bank.law()
    }

    /// Whether the law in force is as it was put in force, up to `numbers` more of it: as [`Bank::check_memory`].
    pub fn check_memory(&mut self, numbers: usize) -> bool {
        self.bank.check_memory(numbers)
    }

    /// What is known of the link.
    pub fn delays(&self) -> &DelayEstimate<'m, T> {
        &self.delays
    }

    /// `P(delay > d)`, `d = 0..N-1`, of the link that the law in force is for.
    pub fn survival_in_force(&self) -> &[T] {
        self.in_force
    }

    /// What was counted since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
