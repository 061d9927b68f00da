//! The three links of a loop in use: what is sent into them, and what comes out in which cycle.
//!
//! What a link does to packets is [`slqg_links`]' to say; who sends what when is the closed loop's. Frames that go over a
//! bus travel as [`crate::carrier`] packs them.

use crate::{
    carrier::Carrier,
    contender::Contender,
    random::{Purpose, stream},
    size_class::{LONGEST_SEQUENCE, SimScalar},
};
use gain_gen::design::Acknowledgement;
use slqg_links::{
    link::Link,
    loop_bus::{LoopBus, Role},
    path::{Fate, Path},
};
use std::collections::VecDeque;

/// States of the channel to the actuator that are remembered, in cycles: beyond, packets are useless.
const REMEMBERED: usize = LONGEST_SEQUENCE;

/// Where frames of a role go.
enum Way {
    /// Nowhere.
    Nowhere,
    /// To the receiver's next cycle, always.
    Straight,
    /// Over a link of their own.
    Path(Box<Path>),
    /// Over the bus.
    Bus,
}

/// The links of one run.
pub struct Network<T, const NU: usize, const NY: usize> {
    /// By [`Role`].
    ways: [Way; Role::COUNT],
    bus: Option<(LoopBus, Carrier<T, NU, NY>)>,
    /// Acknowledgements that are there before the next cycle without a bus.
    acknowledged: Vec<Vec<u8>>,
    /// States of the channel to the actuator in the cycles before, the newest first; empty if it has none.
    channel: VecDeque<usize>,
}

impl<T: SimScalar, const NU: usize, const NY: usize> Network<T, NU, NY> {
    /// The contender's links with nothing under way; `seed` and `run` pick the random numbers.
    ///
    /// # Panics
    /// If its bus cannot be, which reading its design tells beforehand.
    pub fn new(contender: &Contender, carrier: Carrier<T, NU, NY>, seed: u64, run: u64) -> Self {
        let bus = contender.bus.as_ref().map(|plan| {
            let bus = LoopBus::new(plan, stream(seed, run, Purpose::Bus));
            (bus.expect("checked with the design"), carrier)
        });
        let way = |link: &Link, purpose| match link.is_on_bus() && bus.is_some() {
            true => Way::Bus,
            false => Way::Path(Box::new(Path::new(link, stream(seed, run, purpose)))),
        };
        let ways = [
            way(&contender.sensor_link, Purpose::SensorLink),
            way(&contender.actuator_link, Purpose::ActuatorLink),
            match &contender.acknowledgement {
                Acknowledgement::Instant => Way::Straight,
                Acknowledgement::None => Way::Nowhere,
                Acknowledgement::Over(link) => way(link, Purpose::AcknowledgementLink),
            },
        ];
        Self { ways, bus, acknowledged: Vec::new(), channel: VecDeque::with_capacity(REMEMBERED + 1) }
    }

    fn send(&mut self, role: Role, frame: &[u8]) -> Fate {
        match &mut self.ways[role as usize] {
            Way::Nowhere => Fate::Lost,
            Way::Straight => {
                self.acknowledged.push(frame.to_vec());
                Fate::Delayed(0)
            }
            Way::Path(path) => path.send(frame),
            Way::Bus => {
                let (bus, carrier) = self.bus.as_mut().expect("a way over the bus has one");
                bus.send(role, &carrier.payload(role, frame), frame);
                Fate::Open
            }
        }
    }

    fn take(&mut self, role: Role) -> Vec<Vec<u8>> {
        match &mut self.ways[role as usize] {
            Way::Nowhere | Way::Straight => Vec::new(),
            Way::Path(path) => path.arrived(),
            Way::Bus => self.bus.as_mut().map(|(bus, _)| bus.take(role)).unwrap_or_default(),
        }
    }

    /// Sends a measurement frame.
    pub fn send_measurement(&mut self, frame: &[u8]) -> Fate {
        self.send(Role::Measurement, frame)
    }

    /// Frames that the controller takes in this cycle: measurements, then acknowledgements.
    pub fn to_controller(&mut self) -> impl Iterator<Item = Vec<u8>> {
        let measurements = self.take(Role::Measurement);
        let acknowledged = match self.ways[Role::Acknowledgement as usize] {
            Way::Bus => self.take(Role::Acknowledgement),
            _ => std::mem::take(&mut self.acknowledged),
        };
        measurements.into_iter().chain(acknowledged)
    }

    /// Sends a control frame, or lets the cycle pass without one.
    pub fn send_control(&mut self, frame: Option<&[u8]>) -> Option<Fate> {
        match (frame, &mut self.ways[Role::Control as usize]) {
            (Some(frame), _) => return Some(self.send(Role::Control, frame)),
            (None, Way::Path(path)) => path.skip(),
            (None, _) => (),
        }
        None
    }

    /// Frames that the actuator takes in this cycle.
    pub fn to_actuator(&mut self) -> Vec<Vec<u8>> {
        self.take(Role::Control)
    }

    /// Sends an acknowledgement frame, in every cycle.
    pub fn send_acknowledgement(&mut self, frame: &[u8]) {
        self.send(Role::Acknowledgement, frame);
        if let Way::Path(path) = &mut self.ways[Role::Acknowledgement as usize] {
            self.acknowledged = path.arrived();
        }
    }

    /// Ends the current cycle.
    pub fn next_cycle(&mut self) {
        if let Way::Path(path) = &self.ways[Role::Control as usize] {
            if let Some(state) = path.channel_state() {
                self.channel.truncate(REMEMBERED - 1);
                self.channel.push_front(state);
            }
        }
        for way in &mut self.ways {
            if let Way::Path(path) = way {
                path.next_cycle();
            }
        }
        if let Some((bus, _)) = &mut self.bus {
            bus.next_cycle();
        }
    }

    /// States of the channel to the actuator in the cycles before the current one, the newest first: what a controller
    /// knows that is told of them one cycle late. Nothing in the first cycle, and of a link without such states.
    pub fn channel_states(&self) -> impl Iterator<Item = usize> + '_ {
        self.channel.iter().copied()
    }

    /// The bus, if there is one: load, fates and a log.
    pub fn into_bus(self) -> Option<LoopBus> {
        self.bus.map(|(bus, _)| bus)
    }
}
