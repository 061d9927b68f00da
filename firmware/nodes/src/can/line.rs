//! Frames of a node to the bus and back, and what waits while the bus is busy.
//!
//! Of each kind at most one frame waits, the newest: an actuator rejects a sequence that is older than what it has, a measurement
//! is worth less than the next one, and an acknowledgement repeats what those before it said. What is replaced while it
//! waits is counted, as is all else that is lost.

use super::Form;
use embedded_can::{Frame, nb::Can};
use slqg::{
    Scalar, Tick,
    wire::{self, Kind, Role, can::MOST_VALUES},
};

/// Bytes of the longest full frame that [`Line::receive`] gives: a sequence of binary64.
pub const LONGEST: usize = wire::control_len(1, MOST_VALUES, f64::BYTES);

/// The kinds of frame that wait if they must, the most urgent first.
const URGENCY: [Kind; 4] = [Kind::Clock, Kind::Measurement, Kind::Control, Kind::Acknowledgement];

/// Kinds of frame that a node takes from the bus. A sensor, or whoever keeps the time, takes none.
pub const fn taken_by(role: Role) -> &'static [Kind] {
    match role {
        Role::Controller => &[Kind::Clock, Kind::Measurement, Kind::Acknowledgement],
        Role::Actuator => &[Kind::Clock, Kind::Control],
    }
}

/// Frames that were lost at this end of the line; all counts saturate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lost {
    /// A newer one of their kind came while they waited for the bus.
    pub replaced: u32,
    /// The driver had no room for what it received, or has told another error.
    pub overruns: u32,
    /// They have an identifier of the loop, or are the node's own, and do not go with its [`Form`].
    pub refused: u32,
}

impl Lost {
    /// All of them.
    pub const fn total(&self) -> u32 {
        self.replaced.saturating_add(self.overruns).saturating_add(self.refused)
    }
}

/// A node's line over the bus of the CAN controller `C`.
#[derive(Debug)]
pub struct Line<C: Can, T, const NU: usize, const NY: usize> {
    bus: C,
    form: Form<T, NU, NY>,
    takes: &'static [Kind],
    /// The node's cycle, as far as its own frames and the clock tell: the lower half of a received tick is near it.
    now: Tick,
    /// Whether the node has told its cycle. Before that the clock does; later a clock that jumps may be wrong.
    has_told: bool,
    /// One for each of [`URGENCY`].
    waiting: [Option<C::Frame>; URGENCY.len()],
    lost: Lost,
}

impl<C: Can, T: Scalar, const NU: usize, const NY: usize> Line<C, T, NU, NY> {
    /// A line over `bus`, which is on, for a node that takes these kinds of frame.
    pub fn new(bus: C, form: Form<T, NU, NY>, takes: &'static [Kind]) -> Self {
        let waiting = [const { None }; URGENCY.len()];
        Self { bus, form, takes, now: Tick::default(), has_told: false, waiting, lost: Lost::default() }
    }

    /// Sends a full frame of the node; service frames but the clock stay here. One that finds the bus busy waits for
    /// [`Self::flush`].
    pub fn send(&mut self, frame: &[u8]) {
        self.has_told |= self.learn(frame);
        let Some(place) = Kind::of(frame).and_then(place_of) else { return };
        match self.form.pack(frame) {
            Ok(packed) => {
                if self.waiting[place].replace(packed).is_some() {
                    count(&mut self.lost.replaced);
                }
                self.flush();
            }
            Err(_) => count(&mut self.lost.refused),
        }
    }

    /// Hands over to the driver what waits, as far as it has room. To be called again and again.
    pub fn flush(&mut self) {
        for place in 0..URGENCY.len() {
            let Some(frame) = self.waiting[place].take() else { continue };
            match self.bus.transmit(&frame) {
                Ok(None) => (),
                Ok(Some(withdrawn)) => self.wait_again(withdrawn),
                // It would block, or cannot now: the frame waits until it can or a newer one comes.
                Err(_) => self.waiting[place] = Some(frame),
            }
        }
    }

    /// The next full frame for the node, in `buffer` of [`LONGEST`] bytes; `None` if there is none now. Never waits.
    pub fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let len = loop {
            let frame = match self.bus.receive() {
                Ok(frame) => frame,
                Err(nb::Error::WouldBlock) => return None,
                // Whatever else is there, is there at the next call, too.
                Err(nb::Error::Other(_)) => {
                    count(&mut self.lost.overruns);
                    return None;
                }
            };
            // Filters let strangers through where they have too few places.
            if !self.form.kind(frame.id()).is_some_and(|kind| self.takes.contains(&kind)) {
                continue;
            }
            match self.form.unpack(&frame, self.now, buffer) {
                Ok(full) => break full.len(),
                Err(_) => count(&mut self.lost.refused),
            }
        };
        let frame = buffer.get(..len)?;
        if Kind::of(frame) == Some(Kind::Clock) && !self.has_told {
            self.learn(frame);
        }
        Some(frame)
    }

    /// What was lost at this end.
    pub fn lost(&self) -> Lost {
        self.lost
    }

    /// The CAN controller: for what only its driver knows, for example whether it is off the bus.
    pub fn bus(&mut self) -> &mut C {
        &mut self.bus
    }

    /// Takes back a frame that the driver had to give up for a more urgent one.
    fn wait_again(&mut self, withdrawn: C::Frame) {
        match self.form.kind(withdrawn.id()).and_then(place_of) {
            Some(place) if self.waiting[place].is_none() => self.waiting[place] = Some(withdrawn),
            _ => count(&mut self.lost.replaced),
        }
    }

    /// Which cycle it is, if the frame tells: a node without a clock goes on by its own timer, and what it sends says so.
    fn learn(&mut self, frame: &[u8]) -> bool {
        let tells = matches!(
            Kind::of(frame),
            Some(Kind::Clock | Kind::Control | Kind::Acknowledgement | Kind::Applied | Kind::Ran)
        );
        if let (true, &[_, _, _, a, b, c, d, ..]) = (tells, frame) {
            self.now = Tick(u32::from_le_bytes([a, b, c, d]));
            return true;
        }
        false
    }
}

fn place_of(kind: Kind) -> Option<usize> {
    URGENCY.iter().position(|urgent| *urgent == kind)
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
