//! How packets travel between nodes: datagrams over UDP, or CAN FD frames. Not what is in them.

#[cfg(target_os = "linux")]
pub mod can;
pub mod udp;

use super::event_loop::Channel;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::Errno,
};
use std::{io, time::Duration};

/// Packets out and in, without ever blocking but in [`Transport::wait`].
pub trait Transport {
    /// Sends one packet to whoever takes what travels on `channel`.
    ///
    /// # Errors
    /// If it was not sent. It is lost then, as on any link.
    fn send(&mut self, channel: Channel, packet: &[u8]) -> io::Result<()>;

    /// Puts one packet that has arrived into `buffer` and tells its length; `None` if there is none. Packets of unexpected
    /// senders are counted and left out.
    ///
    /// # Errors
    /// What the system reports.
    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>>;

    /// Sleeps until a packet arrives, at most as long as `time`; tells whether one may have arrived.
    ///
    /// # Errors
    /// What the system reports, except for a signal, which ends the sleep.
    fn wait(&self, time: Duration) -> io::Result<bool>;

    /// Packets of unexpected senders so far.
    fn of_strangers(&self) -> u64;
}

/// [`Transport::wait`] for file descriptors. To the nanosecond, which a socket's own timeout is not.
fn wait(descriptors: &mut [PollFd<'_>], time: Duration) -> io::Result<bool> {
    let time = Timespec::try_from(time).map_err(io::Error::other)?;
    match poll(descriptors, Some(&time)) {
        Ok(ready) => Ok(ready > 0),
        Err(Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

const READABLE: PollFlags = PollFlags::IN;

/// `None` where nothing has arrived.
fn received<R>(outcome: io::Result<R>) -> io::Result<Option<R>> {
    match outcome {
        Ok(packet) => Ok(Some(packet)),
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
