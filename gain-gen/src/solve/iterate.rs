//! When a value iteration has converged, and when it never will; the same rules for both solvers.
//!
//! Convergence is decided by the residual of the fixed-point equation, instability by the mean-square rate of
//! the gains at hand (THEORY 5) once the cost-to-go has outgrown every stage cost. The number of iterations
//! decides nothing: where it runs out the outcome says so.

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
    fn rate(&self) -> f64;
}

/// Where an iteration got to.
pub(super) struct Ending {
    pub(super) outcome: Outcome,
    pub(super) iterations: usize,
    pub(super) residual: f64,
    pub(super) mean_square_rate: f64,
}

/// Relative residual at which the fixed point counts as reached.
const RESIDUAL: f64 = 1e-13;
/// Residual that counts when rounding lets it fall no further.
const ROUNDING_FLOOR: f64 = 1e-11;
/// Iterations without a smaller residual after which it is at its floor.
const PATIENCE: usize = 256;
/// Growth over the stage cost beyond which stage costs no longer influence the gains.
const OUTGROWN: f64 = 1e14;
/// The same where a necessary condition for stability is already known to fail.
const OUTGROWN_WHEN_DOOMED: f64 = 1e6;
/// First iteration at which the rate is looked at; then at every doubling.
const FIRST_LOOK: usize = 16;
/// Allowed iterations: at a rate of 0.99999 convergence takes about three million.
const MOST: usize = 1 << 22;

/// Steps until an outcome is known. `scale` is that of the stage cost; `doomed` says that a necessary condition for
/// stability is known to fail.
pub(super) fn iterate(recursion: &mut impl Recursion, scale: f64, doomed: bool) -> Ending {
    let outgrown = scale * if doomed { OUTGROWN_WHEN_DOOMED } else { OUTGROWN };
    let mut stable = false;
    let mut look = FIRST_LOOK;
    let mut smallest = f64::INFINITY;
    let mut stalled = 0;
    for iterations in 1..=MOST {
        let residual = recursion.step();
        if residual < smallest {
            smallest = residual;
            stalled = 0;
        } else {
            stalled += 1;
        }
        let end = |outcome, mean_square_rate| Ending { outcome, iterations, residual, mean_square_rate };
        if residual <= RESIDUAL || (residual <= ROUNDING_FLOOR && stalled >= PATIENCE) {
            let rate = recursion.rate();
            // A cost that does not see an unstable mode converges and stabilises nothing.
            return end(if rate < 1.0 { Outcome::Converged } else { Outcome::Unstable }, rate);
        }
        if !recursion.size().is_finite() {
            return end(Outcome::Unstable, f64::INFINITY);
        }
        if !stable && iterations == look {
            let rate = recursion.rate();
            stable = rate < 1.0;
            if !stable && recursion.size() > outgrown {
                return end(Outcome::Unstable, rate);
            }
            // A doomed iteration need not run for twice as long as it takes to show it.
            look += if doomed { FIRST_LOOK } else { look };
        }
        if iterations == MOST {
            return end(Outcome::Undecided, recursion.rate());
        }
    }
    unreachable!("the loop above returns in its last turn")
}
