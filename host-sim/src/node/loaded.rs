//! A design that runs in real time: read, checked, with its gains, its size class and its clock; then run to its end.

use super::{
    NodeError,
    clock::{Pacer, Timetable, WallTime},
    event_loop::{self, Limit, Node},
    options::{Common, Pace},
    statistics::{Punctuality, Statistics},
    transport::Transport,
};
use crate::{
    contender::{Contender, ContenderError, Kind},
    size_class::{InSizeClass, dispatch},
};
use gain_gen::{
    console::tell,
    design::{Authentication, Design, Goal},
    report::Report,
    solve::Method,
    warnings,
};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::{Arc, atomic::AtomicBool};

/// A design that can run in real time.
pub(super) struct Loaded<'o> {
    common: &'o Common,
    pub(super) design: Design,
}

impl<'o> Loaded<'o> {
    pub(super) fn new(common: &'o Common) -> Result<Self, NodeError> {
        let design = warnings::load(&common.design).map_err(|error| NodeError::Input(error.to_string()))?;
        let loaded = Self { common, design };
        if loaded.design.authentication != Authentication::None {
            return Err(loaded.wrong(
                "wire.authentication: found \"cmac\", but these nodes seal no frames and would take forged ones; those of boards do \
                 (host-sim pil). Give \"none\" to run without",
            ));
        }
        if let Some(Goal::Trajectory(_)) = loaded.design.tracking.as_ref().map(|tracking| &tracking.goal) {
            return Err(loaded.wrong(
                "tracking: found a trajectory, which needs a common beginning; nodes can keep a set_point, or track nothing",
            ));
        }
        Ok(loaded)
    }

    pub(super) fn wrong(&self, problem: impl std::fmt::Display) -> NodeError {
        NodeError::Input(format!("{}: {problem}", self.common.design.display()))
    }

    pub(super) fn timetable(&self, phase: f64) -> Result<Timetable, NodeError> {
        Timetable::new(self.design.plant.sample_time, phase).map_err(|problem| self.wrong(problem))
    }

    /// Pacer and punctuality of a node that acts at `phase`.
    pub(super) fn paced(&self, phase: f64, pace: &Pace) -> Result<(Pacer, Punctuality), NodeError> {
        let timetable = self.timetable(phase)?;
        let tolerance = timetable.sample_time().mul_f64(pace.tolerance);
        let pacer = Pacer::new(timetable, pace.begin_anew_after, WallTime::now());
        Ok((pacer, Punctuality::new(tolerance)))
    }

    /// The controller of the design, with its gains.
    pub(super) fn contender(&self) -> Result<Contender, NodeError> {
        let kind = Kind::Slqg;
        Contender::new(kind, &self.design, 0).map_err(|error| match error {
            ContenderError::Unstable { .. } => {
                // Which condition fails is the generator's to say.
                let why = Report::new(&self.design, Method::InFlight).require_stable().err();
                let why = why.map_or_else(String::new, |condition| format!(": {condition}"));
                NodeError::Unstable(format!("{}: {error}{why}", self.common.design.display()))
            }
            wrong => self.wrong(wrong),
        })
    }

    pub(super) fn dispatch<W>(&self, work: W) -> Result<String, NodeError>
    where
        W: InSizeClass<Output = Result<String, NodeError>>,
    {
        dispatch(&self.design, work).map_err(|error| self.wrong(error))?
    }

    /// Runs the node to its end.
    pub(super) fn run(
        &self,
        name: &'static str,
        node: &mut dyn Node,
        mut transport: Box<dyn Transport>,
    ) -> Result<String, NodeError> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&stop))
                .map_err(|error| NodeError::Input(format!("signals cannot be caught: {error}")))?;
        }
        let limit = match (self.common.cycles, self.common.seconds) {
            (Some(cycles), _) => Limit::Cycles(cycles),
            (None, Some(time)) => Limit::Time(time),
            (None, None) => Limit::None,
        };
        let packets = event_loop::run(node, transport.as_mut(), limit, &stop)
            .map_err(|error| NodeError::Input(format!("nothing can be received any more: {error}")))?;
        for finding in node.findings() {
            tell(format_args!("warning: {finding}"));
        }
        let mut sections = node.sections();
        sections.push(packets);
        let statistics = Statistics { node: name, name: self.design.name.clone(), sections };
        Ok(if self.common.json { statistics.json() } else { statistics.table() })
    }
}
