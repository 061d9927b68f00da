//! The verdict with its conditions, each with its figures.

use super::super::figure::{counted, figure};
use super::super::{LimitsShown, Report};
use super::{GOOD_GAINS, SENTENCE, line};
use crate::channels::ControlOnChannel;
use crate::paragraph::wrapped;
use crate::solve::Outcome;
use crate::stability::loses_sight;
use core::fmt::{self, Formatter};

impl Report {
    pub(super) fn stability(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let solution = &self.solution;
        let met = |met: bool| if met { "met" } else { "NOT MET" };
        writeln!(f, "\nStability: {}", self.verdict().name())?;
        let (dry, sight) = (self.dry_growth, self.sight_growth);
        let condition = |formula: &str, value: f64, bound: &str, is_met: bool| {
            let figures = format!("{formula} = {}", figure(value));
            format!("{figures:<48}{bound:<6}{}", met(is_met))
        };
        let (eigenvalue, rate) = ("|lambda_max(A)|^2", solution.mean_square_rate);
        line(f, "Theorem 3.4 b)", condition(&format!("(1 - Q(N-1)) {eigenvalue}"), dry, "<= 1", dry <= 1.0))?;
        let (sensor, buffer) =
            (&self.design.network.sensor_to_controller.delays, self.design.controller.measurement_buffer);
        let sees = !loses_sight(&self.design.plant, sensor, buffer);
        line(f, "Theorem 3.4 a)", condition(&format!("(1 - q_arr) {eigenvalue}"), sight, "< 1", sees))?;
        let converged = solution.outcome == Outcome::Converged;
        line(f, "Theorem 3.3 b)", condition("mean-square rate", rate, "< 1", converged))?;
        let how = match solution.outcome {
            Outcome::Converged => "converged",
            Outcome::Unstable => "diverges, shown",
            Outcome::Undecided => "stopped",
        };
        let residual = format!("{:.1e}", solution.residual);
        let mut after = counted(solution.iterations, "step");
        if solution.policy_iterations > 0 {
            after = format!("{after}, {} of them policy iterations", solution.policy_iterations);
        }
        line(f, "recursion", format!("{}: {how} after {after}, residual {residual}", self.method.name()))?;
        if converged {
            let error = solution.gain_error;
            let told = if error <= GOOD_GAINS { "of the largest" } else { "of the largest: MORE THAN 1e-8" };
            line(
                f,
                "gains",
                format!("good to {:<12}{told}, for the plant as given", format!("{error:.0e}")),
            )?;
        }
        let length = |n: Option<usize>| n.map_or("none".into(), |n| n.to_string());
        let (n_min, n_crit) = (length(self.n_min), length(self.n_crit));
        line(f, "N_min", format!("{n_min:<12}shortest length that Theorem 3.4 b) does not rule out"))?;
        line(f, "N_crit", format!("{n_crit:<12}shortest length that stabilises"))?;
        self.on_channels(f)?;
        self.within_limits(f)?;
        self.not_shown(f)?;
        let Some(certificate) = &self.certificate else { return Ok(()) };
        let (count, size) = (certificate.matrices().len(), certificate.matrices()[0].nrows());
        let matrices = format!("N+1 = {count} matrices of {size} x {size}");
        let bound = figure(certificate.rate_bound());
        line(f, "certificate", format!("verified by Cholesky, {matrices}: rate at most {bound}"))
    }

    /// What decides where packets depend on each other through a channel that is known.
    fn on_channels(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(ControlOnChannel::Rate { rate, modes }) = self.on_channel {
            let modes = counted(modes, "mode");
            let told = format!("mean-square rate of these gains, {modes} of age and channel: decides");
            line(f, "control on channel", format!("{:<12}{told}", figure(rate)))?;
        }
        let Some(channel) = self.estimation.channel else { return Ok(()) };
        let growth =
            format!("{:<12}growth of the squared error over losses in a row", figure(channel.loss_growth));
        let rate = channel.rate.map(|rate| format!("; the filter's rate is at most {}", figure(rate)));
        line(f, "sensor's channel", growth + &rate.unwrap_or_default())
    }

    /// Why inputs with limits do no harm.
    fn within_limits(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(shown) = self.limits_shown_by() else { return Ok(()) };
        let what = match shown {
            LimitsShown::Decay => {
                "second moments stay bounded, as the plant comes back by itself; rate and costs are those without"
            }
            LimitsShown::Drift => {
                "second moments stay bounded, if noise is gaussian: at a limit each input takes the integrator back; rate and \
                 costs are those without"
            }
        };
        let heads = std::iter::once("input limits").chain(std::iter::repeat(""));
        heads.zip(wrapped(what, SENTENCE)).try_for_each(|(head, text)| line(f, head, text))
    }

    /// Conditions that have no line of their own above.
    fn not_shown(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for condition in self.failed_conditions.iter().filter(|condition| !condition.is_numbered()) {
            let what = if condition.is_open() { "not shown" } else { "fails" };
            let sentence = condition.to_string();
            let heads = std::iter::once(what).chain(std::iter::repeat(""));
            heads.zip(wrapped(&sentence, SENTENCE)).try_for_each(|(head, text)| line(f, head, text))?;
        }
        Ok(())
    }
}
