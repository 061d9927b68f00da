//! Controllers with one law that is optimal for some link: the design's own, or one that the designer believed in.

use super::{Contender, ContenderError, Kind, Sending, TuningBasis};
use gain_gen::{
    design::{Base, DelayDistribution, Design, Event, Link, Rule},
    estimation::Estimation,
    solve::{
        LoopProblem, Method, PreviewGains, Scheduled, Solution, scheduled, solve, trigger_tables,
        unacknowledged,
    },
};
use slqg::{DefaultInput, estimator::Merging};

/// The same loop without a network: LQG as it is taught.
pub(super) fn without_network(problem: &LoopProblem) -> LoopProblem {
    let default_input = DefaultInput::Zero;
    LoopProblem { link: Link::perfect().delays, length: 1, default_input, ..problem.clone() }
}

/// A link that delays nothing and loses as many packets as this one makes useless: those that never arrive, and those later
/// than `N-1` cycles, of which no input is left to apply. `None` if that is every packet.
fn without_delays(problem: &LoopProblem) -> Option<DelayDistribution> {
    DelayDistribution::new(vec![problem.link.arrival(problem.length - 1)]).ok()
}

impl Contender {
    /// Gives it the steady-state law of the link it was designed for.
    pub(super) fn make_steady(
        &mut self,
        mut problem: LoopProblem,
        design: &Design,
        steps: usize,
    ) -> Result<(), ContenderError> {
        match self.kind {
            Kind::Lqg => {
                let default_input = problem.default_input;
                problem = LoopProblem { default_input, ..without_network(&problem) };
            }
            Kind::HoldLast => {
                problem = LoopProblem { default_input: DefaultInput::Hold, ..without_network(&problem) };
            }
            Kind::LqgLoss => {
                problem.link = without_delays(&problem).ok_or_else(|| self.unstable())?;
                // It holds a packet that is late for lost, and so does its estimator where nothing acknowledges.
                self.arrives_at_once = problem.arrives_at_once();
            }
            _ => {}
        }
        let mut solution = solve(&problem, Method::InFlight);
        if self.kind == Kind::Slqg {
            solution = solution.for_acknowledgements(design, &problem);
        }
        if !solution.is_stabilising() {
            return Err(self.unstable());
        }
        self.must_see(design)?;
        if let Some(found) = self.scheduled(&problem, design, &solution)? {
            let sending = match found.trigger {
                Some(tables) => Sending::WorthOverSchedule(tables),
                None => Sending::Every(found.schedule.period),
            };
            self.trigger = design.event.map(|event| (event.send_cost, sending));
            self.laws = vec![found.schedule.law];
            return Ok(());
        }
        self.weigh(&problem, design, &solution)?;
        self.learn_reference(design, steps)?;
        self.laws = if self.merging == Merging::Linear {
            let found = unacknowledged(design, &problem, &solution).ok_or_else(|| self.unstable())?;
            self.filter_noise = Some(found.filter_noise(&design.plant));
            vec![found.law]
        } else {
            vec![solution.law]
        };
        if self.kind == Kind::SlqgTuning {
            self.tuning = Some(TuningBasis { problem });
        }
        Ok(())
    }

    /// The schedule that its packets follow, or that its trigger counts on; `None` for a packet in every cycle to come.
    fn scheduled(
        &self,
        problem: &LoopProblem,
        design: &Design,
        solution: &Solution,
    ) -> Result<Option<Scheduled>, ContenderError> {
        let Some(event) = design.event else { return Ok(None) };
        let mut design = design.clone();
        match self.kind {
            Kind::SlqgPeriodic => {
                let base = if event.may_pause() { event.base } else { Base::Auto };
                design.event = Some(Event { base, rule: Rule::Schedule, ..event });
            }
            kind if kind.weighs_packets() && event.may_pause() => {}
            _ => return Ok(None),
        }
        let error = Estimation::of(&design, solution).error_covariance();
        scheduled(&design, problem, &error).map_err(|_| self.unstable())
    }

    /// What reference and packets are worth to the law.
    fn weigh(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
        solution: &Solution,
    ) -> Result<(), ContenderError> {
        self.preview = PreviewGains::over(problem, design, solution).transpose()?;
        if let (Some(event), true) = (&design.event, self.kind.weighs_packets()) {
            let tables = trigger_tables(problem, solution);
            self.trigger = tables.map(|tables| (event.send_cost, Sending::Worth(tables)));
        }
        Ok(())
    }
}
