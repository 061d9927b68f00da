//! The transport that a controller or an actuator was given on the command line.

use super::{
    NodeError,
    event_loop::Channel,
    options::{Carrier, Common},
    transport::{Transport, udp::Udp},
};
use slqg::wire::can::FD_CAPACITY;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

/// Destinations that were given.
fn destinations(of: &[(Channel, Option<SocketAddr>)]) -> Vec<(Channel, SocketAddr)> {
    of.iter().filter_map(|&(channel, address)| Some((channel, address?))).collect()
}

/// The transport of a controller or actuator: `to` is where frames go, `plant` where applied inputs go.
pub(super) fn open(
    common: &Common,
    carrier: &Carrier,
    takes: &[Channel],
    to: (Channel, Option<SocketAddr>),
    plant: Option<SocketAddr>,
    longest_frame: usize,
) -> Result<Box<dyn Transport>, NodeError> {
    if let Some(bind) = carrier.udp {
        let to = destinations(&[to, (Channel::AppliedInput, plant)]);
        return Ok(Box::new(Udp::bind(bind, to, &common.from)?));
    }
    let interface = carrier.can.as_deref().unwrap_or_default();
    if longest_frame > FD_CAPACITY {
        return Err(NodeError::Input(format!(
            "--can {interface}: found frames of {longest_frame} bytes, and CAN FD takes {}; use shorter sequences, f32, or --udp",
            FD_CAPACITY
        )));
    }
    let wire = match plant {
        Some(plant) => {
            let any: IpAddr = match plant {
                SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
                SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
            };
            Some(Udp::bind(
                SocketAddr::new(any, 0),
                destinations(&[(Channel::AppliedInput, Some(plant))]),
                &[],
            )?)
        }
        None => None,
    };
    can(interface, carrier.identifiers, takes, wire)
}

#[cfg(target_os = "linux")]
fn can(
    interface: &str,
    [measurement, control, acknowledgement]: [u32; 3],
    takes: &[Channel],
    wire: Option<Udp>,
) -> Result<Box<dyn Transport>, NodeError> {
    use super::transport::can::{Can, Identifiers};
    let identifiers = Identifiers { measurement, control, acknowledgement };
    Ok(Box::new(Can::open(interface, identifiers, takes, wire)?))
}

#[cfg(not(target_os = "linux"))]
fn can(interface: &str, _: [u32; 3], _: &[Channel], _: Option<Udp>) -> Result<Box<dyn Transport>, NodeError> {
    Err(NodeError::Input(format!("--can {interface}: SocketCAN is part of Linux; use --udp")))
}
