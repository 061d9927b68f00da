//! The loop over links on which all packets meet one delay, or none arrives in time: a single matrix.
//!
//! The inputs to come, `v_m` in cycle `k + m` if nothing sent from `k` on arrived, are then known, and what is left of them
//! for the next cycle is linear: with `q_m` 1 where a packet is there `m` cycles after it was sent, and 0 before,
//!
//! ```text
//! u = q_0 U_0 + (1 - q_0) v_0        v_m <- q_(m+1) U_(m+1) + (1 - q_(m+1)) v_(m+1)        U = [L M] [loop's state; v]
//! ```
//!
//! The mean-square rate is the square of the matrix's spectral radius.

use crate::solve::rough_radius;
use nalgebra::DMatrix;
use slqg::DefaultInput;

/// Whether no delay is left to chance: `survival` of the link to the actuator, `N` values.
pub(super) fn is_certain(survival: &[f64]) -> bool {
    survival.iter().all(|&late| late == 0.0 || late == 1.0)
}

/// The rate of the loop whose state, of `size` numbers, moves by `step` (`size x size`) and `drive` (`size x nu`), under `gains`
/// (`(N nu) x (size + n_v nu)`).
pub(super) fn rate(
    step: &DMatrix<f64>,
    drive: &DMatrix<f64>,
    gains: &DMatrix<f64>,
    survival: &[f64],
    default_input: DefaultInput,
) -> f64 {
    let (size, inputs) = drive.shape();
    let in_flight = default_input.in_flight(survival.len());
    let total = size + in_flight * inputs;
    // Rows that give the input of a cycle in terms of [loop's state; v]: `m` cycles on, of what is sent or of what was.
    let sent = |m: usize| gains.rows(m.min(survival.len() - 1) * inputs, inputs).into_owned();
    let earlier = |m: usize| {
        let mut rows = DMatrix::zeros(inputs, total);
        let place = match default_input {
            DefaultInput::Zero => m,
            DefaultInput::Hold => m.min(in_flight - 1),
        };
        if place < in_flight {
            rows.columns_mut(size + place * inputs, inputs).fill_with_identity();
        }
        rows
    };
    let played = |m: usize| {
        let is_there = survival[m.min(survival.len() - 1)] == 0.0;
        let is_told = m < survival.len() || default_input == DefaultInput::Hold;
        if is_there && is_told { sent(m) } else { earlier(m) }
    };
    let mut matrix = DMatrix::zeros(total, total);
    matrix.view_mut((0, 0), (size, size)).copy_from(step);
    let mut state = matrix.rows_mut(0, size);
    state += drive * played(0);
    for m in 0..in_flight {
        matrix.rows_mut(size + m * inputs, inputs).copy_from(&played(m + 1));
    }
    rough_radius(&matrix).powi(2)
}

#[cfg(test)]
mod tests {
    use super::super::{Change, arrivals::Arrivals, loop_rate::LoopAsRun};
    use crate::design::{DelayDistribution, Design, Link};
    use crate::solve::{LoopProblem, Method, solve};
    use slqg::DefaultInput;

    const CRITICAL: &str = include_str!("../../../designs/critical.toml");

    /// The loop with the last of its packets a little uncertain.
    fn found(delays: &[f64], length: usize, default_input: DefaultInput, law_of: &[f64]) -> Vec<f64> {
        let link = |delays: &[f64]| Link::independent(DelayDistribution::new(delays.to_vec()).expect("one"));
        let mut design = Design::parse(CRITICAL, "critical.toml").expect("a design");
        design.controller.sequence_length = length;
        design.controller.default_input = default_input;
        design.plant.measurement_noise *= 1e6;
        design.network.controller_to_actuator = link(law_of);
        let law = solve(&LoopProblem::of(&design), Method::InFlight).law;
        design.network.controller_to_actuator = link(delays);
        let survival = LoopProblem::of(&design).survival();
        let arrivals = Arrivals::new(&link(&[0.0, 1.0]).delays, 11, 0);
        let run = LoopAsRun::with_filter(&design.plant, &law, &survival, &arrivals);
        [1.0, 0.7, 1.4].map(|factor| run.rate(Change::InputGain, factor)).to_vec()
    }

    #[test]
    fn a_delay_that_is_certain_gives_the_rate_that_a_nearly_certain_one_tends_to() {
        for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
            for (delay, length) in [(0, 1), (0, 3), (1, 2), (1, 4), (2, 3), (2, 5)] {
                let certain: Vec<f64> = (0..=delay).map(|d| if d == delay { 1.0 } else { 0.0 }).collect();
                let mut nearly = certain.clone();
                nearly[delay] -= 1e-9;
                let exact = found(&certain, length, default_input, &certain);
                let near = found(&nearly, length, default_input, &certain);
                for (exact, near) in exact.iter().zip(&near) {
                    let case = format!("{default_input:?}, delay {delay}, N = {length}");
                    assert!((exact - near).abs() < 1e-5 * exact.max(1.0), "{case}: {exact} {near}");
                }
            }
        }
    }
}
