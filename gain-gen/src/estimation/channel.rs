//! The error of the estimate where measurements meet a channel with states: whether its covariance stays bounded.
//!
//! What counts is which measurements arrive within the buffer, each with the probability `q_s` of the state `s` it is sent in; how
//! late they are only shifts the error by some cycles. Between the two bounds nothing is claimed.
//!
//! - **It does** if gains `K_s` exist with which an estimator that knows the channel's state shrinks its error in the mean square:
//!   `X_t -> sum_s p(s,t) ( (1 - q_t) A X_s A' + q_t (I - K_t C) A X_s A' (I - K_t C)' )` has a spectral radius below 1. The filter is
//!   at least as good as any other estimator, whatever it knows of the channel. The gains are sought with the modified Riccati
//!   equation for each state.
//! - **It does not** if losses in a row outlast the plant: the radius of `p(s,t) (1 - q_t)` times `|lambda_max(A)|^2` is above 1.

use super::EstimationVerdict;
use super::coordinates::Coordinates;
use crate::design::{MarkovLink, Plant, modes};
use crate::solve::spectral_radius;
use crate::stability::{Growth, growth, open_loop_modulus};
use nalgebra::{Cholesky, DMatrix};

/// Noise of a measurement beside its size: hardly any, as with much error only the error counts.
const NOISE: f64 = 1e-6;
/// Steps of the Riccati iteration after which gains are tried.
const TRIES: [usize; 7] = [4, 16, 64, 256, 512, 1024, 2048];
/// Multiplications of all steps together, at most.
const MOST_WORK: usize = 2_000_000_000;
/// Distance from 1 that is not rounding.
const CLEAR: f64 = 1e-7;

/// What a channel makes of the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnChannel {
    /// Whether the error's covariance stays bounded.
    pub verdict: EstimationVerdict,
    /// Growth of the squared error while measurements are lost in a row, per cycle.
    pub loss_growth: f64,
    /// Mean-square rate of the best estimator found that knows the channel; `None` where none was needed or sought.
    pub rate: Option<f64>,
}

/// What `channel` makes of measurements that count until they are `buffer` cycles late.
pub(super) fn on_channel(plant: &Plant, channel: &MarkovLink, buffer: usize) -> OnChannel {
    let states = channel.states();
    let arrives: Vec<f64> =
        (0..states).map(|state| channel.delays(state).map_or(0.0, |delays| delays.arrival(buffer))).collect();
    let lost =
        DMatrix::from_fn(states, states, |from, to| channel.transition(from, to) * (1.0 - arrives[to]));
    let in_a_row = modes::computed_eigenvalues(&lost)
        .map_or(1.0, |values| values.iter().map(|value| value.norm()).fold(0.0, f64::max));
    let loss_growth = in_a_row * open_loop_modulus(&plant.a).powi(2);
    let judged = |verdict, rate| OnChannel { verdict, loss_growth, rate };
    if growth(plant) == Growth::Decays {
        return judged(EstimationVerdict::Stable, None);
    }
    if loss_growth > 1.0 + CLEAR {
        return judged(EstimationVerdict::Unstable, None);
    }
    let Coordinates { a, c } = Coordinates::of(plant);
    let mut search = Search { a, c, channel, arrives, covariances: Vec::new() };
    let least = search.least_rate();
    let is_stable = least.is_some_and(|rate| rate < 1.0 - CLEAR);
    judged(if is_stable { EstimationVerdict::Stable } else { EstimationVerdict::Open }, least)
}

struct Search<'c> {
    /// In coordinates without units; rows of `c` have length 1.
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    channel: &'c MarkovLink,
    /// `q_s`.
    arrives: Vec<f64>,
    /// `E[e e' 1(state = s)]`, bounded from above.
    covariances: Vec<DMatrix<f64>>,
}

impl Search<'_> {
    /// The least rate found, the first below 1 if there is one.
    fn least_rate(&mut self) -> Option<f64> {
        let (size, states) = (self.a.nrows(), self.channel.states());
        let unit = DMatrix::<f64>::identity(size, size);
        self.covariances = self.channel.shares().iter().map(|&share| &unit * share).collect();
        let work = states * size.pow(3);
        let (mut steps, mut least) = (0, None::<f64>);
        for tried in TRIES.into_iter().filter(|steps| steps * work <= MOST_WORK) {
            while steps < tried {
                self.step();
                steps += 1;
            }
            let rate = self.rate();
            least = Some(least.map_or(rate, |least| least.min(rate)));
            if rate < 1.0 - CLEAR {
                break;
            }
        }
        least
    }

    /// `sum_s p(s,t) A X_s A'` for every `t`, with some noise.
    fn predicted(&self, noise: f64) -> Vec<DMatrix<f64>> {
        let moved: Vec<_> = self.covariances.iter().map(|x| &self.a * x * self.a.transpose()).collect();
        let size = self.a.nrows();
        let to = |(to, share): (usize, &f64)| {
            let mut sum = DMatrix::<f64>::identity(size, size) * (noise * share);
            for (from, moved) in moved.iter().enumerate() {
                sum += moved * self.channel.transition(from, to);
            }
            sum
        };
        self.channel.shares().iter().enumerate().map(to).collect()
    }

    /// `K` for the covariance `x` of a state with this share; `None`: no measurement tells anything.
    fn gain(&self, x: &DMatrix<f64>, share: f64) -> Option<DMatrix<f64>> {
        let seen = &self.c * x;
        let outputs = self.c.nrows();
        let noise = DMatrix::<f64>::identity(outputs, outputs) * (NOISE * share);
        Some(Cholesky::new(&seen * self.c.transpose() + noise)?.solve(&seen).transpose())
    }

    fn step(&mut self) {
        let shares = self.channel.shares();
        let corrected = |(state, x): (usize, DMatrix<f64>)| {
            let Some(gain) = self.gain(&x, shares[state]) else { return x };
            let corrected = &x - gain * (&self.c * &x) * self.arrives[state];
            (&corrected + corrected.transpose()) * 0.5
        };
        let next: Vec<_> = self.predicted(1.0).into_iter().enumerate().map(corrected).collect();
        // Where it grows, its size does not matter.
        let size: f64 = next.iter().map(DMatrix::trace).sum();
        let scale = if size > 1e100 { size.recip() } else { 1.0 };
        self.covariances = next.into_iter().map(|x| x * scale).collect();
    }

    /// The rate of the estimator with the gains for the present covariances.
    fn rate(&self) -> f64 {
        let (size, shares) = (self.a.nrows(), self.channel.shares());
        let predicted = self.predicted(1.0);
        let unit = DMatrix::<f64>::identity(size, size);
        let corrections: Vec<DMatrix<f64>> = predicted
            .iter()
            .enumerate()
            .map(|(state, x)| self.gain(x, shares[state]).map_or(unit.clone(), |gain| &unit - gain * &self.c))
            .collect();
        let square = size * size;
        let start = unit.as_slice().repeat(shares.len());
        spectral_radius(&start, [1, 4, 4], |from, to| {
            let moved: Vec<_> = from
                .chunks_exact(square)
                .map(|x| &self.a * DMatrix::from_column_slice(size, size, x) * self.a.transpose())
                .collect();
            for (state, out) in to.chunks_exact_mut(square).enumerate() {
                let mut sum = DMatrix::<f64>::zeros(size, size);
                for (from, moved) in moved.iter().enumerate() {
                    sum += moved * self.channel.transition(from, state);
                }
                let seen = &corrections[state] * &sum * corrections[state].transpose();
                let both = &sum * (1.0 - self.arrives[state]) + seen * self.arrives[state];
                out.copy_from_slice(((&both + both.transpose()) * 0.5).as_slice());
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;

    /// Two states that grow by 1.5 and fade by 0.5; both are measured.
    fn plant() -> Plant {
        let text = include_str!("../../../designs/critical.toml");
        Design::parse(text, "critical.toml").expect("a design").plant
    }

    fn bursts(to_bad: f64, to_good: f64) -> MarkovLink {
        MarkovLink::gilbert_elliott(to_bad, to_good, vec![1.0], vec![]).expect("a channel")
    }

    #[test]
    fn with_the_state_measured_how_long_bursts_last_alone_decides() {
        // 1.5^2 (1 - to_good) is 1 at to_good = 5 / 9, however rare bursts are.
        for to_bad in [0.01, 0.5] {
            let at = |to_good: f64| on_channel(&plant(), &bursts(to_bad, to_good), 0).verdict;
            assert_eq!(at(0.56), EstimationVerdict::Stable, "{to_bad}");
            assert_eq!(at(0.55), EstimationVerdict::Unstable, "{to_bad}");
        }
    }

    #[test]
    fn losses_that_alternate_with_arrivals_leave_the_error_bounded() {
        // One in two arrives, fewer than independent packets need; never two in a row are lost.
        let found = on_channel(&plant(), &bursts(1.0, 1.0), 0);
        assert_eq!((found.verdict, found.loss_growth), (EstimationVerdict::Stable, 0.0));
    }
}
