//! CAN FD through SocketCAN: a frame is the payload of one CAN FD frame, and its identifier says what it is.
//!
//! Linux only. The wire between actuator and plant is not on the bus: it stays UDP.

use super::{READABLE, Transport, received, udp::Udp, wait};
use crate::node::{NodeError, event_loop::Channel};
use rustix::event::PollFd;
use slqg::wire::can::{FD_CAPACITY, pad, unpad};
use socketcan::{
    CanAnyFrame, CanFdFrame, CanFdSocket, CanFilter, EmbeddedFrame, ExtendedId, Id, Socket, SocketOptions,
    StandardId,
};
use std::{io, time::Duration};

/// Largest identifier of 11 bits; larger ones have 29.
const STANDARD: u32 = 0x7ff;
/// Mask that compares a whole identifier.
const WHOLE: u32 = 0x1fff_ffff;

/// Identifiers of the three kinds of frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identifiers {
    /// Of measurements.
    pub measurement: u32,
    /// Of control frames.
    pub control: u32,
    /// Of acknowledgements.
    pub acknowledgement: u32,
}

impl Identifiers {
    fn of(self, channel: Channel) -> Option<u32> {
        match channel {
            Channel::Measurement => Some(self.measurement),
            Channel::Control => Some(self.control),
            Channel::Acknowledgement => Some(self.acknowledgement),
            Channel::AppliedInput | Channel::Relayed => None,
        }
    }
}

/// A CAN interface, and the wire to the plant if there is one.
pub struct Can {
    socket: CanFdSocket,
    identifiers: Identifiers,
    wire: Option<Udp>,
}

impl Can {
    /// Opens `interface` for frames with the identifiers of `takes`.
    ///
    /// # Errors
    /// If there is no such interface, or none at all on this system.
    pub fn open(
        interface: &str,
        identifiers: Identifiers,
        takes: &[Channel],
        wire: Option<Udp>,
    ) -> Result<Self, NodeError> {
        let refused =
            |error: io::Error| NodeError::Input(format!("--can {interface}: {}", explained(&error)));
        let socket = CanFdSocket::open(interface).map_err(refused)?;
        let filters: Vec<_> = takes
            .iter()
            .filter_map(|&channel| identifiers.of(channel))
            .map(|identifier| CanFilter::new(identifier, WHOLE))
            .collect();
        socket.set_filters(&filters).map_err(refused)?;
        socket.set_nonblocking(true).map_err(refused)?;
        Ok(Self { socket, identifiers, wire })
    }
}

fn explained(error: &io::Error) -> String {
    // No such device; address family not supported: neither has a kind of its own.
    match error.raw_os_error().map(rustix::io::Errno::from_raw_os_error) {
        Some(rustix::io::Errno::NODEV) => {
            "there is no such interface; `ip link show type can` lists those there are".into()
        }
        Some(rustix::io::Errno::AFNOSUPPORT | rustix::io::Errno::PROTONOSUPPORT) => {
            "this kernel has no CAN; load its module can_raw, or use --udp".into()
        }
        _ => format!("cannot be opened: {error}"),
    }
}

impl Transport for Can {
    fn send(&mut self, channel: Channel, packet: &[u8]) -> io::Result<()> {
        let Some(identifier) = self.identifiers.of(channel) else {
            return self.wire.as_mut().map_or(Ok(()), |wire| wire.send(channel, packet));
        };
        let mut buffer = [0; FD_CAPACITY];
        let payload = pad(packet, &mut buffer).ok_or_else(|| io::Error::other("longer than 64 bytes"))?;
        let standard = u16::try_from(identifier).ok().filter(|_| identifier <= STANDARD);
        let id = match standard.and_then(StandardId::new) {
            Some(id) => Some(Id::Standard(id)),
            None => ExtendedId::new(identifier).map(Id::Extended),
        };
        let frame = id.and_then(|id| CanFdFrame::new(id, payload));
        self.socket.write_frame(&frame.ok_or_else(|| io::Error::other("no identifier of CAN"))?)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        let payload = match received(self.socket.read_frame())? {
            Some(CanAnyFrame::Fd(frame)) => unpad(frame.data()).unwrap_or(frame.data()).to_vec(),
            Some(CanAnyFrame::Normal(frame)) => frame.data().to_vec(),
            // Error and remote frames are not for the node.
            Some(_) => Vec::new(),
            None => return self.wire.as_mut().map_or(Ok(None), |wire| wire.receive(buffer)),
        };
        buffer[..payload.len()].copy_from_slice(&payload);
        Ok(Some(payload.len()))
    }

    fn wait(&self, time: Duration) -> io::Result<bool> {
        let bus = PollFd::new(&self.socket, READABLE);
        match &self.wire {
            Some(wire) => wait(&mut [bus, PollFd::new(&wire.socket, READABLE)], time),
            None => wait(&mut [bus], time),
        }
    }

    fn of_strangers(&self) -> u64 {
        self.wire.as_ref().map_or(0, |wire| wire.of_strangers())
    }
}
