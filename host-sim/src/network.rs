//! The three links of a loop in use: what is sent into them, and what comes out in which cycle.
//!
//! What a link does to packets is [`slqg_links`]' to say; who sends what when is the closed loop's. Frames that go over a
//! bus travel as [`crate::carrier`] packs them.

use crate::{
    carrier::Carrier,
    contender::{Contender, Outage},
    random::{Purpose, stream},
    size_class::LONGEST_SEQUENCE,
};
use gain_gen::design::Acknowledgement;
use slqg::Scalar;
use slqg::wire::LONGEST_ACKNOWLEDGEMENT;
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
    /// To the receiver's next cycle, always. Empty: nothing is on its way.
    Straight(Vec<u8>),
    /// Over a link of their own.
    Path(Box<Path>),
    /// Over the bus.
    Bus,
}

/// The links of one run. Without a bus they allocate nothing once they are made.
pub struct Network<T, const NU: usize, const NY: usize> {
    /// By [`Role`].
    ways: [Way; Role::COUNT],
    bus: Option<(LoopBus, Carrier<T, NU, NY>)>,
    /// The current cycle.
    cycle: u64,
    /// States of the channel to the actuator in the cycles before, the newest first; empty if it has none.
    channel: VecDeque<usize>,
    /// What the link to the actuator becomes, and in which cycle; then what it was, with all that is under way on it.
    other: Option<(u64, Box<Path>)>,
    outages: Vec<Outage>,
}

impl<T: Scalar, const NU: usize, const NY: usize> Network<T, NU, NY> {
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
                Acknowledgement::Instant => Way::Straight(Vec::with_capacity(LONGEST_ACKNOWLEDGEMENT)),
                Acknowledgement::None => Way::Nowhere,
                Acknowledgement::Over(link) => way(link, Purpose::AcknowledgementLink),
            },
        ];
        let other = contender.change.as_ref().map(|change| {
            let path = Path::new(&change.link, stream(seed, run, Purpose::ChangedLink));
            (change.cycle as u64, Box::new(path))
        });
        let channel = VecDeque::with_capacity(REMEMBERED + 1);
        let mut network = Self { ways, bus, cycle: 0, channel, other, outages: contender.outages.clone() };
        network.change_link();
        network
    }

    /// In its cycle the link becomes what it is to become.
    fn change_link(&mut self) {
        if let (Some((cycle, other)), Way::Path(path)) =
            (&mut self.other, &mut self.ways[Role::Control as usize])
            && *cycle == self.cycle
        {
            std::mem::swap(path, other);
        }
    }

    fn send(&mut self, role: Role, frame: &[u8]) -> Fate {
        if self.outages.iter().any(|outage| outage.loses(role, self.cycle)) {
            if let Way::Path(path) = &mut self.ways[role as usize] {
                path.skip();
            }
            return Fate::Lost;
        }
        match &mut self.ways[role as usize] {
            Way::Nowhere => Fate::Lost,
            Way::Straight(under_way) => {
                under_way.clear();
                under_way.extend_from_slice(frame);
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

    fn take(&mut self, role: Role, mut receive: impl FnMut(&[u8])) {
        match &mut self.ways[role as usize] {
            Way::Nowhere => (),
            Way::Straight(under_way) if under_way.is_empty() => (),
            Way::Straight(under_way) => {
                receive(under_way);
                under_way.clear();
            }
            Way::Path(path) => path.arrived().for_each(receive),
            Way::Bus => {
                let frames = self.bus.as_mut().map(|(bus, _)| bus.take(role)).unwrap_or_default();
                frames.iter().for_each(|frame| receive(frame));
            }
        }
    }

    /// Sends a measurement frame.
    pub fn send_measurement(&mut self, frame: &[u8]) -> Fate {
        self.send(Role::Measurement, frame)
    }

    /// Hands `receive` the frames that the controller takes in this cycle: measurements, then acknowledgements. Once per
    /// cycle.
    pub fn to_controller(&mut self, mut receive: impl FnMut(&[u8])) {
        self.take(Role::Measurement, &mut receive);
        self.take(Role::Acknowledgement, &mut receive);
        if let (Way::Path(path), 1..) = (&mut self.ways[Role::Acknowledgement as usize], self.cycle) {
            // An acknowledgement is about a cycle that is over and taken in the next: only now its link's cycle ends.
            path.next_cycle();
        }
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

    /// Hands `receive` the frames that the actuator takes in this cycle.
    pub fn to_actuator(&mut self, mut receive: impl FnMut(&[u8])) {
        if let Some((_, other)) = &mut self.other {
            // Before the change nothing is on it.
            other.arrived().for_each(&mut receive);
        }
        self.take(Role::Control, receive);
    }

    /// Sends an acknowledgement frame, or lets the cycle pass without one.
    pub fn send_acknowledgement(&mut self, frame: Option<&[u8]>) -> Option<Fate> {
        match (frame, &mut self.ways[Role::Acknowledgement as usize]) {
            (Some(frame), _) => return Some(self.send(Role::Acknowledgement, frame)),
            (None, Way::Path(path)) => path.skip(),
            (None, _) => (),
        }
        None
    }

    /// Ends the current cycle.
    pub fn next_cycle(&mut self) {
        self.cycle += 1;
        if let Way::Path(path) = &self.ways[Role::Control as usize]
            && let Some(state) = path.channel_state()
        {
            self.channel.truncate(REMEMBERED - 1);
            self.channel.push_front(state);
        }
        for role in [Role::Measurement, Role::Control] {
            if let Way::Path(path) = &mut self.ways[role as usize] {
                path.next_cycle();
            }
        }
        if let Some((_, other)) = &mut self.other {
            other.next_cycle();
        }
        if let Some((bus, _)) = &mut self.bus {
            bus.next_cycle();
        }
        self.change_link();
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
