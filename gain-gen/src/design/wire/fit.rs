//! How long frames are, and whether what carries them has room.

use super::{WireSettings, acknowledges};
use crate::design::{Design, DeviceScalar};
use slqg::Scalar;
use slqg::wire::can::{
    FD_CAPACITY, MOST_CYCLES, MOST_VALUES, compact_acknowledgement_len, compact_len, fd_len,
};
use slqg::wire::{acknowledgement_len, control_len, measurement_len};

/// Bytes of each kind of frame, sealed where the design says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameBytes {
    /// Of a measurement.
    pub measurement: usize,
    /// Of a control frame.
    pub control: usize,
    /// Of an acknowledgement of all the cycles it is to tell; `None` if there are none.
    pub acknowledgement: Option<usize>,
}

/// Frames that are too long for what is to carry them.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {found}; {allowed}")]
pub struct Misfit {
    /// Dotted key of the design that is at fault.
    pub key: &'static str,
    /// What was found, as a clause.
    pub found: String,
    /// What would fit, as a request.
    pub allowed: String,
}

impl Design {
    /// Bytes of the design's full frames.
    pub fn frame_bytes(&self) -> FrameBytes {
        self.frames_in(self.controller.scalar)
    }

    /// Bytes that travel: those of full frames, of CAN FD frames with their padding, or of compact frames. `None` if they do
    /// not fit, see [`Design::misfit`].
    pub fn carried_bytes(&self) -> Option<FrameBytes> {
        let FrameBytes { measurement, control, acknowledgement } = self.frame_bytes();
        let (plant, settings) = (&self.plant, &self.controller);
        if self.misfit().is_some() {
            return None;
        }
        Some(match self.wire {
            WireSettings::Bytes => self.frame_bytes(),
            WireSettings::CanFd => FrameBytes {
                measurement: fd_len(measurement)?,
                control: fd_len(control)?,
                acknowledgement: acknowledgement.and_then(fd_len),
            },
            WireSettings::CanClassic(_) => FrameBytes {
                measurement: compact_len(plant.outputs()),
                control: compact_len(plant.inputs() * settings.sequence_length),
                acknowledgement: acknowledgement
                    .map(|_| compact_acknowledgement_len(self.network.acknowledged_cycles)),
            },
        })
    }

    /// Why the design's frames do not fit what is to carry them; `None` if they do. A design that was read fits; one whose
    /// sequence length or acknowledgements were then changed may not.
    pub fn misfit(&self) -> Option<Misfit> {
        match self.wire {
            WireSettings::Bytes => None,
            WireSettings::CanFd => self.beyond_can_fd(),
            WireSettings::CanClassic(_) => self.beyond_can_classic(),
        }
    }

    fn frames_in(&self, scalar: DeviceScalar) -> FrameBytes {
        let (plant, bytes, cycles) = (&self.plant, bytes(scalar), self.network.acknowledged_cycles);
        let head = self.authentication.bytes();
        FrameBytes {
            measurement: head + measurement_len(plant.outputs(), bytes),
            control: head + control_len(plant.inputs(), self.controller.sequence_length, bytes),
            acknowledgement: acknowledges(&self.network).then(|| head + acknowledgement_len(cycles)),
        }
    }

    fn beyond_can_fd(&self) -> Option<Misfit> {
        let (frames, scalar) = (self.frame_bytes(), self.controller.scalar);
        let single = self.frames_in(DeviceScalar::F32);
        let wide = scalar == DeviceScalar::F64;
        let of = |kind, bytes| {
            format!("a {kind} frame of {bytes} bytes, but a CAN FD frame carries {FD_CAPACITY}")
        };
        if frames.measurement > FD_CAPACITY {
            let found = format!("found {}", of("measurement", frames.measurement));
            let narrower = wide && single.measurement <= FD_CAPACITY;
            let advice = if narrower { "give controller.scalar = \"f32\", or " } else { "give " };
            return Some(Misfit {
                key: "wire.format",
                found,
                allowed: format!("{advice}format = \"bytes\""),
            });
        }
        if frames.control <= FD_CAPACITY {
            return None;
        }
        let room = FD_CAPACITY - self.authentication.bytes();
        let longest = |scalar| longest_in(room, self.plant.inputs(), scalar);
        let found = format!(
            "found sequences of {} inputs: {}",
            self.controller.sequence_length,
            of("control", frames.control)
        );
        let mut advice = vec![];
        if longest(scalar) > 0 {
            advice.push(format!("at most {}", longest(scalar)));
        }
        if wide && longest(DeviceScalar::F32) > 0 {
            advice.push(format!("at most {} with controller.scalar = \"f32\"", longest(DeviceScalar::F32)));
        }
        advice.push("wire.format = \"bytes\"".into());
        let allowed = format!("give {}", advice.join(", or "));
        Some(Misfit { key: "controller.sequence_length", found, allowed })
    }

    fn beyond_can_classic(&self) -> Option<Misfit> {
        let (inputs, outputs) = (self.plant.inputs(), self.plant.outputs());
        let (length, cycles) = (self.controller.sequence_length, self.network.acknowledged_cycles);
        let other = if self.beyond_can_fd().is_none() { "can-fd" } else { "bytes" };
        let carries = format!("but a classic CAN frame carries {MOST_VALUES}");
        for (count, what) in [(inputs, "inputs"), (outputs, "outputs")] {
            if count > MOST_VALUES {
                let found =
                    format!("found \"can-classic\" for a plant with {count} {what}, {carries} values");
                return Some(Misfit { key: "wire.format", found, allowed: format!("give \"{other}\"") });
            }
        }
        if inputs * length > MOST_VALUES {
            let found = format!("found sequences of {length} inputs: {} values, {carries}", inputs * length);
            let allowed = format!("give at most {}, or wire.format = \"{other}\"", MOST_VALUES / inputs);
            return Some(Misfit { key: "controller.sequence_length", found, allowed });
        }
        if acknowledges(&self.network) && cycles > MOST_CYCLES {
            let found = format!("found {cycles} cycles, but a classic CAN frame carries {MOST_CYCLES}");
            let allowed = format!("give at most {MOST_CYCLES}, or wire.format = \"{other}\"");
            return Some(Misfit { key: "network.acknowledged_cycles", found, allowed });
        }
        None
    }
}

/// The longest sequence of `inputs` values each that fits a frame of `room` bytes; 0 if none does.
fn longest_in(room: usize, inputs: usize, scalar: DeviceScalar) -> usize {
    (room - control_len(0, 0, 0)) / (inputs * usize::from(bytes(scalar)))
}

fn bytes(scalar: DeviceScalar) -> u8 {
    match scalar {
        DeviceScalar::F32 => f32::BYTES,
        DeviceScalar::F64 => f64::BYTES,
    }
}
