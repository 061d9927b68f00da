//! The law that would be optimal if the filter erred independently of all that it knows: a Riccati equation. THEORY 14.
//!
//! ```text
//! L = - price^# (B' Y F P) ,     Y = stage + F' Y F          P: x = xhat, v = vbar, no error
//! ```
//!
//! It is unique, and whatever noise does, found by plain steps from a cost-to-go of zero. What the filter knows and what it errs by
//! are dependent after all, as inputs that are not what was expected act on both; that costs little.

use super::{jump::Jump, steady::Steady};
use nalgebra::DMatrix;

/// Plain steps before the law must stabilise.
const STEPS: usize = 400;
/// Steps after which it is looked at whether it does, the first time; later after twice as many each.
const FIRST_LOOK: usize = 25;
/// Steps from the exact cost of the law before.
const POLICY_STEPS: usize = 60;
/// Change of the law, relative to its largest number, that counts as none.
const SAME: f64 = 1e-11;

/// The law, and the loop with it; `None` if it does not stabilise. It is near `law` if that is given.
pub(super) fn certain(jump: &Jump<'_>, law: Option<&DMatrix<f64>>) -> Option<(DMatrix<f64>, Steady)> {
    let near = law.and_then(|law| Some((law.clone(), jump.steady(law, None)?)));
    let (mut law, mut steady) = match near {
        Some(found) => found,
        None => begin(jump)?,
    };
    for _ in 0..POLICY_STEPS {
        let better = jump.certain_law(&steady.cost_to_go);
        let change = (&better - &law).amax() / better.amax().max(f64::MIN_POSITIVE);
        // Of a loop that forgets slowly a step may lead too far; half of it is enough, or what there is must do.
        let found = jump.steady(&better, Some(&steady)).map(|found| (better.clone(), found));
        let found = found.or_else(|| {
            let half = (&better + &law) * 0.5;
            Some((half.clone(), jump.steady(&half, Some(&steady))?))
        });
        let Some(found) = found else { break };
        (law, steady) = found;
        if change <= SAME {
            break;
        }
    }
    Some((law, steady))
}

/// A law that stabilises, by steps from a cost-to-go of zero: the optimum of tasks that last longer and longer.
fn begin(jump: &Jump<'_>) -> Option<(DMatrix<f64>, Steady)> {
    let mut cost = jump.weights();
    let mut look = FIRST_LOOK;
    for step in 1..=STEPS {
        let law = jump.certain_law(&cost);
        let closed = jump.closed(&law);
        if step == look || step == STEPS {
            if let Some(steady) = jump.steady(&law, None) {
                return Some((law, steady));
            }
            look *= 2;
        }
        cost = closed.stage().0 + closed.cost_before(&cost);
        if !cost.iter().all(|entry| entry.is_finite()) {
            return None;
        }
    }
    None
}
