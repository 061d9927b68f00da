//! The nodes of a loop on one desk, in simulated time: each acts when it says, and packets arrive at once or through relays.
#![allow(dead_code, reason = "each test uses its part")]

use gain_gen::design::Design;
use host_sim::{
    contender::{Contender, Kind},
    fitted::Fitted,
    lent::Lent,
    node::{
        actuator::ActuatorNode,
        clock::{Pacer, Timetable, WallTime},
        controller::{ControllerNode, uncertain},
        event_loop::{Channel, Node, Outbox},
        plant::PlantNode,
        relay::{Fates, RelayNode},
        statistics::{Figure, Punctuality},
    },
    random::{Purpose, stream},
};
use nalgebra::SVector;
use slqg::{Scalar, controller, estimator::Model};
use std::{path::PathBuf, time::Duration};

/// Cycles begin here: some time in 2026.
pub(crate) const BEGIN: WallTime = WallTime(1_790_000_000_000_000_000);

pub(crate) fn design(name: &str) -> Design {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name);
    Design::load(&path).expect("a design")
}

/// What the nodes of a design have in common, in its size class.
pub(crate) struct Loop<T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    pub(crate) design: Design,
    pub(crate) fitted: Fitted<T, NX, NU, NY>,
    /// What a controller begins with that begins in the middle.
    pub(crate) uncertain: Model<T, NX, NU, NY>,
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Loop<T, NX, NU, NY> {
    pub(crate) fn new(design: Design) -> Self {
        let contender = Contender::new(Kind::Slqg, &design, 0).expect("a stable loop");
        let fitted = Fitted::new(&design, &contender);
        let uncertain = uncertain(fitted.design().expect("a design").model, T::nearest(1.0));
        Self { fitted, design, uncertain }
    }

    pub(crate) fn pacer(&self, phase: f64, now: WallTime) -> Pacer {
        Pacer::new(self.timetable(phase), 64, now)
    }

    fn timetable(&self, phase: f64) -> Timetable {
        Timetable::new(self.design.plant.sample_time, phase).expect("a sample time")
    }

    fn punctuality(&self) -> Punctuality {
        Punctuality::new(Duration::from_millis(1))
    }

    /// A controller that begins with the design's initial mean; in the middle less certain of it.
    pub(crate) fn controller(&self, in_the_middle: bool, now: WallTime) -> ControllerNode<'_, T, NX, NU, NY> {
        let design = self.fitted.design().expect("a design");
        let again = controller::Design { model: &self.uncertain, ..design };
        let first = if in_the_middle { again } else { design };
        let pacer = self.pacer(0.3, now);
        // Never given back: a test makes few of them.
        let memory = Box::leak(Box::new(Lent::for_ends(&self.fitted).expect("it fits")));
        let (memory, ..) = memory.lend();
        ControllerNode::new(&self.fitted, first, again, pacer, self.punctuality(), memory).expect("it fits")
    }

    pub(crate) fn actuator(&self, now: WallTime) -> ActuatorNode<'static, T, NU> {
        let settings = self.fitted.design().expect("a design").actuator;
        let told = self.design.network.acknowledged_cycles;
        let inputs = self.design.plant.inputs();
        let length = self.design.controller.sequence_length;
        let memory = vec![SVector::zeros(); slqg::actuator::memory_len(length)].leak();
        ActuatorNode::new(settings, inputs, told, self.pacer(0.6, now), self.punctuality(), memory)
    }

    pub(crate) fn plant(&self, seed: u64, now: WallTime) -> PlantNode<'_, T, NX, NU, NY> {
        let inputs = self.design.plant.inputs();
        let pacer = self.pacer(0.0, now);
        let (plant, objective) = (&self.fitted.plant, &self.fitted.objective);
        PlantNode::new(plant, objective, inputs, seed, pacer, self.punctuality())
    }

    pub(crate) fn relays(&self, seed: u64, now: WallTime) -> [RelayNode; 2] {
        let sample_time = self.timetable(0.0).sample_time();
        let network = &self.design.network;
        let relay = |link, purpose| {
            let fates = Fates::of(link, sample_time, stream(seed, 0, purpose));
            RelayNode::new(fates, 0.0, sample_time, stream(seed, 0, purpose), now)
        };
        [
            relay(&network.sensor_to_controller, Purpose::SensorLink),
            relay(&network.controller_to_actuator, Purpose::ActuatorLink),
        ]
    }
}

/// The nodes that are running. A place is empty while its node is down: packets for it are lost.
pub(crate) struct Desk<'l, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    pub(crate) now: WallTime,
    pub(crate) plant: PlantNode<'l, T, NX, NU, NY>,
    pub(crate) controller: Option<ControllerNode<'l, T, NX, NU, NY>>,
    pub(crate) actuator: Option<ActuatorNode<'l, T, NU>>,
    pub(crate) relays: Option<[RelayNode; 2]>,
    /// The controller's process does not run until then; its packets wait.
    pub(crate) controller_sleeps: WallTime,
    /// Nanoseconds that the actuator's clock is ahead.
    pub(crate) actuator_ahead: i64,
    waiting: Vec<Vec<u8>>,
}

impl<'l, T: Scalar, const NX: usize, const NU: usize, const NY: usize> Desk<'l, T, NX, NU, NY> {
    pub(crate) fn new(of: &'l Loop<T, NX, NU, NY>, seed: u64, has_relays: bool) -> Self {
        Self {
            now: BEGIN,
            plant: of.plant(seed, BEGIN),
            controller: Some(of.controller(false, BEGIN)),
            actuator: Some(of.actuator(BEGIN)),
            relays: has_relays.then(|| of.relays(seed, BEGIN)),
            controller_sleeps: BEGIN,
            actuator_ahead: 0,
            waiting: Vec::new(),
        }
    }

    /// Goes on for `time`.
    pub(crate) fn run(&mut self, time: Duration) {
        let end = self.now.after(time);
        loop {
            let sleeps = self.controller_sleeps;
            let nodes = [
                self.plant.next(),
                self.controller.as_ref().and_then(|node| node.next()).map(|next| next.max(sleeps)),
                self.actuator
                    .as_ref()
                    .and_then(|node| node.next())
                    .map(|next| shifted(next, -self.actuator_ahead)),
                self.relays.as_ref().and_then(|relays| relays.iter().filter_map(|relay| relay.next()).min()),
            ];
            let Some(next) = nodes.into_iter().flatten().min().filter(|next| *next <= end) else { break };
            self.now = next.max(self.now);
            self.act();
        }
        self.now = end;
    }

    fn act(&mut self) {
        let now = self.now;
        let mut outbox = Outbox::new();
        self.plant.act(now, &mut outbox);
        if let Some(controller) = self.controller.as_mut().filter(|_| now >= self.controller_sleeps) {
            self.waiting.drain(..).for_each(|packet| controller.receive(&packet, now));
            controller.act(now, &mut outbox);
        }
        if let Some(actuator) = &mut self.actuator {
            actuator.act(shifted(now, self.actuator_ahead), &mut outbox);
        }
        let mut relayed = [Outbox::new(), Outbox::new()];
        for (channel, packet) in outbox {
            match (channel, &mut self.relays) {
                (Channel::Measurement, Some([relay, _])) => relay.receive(&packet, now),
                (Channel::Control, Some([_, relay])) => relay.receive(&packet, now),
                (Channel::Control, None) => self.hand_actuator(&packet),
                (Channel::AppliedInput, _) => self.plant.receive(&packet, now),
                _ => self.hand_controller(packet),
            }
        }
        if let Some([measurements, controls]) = &mut self.relays {
            measurements.act(now, &mut relayed[0]);
            controls.act(now, &mut relayed[1]);
        }
        let [measurements, controls] = relayed;
        measurements.into_iter().for_each(|(_, packet)| self.hand_controller(packet));
        controls.into_iter().for_each(|(_, packet)| self.hand_actuator(&packet));
    }

    fn hand_controller(&mut self, packet: Vec<u8>) {
        match &mut self.controller {
            Some(_) if self.now < self.controller_sleeps => self.waiting.push(packet),
            Some(controller) => controller.receive(&packet, self.now),
            None => {}
        }
    }

    fn hand_actuator(&mut self, packet: &[u8]) {
        if let Some(actuator) = &mut self.actuator {
            actuator.receive(packet, shifted(self.now, self.actuator_ahead));
        }
    }
}

/// What a clock shows that is so many nanoseconds ahead.
fn shifted(now: WallTime, ahead: i64) -> WallTime {
    WallTime(now.0.saturating_add_signed(ahead))
}

/// A count out of a node's statistics.
pub(crate) fn count(node: &dyn Node, section: &str, key: &str) -> u64 {
    let sections = node.sections();
    let figures = sections.iter().filter(|(name, _)| *name == section).flat_map(|(_, figures)| figures);
    match figures.into_iter().find(|(name, _)| *name == key) {
        Some((_, Figure::Count(count))) => *count,
        other => panic!("{section}.{key}: {other:?}"),
    }
}
