//! When an iteration has converged, and when it never will; the same rules for both solvers.
//!
//! Value iteration converges as fast as the closed loop forgets. Where that is slow, policy iteration takes over as soon
//! as the gains at hand stabilise: the exact cost of those gains, then one step from there, converges quadratically.
//!
//! Convergence is decided by the residual of the fixed-point equation, instability by the mean-square rate of the gains
//! at hand (THEORY 5) once the cost-to-go has outgrown every stage cost. The number of iterations decides nothing:
//! where it runs out the outcome says so.

/// How an iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The residual is at rounding level and the gains stabilise the loop.
    Converged,
    /// No gains stabilise the loop: the cost-to-go grows without bound.
    Unstable,
    /// Neither shown within the iterations allowed: the rate is too close to 1.
    Undecided,
}

/// A backward recursion that can be stepped and asked how its gains do.
pub(super) trait Recursion {
    /// One step; returns the relative change of the cost-to-go.
    fn step(&mut self) -> f64;
    /// Trace of the state's cost-to-go.
    fn size(&self) -> f64;
    /// Mean-square rate of the closed loop with the gains of the last step.
    fn rate(&mut self) -> f64;
    /// The same where the cost-to-go has converged; anything below 1 if nobody asks how fast the loop forgets.
    fn settled_rate(&mut self) -> f64 {
        self.rate()
    }
    /// Replaces the cost-to-go by that of keeping the gains of the last step for ever, to `accuracy` of itself; false if
    /// it cannot.
    fn evaluate(&mut self, accuracy: f64) -> bool;
    /// Keeps the cost-to-go as it is now: what changes of it from here on shows what the loop forgets slowly, which is
    /// what [`Recursion::rate`] looks for.
    fn remember(&mut self) {}
    /// Takes plain steps from here on.
    fn walk(&mut self) {}
    /// The gains of the last step, in any order.
    fn gains(&mut self) -> Vec<f64>;
    /// Whether the cost-to-go has left the units it was begun in so far behind that others serve better.
    fn is_out_of_scale(&self) -> bool {
        false
    }
    /// Takes gains that are known to stabilise the loop instead of those of the last step; false if none are known.
    fn fall_back(&mut self) -> bool;
    /// Steps after which what is in flight is forgotten: so many make its part of the cost-to-go as accurate as the
    /// state's, however small it is.
    fn memory(&self) -> usize;
}

/// Where an iteration got to.
pub(super) struct Ending {
    pub(super) outcome: Outcome,
    pub(super) iterations: usize,
    pub(super) policy_iterations: usize,
    pub(super) residual: f64,
    pub(super) mean_square_rate: f64,
    /// How far the gains may be from those of the fixed point, relative to the largest; infinite unless converged.
    pub(super) gain_error: f64,
}

/// Relative residual at which the fixed point counts as reached.
const RESIDUAL: f64 = 1e-13;
/// Part of the cost that may still be missing where the residual is that small; what is more is found in one piece.
const TO_COME: f64 = 1e-12;
/// Times that this is done.
const MOST_POLISHED: usize = 2;
/// Rate from which the error of the gains is measured by what is still to come in one piece, not estimated.
const SLOW: f64 = 0.999;
/// Distance of the rate from 1 that rounding does not resolve.
const UNRESOLVED: f64 = 1e-12;
/// Iterations between looks at the scale of the cost-to-go.
const SCALE_LOOK: usize = 16;
/// Iterations after which a rate that is not told from 1 ends them.
const ON_THE_LIMIT: usize = 256;
/// Change of the gains, relative to the largest, at which they stand still.
const STILL: f64 = 1e-13;
/// The same where rounding moves them: one that grows again is of that kind.
const CALM: f64 = 1e-10;
/// Rounding of a step, relative to the gains.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Residual that counts when rounding lets it fall no further.
const ROUNDING_FLOOR: f64 = 1e-11;
/// Iterations without a smaller residual after which it is at its floor.
const PATIENCE: usize = 64;
/// Growth over the stage cost beyond which stage costs no longer influence the gains.
const OUTGROWN: f64 = 1e14;
/// The same where a necessary condition for stability is already known to fail.
const OUTGROWN_WHEN_DOOMED: f64 = 1e6;
/// First iteration at which it is foreseen how many are to come; then at every doubling.
const FIRST_LOOK: usize = 16;
/// Iterations between looks where a necessary condition is known to fail.
const LOOK_WHEN_DOOMED: usize = 16;
/// Value steps still needed that make it worth while to look at the rate, and policy iteration if that is below 1.
const WORTH_WHILE: f64 = 100.0;
/// Policy iterations allowed; they converge quadratically or not at all.
const MOST_POLICY: usize = 30;
/// Policy iterations that may gain nothing.
const SETBACKS: usize = 2;
/// Accuracy of the cost of given gains, relative to the cost.
const EVALUATION: f64 = 1e-14;
/// The same, relative to the residual at hand.
const FORCING: f64 = 1e-4;
/// Residual at which the cost-to-go is kept: what changes after it is what the loop forgets slowly, and still far above rounding.
const MEMORABLE: f64 = 1e-6;
/// Iterations allowed.
const MOST: usize = 1 << 22;

/// Steps until an outcome is known. `scale` is that of the stage cost; `doomed` says that a necessary condition for
/// stability is known to fail.
pub(super) fn iterate(recursion: &mut impl Recursion, scale: f64, doomed: bool) -> Ending {
    let outgrown = scale * if doomed { OUTGROWN_WHEN_DOOMED } else { OUTGROWN };
    let mut look = if doomed { LOOK_WHEN_DOOMED } else { FIRST_LOOK };
    let mut stable = false;
    let mut policy = Policy {
        active: false,
        iterations: 0,
        smallest_residual: f64::INFINITY,
        size: f64::INFINITY,
        setbacks: 0,
        steps_since: 0,
    };
    let mut smallest = f64::INFINITY;
    let mut stalled = 0;
    let mut polished = 0;
    // The residual halfway to the next look.
    let mut halfway = f64::INFINITY;
    let mut ending = Ending {
        outcome: Outcome::Undecided,
        iterations: 0,
        policy_iterations: 0,
        residual: f64::INFINITY,
        mean_square_rate: f64::INFINITY,
        gain_error: f64::INFINITY,
    };
    while ending.iterations < MOST {
        policy.improve(recursion, ending.residual);
        let residual = recursion.step();
        ending.iterations += 1;
        ending.policy_iterations = policy.iterations;
        ending.residual = residual;
        if residual <= MEMORABLE && ending.iterations > 1 && smallest > MEMORABLE {
            recursion.remember();
        }
        stalled = if residual < smallest { 0 } else { stalled + 1 };
        smallest = smallest.min(residual);
        let at_floor = stalled >= PATIENCE || policy.is_exhausted(recursion.memory());
        if residual <= RESIDUAL || (residual <= ROUNDING_FLOOR && at_floor) {
            let gains = settle_gains(recursion, &mut ending);
            ending.mean_square_rate = resolved(recursion.settled_rate());
            // A cost that does not see an unstable mode converges and stabilises nothing.
            let stabilised = ending.mean_square_rate < 1.0;
            let to_come = residual / (1.0 - ending.mean_square_rate);
            if stabilised && to_come > TO_COME && polished < MOST_POLISHED && recursion.evaluate(EVALUATION) {
                polished += 1;
                continue;
            }
            ending.outcome = match ending.mean_square_rate {
                rate if rate < 1.0 => Outcome::Converged,
                1.0 => Outcome::Undecided,
                _ => Outcome::Unstable,
            };
            if stabilised {
                ending.gain_error = gain_error(recursion, gains, ending.mean_square_rate);
            }
            return ending;
        }
        if !recursion.size().is_finite() {
            ending.outcome = Outcome::Unstable;
            return ending;
        }
        if ending.iterations.is_multiple_of(SCALE_LOOK) && recursion.is_out_of_scale() {
            return ending;
        }
        let due = look.max(recursion.memory());
        if ending.iterations == due / 2 {
            halfway = residual;
            recursion.remember();
        }
        if !stable && ending.iterations == due {
            if doomed || value_steps_to_come(residual, halfway, due - due / 2) > WORTH_WHILE {
                let rate = resolved(recursion.rate());
                stable = rate < 1.0 || recursion.fall_back();
                policy.active = stable;
                if rate == 1.0 && due >= ON_THE_LIMIT {
                    ending.mean_square_rate = rate;
                    return ending;
                }
                if !stable && recursion.size() > outgrown {
                    ending.outcome = Outcome::Unstable;
                    ending.mean_square_rate = rate;
                    return ending;
                }
            }
            // A doomed iteration need not run for twice as long as it takes to show it.
            look = due + if doomed { LOOK_WHEN_DOOMED } else { due };
        }
    }
    ending.mean_square_rate = resolved(recursion.rate());
    ending
}

/// The rate, exactly 1 where rounding does not tell it from 1.
fn resolved(rate: f64) -> f64 {
    if (rate - 1.0).abs() <= UNRESOLVED { 1.0 } else { rate }
}

/// Value steps until the residual has fallen far enough, if it goes on as it did over the last `steps` of them.
pub(super) fn value_steps_to_come(residual: f64, before: f64, steps: usize) -> f64 {
    let shrinks = (residual / before).ln() / steps as f64;
    if before.is_finite() && shrinks < 0.0 { (RESIDUAL / residual).ln() / shrinks } else { f64::INFINITY }
}

/// Steps on until the gains stand still too: those of inputs that are hardly ever applied hardly show in the cost. Returns
/// what is still to come of their change, relative to the largest.
fn settle_gains(recursion: &mut impl Recursion, ending: &mut Ending) -> f64 {
    recursion.walk();
    let mut gains = recursion.gains();
    let mut before = f64::INFINITY;
    for _ in 0..=recursion.memory() {
        ending.residual = recursion.step();
        ending.iterations += 1;
        let change = change_of(&mut gains, recursion.gains());
        // Falling changes go on falling as they did; those of rounding do not add up.
        let shrinks = change / before;
        if change <= STILL || (change <= CALM && shrinks >= 1.0) {
            return if before.is_finite() && shrinks < 0.5 {
                change * shrinks / (1.0 - shrinks)
            } else {
                change
            };
        }
        before = change;
    }
    before
}

/// Takes the `new` gains in place of the old ones, and returns the largest difference relative to the largest gain.
pub(super) fn change_of(gains: &mut Vec<f64>, new: Vec<f64>) -> f64 {
    let largest = new.iter().fold(0.0_f64, |largest, gain| largest.max(gain.abs()));
    let change =
        new.iter().zip(gains.iter()).fold(0.0_f64, |change, (new, old)| change.max((new - old).abs()));
    *gains = new;
    if largest > 0.0 { change / largest } else { 0.0 }
}

/// How far the gains may be off, of which `to_come` is known to be still to come: with what a step's rounding adds up to.
/// Where the loop forgets slowly, what is missing is found in one piece.
fn gain_error(recursion: &mut impl Recursion, to_come: f64, rate: f64) -> f64 {
    let mut gains = recursion.gains();
    let missing = if rate > SLOW && recursion.evaluate(EVALUATION) {
        recursion.step();
        change_of(&mut gains, recursion.gains())
    } else {
        to_come
    };
    missing.max(ROUNDING / (1.0 - rate))
}

/// Policy iteration: whether it is on, and how it gets along.
struct Policy {
    active: bool,
    iterations: usize,
    smallest_residual: f64,
    /// Cost-to-go before the last iteration.
    size: f64,
    /// Iterations that neither halved the residual nor took a hundredth off the cost.
    setbacks: usize,
    /// Value steps since it was last used.
    steps_since: usize,
}

impl Policy {
    /// Before a step from a cost-to-go with this residual: replaces it by the cost of its gains, while that helps.
    fn improve(&mut self, recursion: &mut impl Recursion, residual: f64) {
        // Far from the optimum the cost falls, near it the residual does, quadratically. Where neither happens the
        // rounding floor is reached. From there value iteration goes on, which is safe wherever it starts.
        let size = recursion.size();
        let helps = residual < 0.5 * self.smallest_residual || size < 0.99 * self.size;
        self.setbacks += usize::from(self.active && !helps);
        self.active &= self.iterations < MOST_POLICY && self.setbacks <= SETBACKS;
        self.steps_since += 1;
        if self.active {
            self.smallest_residual = self.smallest_residual.min(residual);
            self.size = size;
            // No more accurately than the next step will need it.
            self.active = recursion.evaluate((FORCING * residual).max(EVALUATION));
            self.iterations += usize::from(self.active);
            self.steps_since = 0;
        }
    }

    /// Whether it has done what it can and value iteration has polished the result. Where the loop forgets slowly, more
    /// value steps would gain a rounding error each.
    fn is_exhausted(&self, polish: usize) -> bool {
        self.iterations > 0 && !self.active && self.steps_since > polish
    }
}
