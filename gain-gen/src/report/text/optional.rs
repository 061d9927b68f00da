//! Sections that only some reports have: tracking, event trigger, a channel, a task, warnings.

use super::super::Report;
use super::super::figure::{counted, figure, ordinal, percent};
use super::line;
use crate::design::{Goal, SetPoint};
use crate::solve::Knowledge;
use core::fmt::{self, Formatter};
use nalgebra::DVector;
use slqg::DefaultInput;

impl Report {
    pub(super) fn warnings(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if self.warnings.is_empty() {
            return Ok(());
        }
        writeln!(f, "\nWarnings")?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "  {}", warning.within_file()))
    }

    pub(super) fn unacknowledged(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(found) = &self.unacknowledged else { return Ok(()) };
        writeln!(f, "\nWithout acknowledgements, estimation included")?;
        let rate = figure(found.rate);
        line(f, "mean-square rate", format!("{rate:<12}per step: second moments shrink by this factor"))?;
        let how = match (found.is_exact, found.is_least) {
            (true, true) => "per step, exact; no law in xhat and vbar does better",
            (true, false) => "per step, exact; nearly the least",
            (false, true) => "per step, measurements as below; no law in xhat and vbar does better",
            (false, false) => "per step, measurements as below; nearly the least",
        };
        line(f, "long-run cost", format!("{:<12}{how}", figure(found.cost)))?;
        if !found.is_exact {
            let heard = "probability to hear of all measurements so far, in each step";
            line(f, "measurements", format!("{:<12}{heard}", figure(found.hears)))?;
        }
        for (input, variance) in found.input_covariance.diagonal().iter().enumerate() {
            let what = format!("input {}", input + 1);
            let deviation = figure(variance.max(0.0).sqrt());
            line(
                f,
                &what,
                format!("{deviation:<12}standard deviation of what is applied from what is expected"),
            )?;
        }
        Ok(())
    }

    pub(super) fn tracking(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (Some(tracking), Some(preview)) = (&self.design.tracking, &self.preview) else { return Ok(()) };
        let outputs = counted(tracking.outputs(), "output");
        let gains = match preview {
            Ok(gains) => gains,
            Err(too_long) => {
                writeln!(f, "\nTracking: {outputs}")?;
                return line(f, "preview", format!("none: {too_long}"));
            }
        };
        match &tracking.goal {
            Goal::Trajectory(trajectory) => {
                let given =
                    if trajectory.reference.is_some() { "of the design" } else { "given at run time" };
                writeln!(f, "\nTracking: {outputs}, reference {given}")?;
                line(f, "preview", format!("{} ahead", self.steps(gains.samples as f64)))?;
                line(
                    f,
                    "beyond the preview",
                    format!(
                        "{:<12}of the gains are for later samples, taken to equal the last",
                        percent(gains.tail)
                    ),
                )
            }
            Goal::SetPoint(set_point) => {
                writeln!(f, "\nTracking: {outputs} at the set point {}", spelled(&set_point.value))?;
                self.set_point(f, set_point, gains.standing_cost.unwrap_or(0.0))
            }
        }
    }

    fn set_point(&self, f: &mut Formatter<'_>, set_point: &SetPoint, standing_cost: f64) -> fmt::Result {
        let input = &set_point.input * &set_point.value;
        line(f, "input that holds it", spelled(&input))?;
        let (cost, on_top) = (figure(standing_cost), "per step, on top of the long-run cost");
        line(f, "standing cost", format!("{cost:<12}{on_top}"))?;
        let runs_dry = self.design.controller.default_input == DefaultInput::Zero;
        if runs_dry && standing_cost > 0.0 && input.amax() > 0.0 {
            line(
                f,
                "",
                "as zero input is applied when the buffer runs dry; with default input hold it is 0",
            )?;
        }
        Ok(())
    }

    pub(super) fn channel(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(channel) = &self.channel else { return Ok(()) };
        let modes = counted(channel.correlated.chain.ages.len(), "mode");
        writeln!(f, "\nOn the channel, {modes} of age and channel state")?;
        line(f, "gains that know", "mean-square rate   cost per step")?;
        for knowledge in Knowledge::ALL {
            let told = match channel.correlated.with(knowledge) {
                None => "no gains stabilise the loop as this knowledge has it".into(),
                Some(design) => {
                    let cost = if design.control_cost.is_finite() {
                        figure(design.control_cost)
                    } else {
                        "unbounded".into()
                    };
                    format!("{:<19}{cost}", figure(design.mean_square_rate))
                }
            };
            let what = match knowledge {
                Knowledge::Average => "the average delays",
                Knowledge::Ages => "how ages follow",
                Knowledge::Channel => "the channel's state",
            };
            line(f, what, told)?;
        }
        Ok(())
    }

    pub(super) fn event(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(event) = self.design.event.filter(|_| self.trigger.is_some() || self.scheduled.is_some())
        else {
            return Ok(());
        };
        writeln!(f, "\nEvent trigger")?;
        line(
            f,
            "send cost",
            format!("{:<12}per packet, in units of the stage cost", figure(event.send_cost)),
        )?;
        // Of a reference that moves the cost depends on the reference.
        let standing = match &self.preview {
            None => Some(0.0),
            Some(gains) => gains.as_ref().ok().and_then(|gains| gains.standing_cost),
        };
        if let Some(schedules) = &self.schedules {
            let cheapest = schedules.cheapest_cost();
            let (total, every) = (figure(cheapest.total()), ordinal(cheapest.period));
            line(
                f,
                "best schedule",
                format!("a packet in every {every} step: {total} per step, packets and estimation included"),
            )?;
        }
        let Some(standing) = standing else { return Ok(()) };
        let (period, of_what) = match &self.scheduled {
            Some(found) => {
                (found.schedule.period, format!("a packet in every {} step", ordinal(found.schedule.period)))
            }
            None => (1, "sending always".into()),
        };
        let most = figure(self.estimation.cost_upper + standing + event.send_cost / period as f64);
        line(
            f,
            "long-run cost",
            format!("at most {most} per step, packets and estimation included: that of {of_what}"),
        )
    }

    pub(super) fn task(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (Some(task), Some(cost)) = (&self.task, self.task_cost()) else { return Ok(()) };
        let cycles = task.laws.len();
        writeln!(f, "\nTask of {}", self.steps(cycles as f64))?;
        let known = if task.tracked.is_some() { ", reference known ahead" } else { "" };
        line(f, "expected cost", format!("{:<12}of the whole task, state known{known}", figure(cost)))?;
        if let Some(surprise) = self.surprise_cost() {
            let unaware = "more if in each step the reference is taken to stay as it is";
            line(f, "not known ahead", format!("{:<12}{unaware}", figure(surprise)))?;
        }
        let gains: usize = task.laws.iter().map(|law| law.lx.len() + law.m.len()).sum();
        let (tables, numbers) = match &task.tracked {
            None => ("Lx, M", gains),
            Some(tracked) => {
                ("Lx, M, Uff", gains + tracked.feedforward.iter().map(|inputs| inputs.len()).sum::<usize>())
            }
        };
        line(f, tables, format!("{} for all cycles together", counted(numbers, "number")))
    }
}

fn spelled(values: &DVector<f64>) -> String {
    format!("[{}]", values.iter().map(|&value| figure(value)).collect::<Vec<_>>().join(", "))
}
