//! One UDP socket: a frame is a datagram.

use super::{READABLE, Transport, received, wait};
use crate::node::{NodeError, event_loop::Channel};
use rustix::event::PollFd;
use std::{
    io,
    net::{IpAddr, SocketAddr, UdpSocket},
    time::Duration,
};

/// A bound socket, where its packets go, and whose packets it takes.
#[derive(Debug)]
pub struct Udp {
    pub(super) socket: UdpSocket,
    destinations: Vec<(Channel, SocketAddr)>,
    expected: Vec<IpAddr>,
    of_strangers: u64,
}

impl Udp {
    /// Binds `address`. Packets of a channel go to each of its destinations; those of hosts that are neither destinations
    /// nor `also` are not taken.
    ///
    /// # Errors
    /// If the address cannot be bound, or is of another family than a destination.
    pub fn bind(
        address: SocketAddr,
        destinations: Vec<(Channel, SocketAddr)>,
        also: &[IpAddr],
    ) -> Result<Self, NodeError> {
        if let Some((_, other)) = destinations.iter().find(|(_, other)| other.is_ipv4() != address.is_ipv4())
        {
            return Err(NodeError::Input(format!(
                "--udp: found {address} together with {other}; give addresses that are all IPv4 or all IPv6"
            )));
        }
        let refused = |error: io::Error| NodeError::Input(format!("--udp {address}: {}", explained(&error)));
        let socket = UdpSocket::bind(address).map_err(refused)?;
        socket.set_nonblocking(true).map_err(refused)?;
        let hosts = destinations.iter().map(|(_, other)| other.ip());
        let expected = hosts.chain(also.iter().copied()).map(|host| host.to_canonical()).collect();
        Ok(Self { socket, destinations, expected, of_strangers: 0 })
    }
}

fn explained(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::AddrInUse => {
            "the address is in use; give another port, or end the program that has it".into()
        }
        io::ErrorKind::AddrNotAvailable => {
            "not an address of this machine; give one it has, or 0.0.0.0 for all of them".into()
        }
        io::ErrorKind::PermissionDenied => "this port is not open to you; give one above 1023".into(),
        _ => format!("cannot be bound: {error}"),
    }
}

impl Transport for Udp {
    fn send(&mut self, channel: Channel, packet: &[u8]) -> io::Result<()> {
        for (_, address) in self.destinations.iter().filter(|(to, _)| *to == channel) {
            self.socket.send_to(packet, address)?;
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        while let Some((length, sender)) = received(self.socket.recv_from(buffer))? {
            if self.expected.contains(&sender.ip().to_canonical()) {
                return Ok(Some(length));
            }
            self.of_strangers += 1;
        }
        Ok(None)
    }

    fn wait(&self, time: Duration) -> io::Result<bool> {
        wait(&mut [PollFd::new(&self.socket, READABLE)], time)
    }

    fn of_strangers(&self) -> u64 {
        self.of_strangers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn any(host: &str) -> SocketAddr {
        format!("{host}:0").parse().expect("an address")
    }

    fn pair(also: &[IpAddr], destination: IpAddr) -> (Udp, UdpSocket) {
        let to = SocketAddr::new(destination, 9);
        let node = Udp::bind(any("127.0.0.1"), vec![(Channel::Control, to)], also).expect("bound");
        let other = UdpSocket::bind(any("127.0.0.1")).expect("bound");
        other.send_to(b"hello", node.socket.local_addr().expect("bound")).expect("sent");
        assert!(node.wait(Duration::from_secs(10)).expect("waited"), "something arrives");
        (node, other)
    }

    #[test]
    fn packets_of_strangers_are_counted_and_left_out() {
        let elsewhere: IpAddr = [192, 0, 2, 1].into();
        let (mut node, _other) = pair(&[], elsewhere);
        assert_eq!(node.receive(&mut [0; 16]).expect("no error"), None);
        assert_eq!(node.of_strangers(), 1);
    }

    #[test]
    fn packets_of_hosts_named_beside_the_destinations_are_taken() {
        let elsewhere: IpAddr = [192, 0, 2, 1].into();
        let (mut node, _other) = pair(&[[127, 0, 0, 1].into()], elsewhere);
        assert_eq!(node.receive(&mut [0; 16]).expect("no error"), Some(5));
        assert_eq!(node.of_strangers(), 0);
    }

    #[test]
    fn an_address_in_use_is_an_error_for_people() {
        let first = UdpSocket::bind(any("127.0.0.1")).expect("bound");
        let error = Udp::bind(first.local_addr().expect("bound"), vec![], &[]).expect_err("in use");
        assert!(error.to_string().contains("in use; give another port"), "{error}");
    }
}
