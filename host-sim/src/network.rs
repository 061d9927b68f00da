//! The three links of a loop in use: what is sent into them, and what comes out in which cycle.
//!
//! What a link does to packets is [`slqg_links`]' to say; who sends what when is the closed loop's.

use crate::{
    contender::Contender,
    random::{Purpose, stream},
};
use gain_gen::design::Acknowledgement;
use slqg_links::path::{Fate, Path};
use std::collections::VecDeque;

/// States of the channel to the actuator that are remembered, in cycles: beyond, packets are useless.
const REMEMBERED: usize = crate::size_class::LONGEST_SEQUENCE;

/// The acknowledgements' way back.
enum Feedback {
    /// Before the next cycle, always.
    Instant,
    /// Nowhere.
    None,
    /// Over a link.
    Over(Box<Path>),
}

/// The links of one run.
pub struct Network {
    sensor: Path,
    actuator: Path,
    feedback: Feedback,
    /// Acknowledgements that are there before the next cycle.
    acknowledged: Vec<Vec<u8>>,
    /// States of the channel to the actuator in the cycles before, the newest first; empty if it has none.
    channel: VecDeque<usize>,
}

impl Network {
    /// The contender's links with nothing under way; `seed` and `run` pick the random numbers.
    pub fn new(contender: &Contender, seed: u64, run: u64) -> Self {
        let path = |link, purpose| Path::new(link, stream(seed, run, purpose));
        Self {
            sensor: path(&contender.sensor_link, Purpose::SensorLink),
            actuator: path(&contender.actuator_link, Purpose::ActuatorLink),
            feedback: match &contender.acknowledgement {
                Acknowledgement::Instant => Feedback::Instant,
                Acknowledgement::None => Feedback::None,
                Acknowledgement::Over(link) => {
                    Feedback::Over(Box::new(path(link, Purpose::AcknowledgementLink)))
                }
            },
            acknowledged: Vec::new(),
            channel: VecDeque::with_capacity(REMEMBERED + 1),
        }
    }

    /// Sends a measurement frame.
    pub fn send_measurement(&mut self, frame: &[u8]) -> Fate {
        self.sensor.send(frame)
    }

    /// Frames that the controller takes in this cycle: measurements, then acknowledgements.
    pub fn to_controller(&mut self) -> impl Iterator<Item = Vec<u8>> {
        self.sensor.arrived().into_iter().chain(std::mem::take(&mut self.acknowledged))
    }

    /// Sends a control frame, or lets the cycle pass without one.
    pub fn send_control(&mut self, frame: Option<&[u8]>) -> Option<Fate> {
        match frame {
            Some(frame) => Some(self.actuator.send(frame)),
            None => {
                self.actuator.skip();
                None
            }
        }
    }

    /// Frames that the actuator takes in this cycle.
    pub fn to_actuator(&mut self) -> Vec<Vec<u8>> {
        self.actuator.arrived()
    }

    /// Sends an acknowledgement frame, in every cycle.
    pub fn send_acknowledgement(&mut self, frame: &[u8]) {
        match &mut self.feedback {
            Feedback::Instant => self.acknowledged.push(frame.to_vec()),
            Feedback::None => (),
            Feedback::Over(path) => {
                path.send(frame);
                self.acknowledged = path.arrived();
            }
        }
    }

    /// Ends the current cycle.
    pub fn next_cycle(&mut self) {
        if let Some(state) = self.actuator.channel_state() {
            self.channel.truncate(REMEMBERED - 1);
            self.channel.push_front(state);
        }
        self.sensor.next_cycle();
        self.actuator.next_cycle();
        if let Feedback::Over(path) = &mut self.feedback {
            path.next_cycle();
        }
    }

    /// States of the channel to the actuator in the cycles before the current one, the newest first: what a controller
    /// knows that is told of them one cycle late. Nothing in the first cycle, and of a link without such states.
    pub fn channel_states(&self) -> impl Iterator<Item = usize> + '_ {
        self.channel.iter().copied()
    }
}
