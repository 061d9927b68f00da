//! What is in a captured packet: a CAN frame, or UDP over IPv4 or IPv6, below whatever link layer.

use super::{
    super::about::Skip,
    message::{CanId, Stream},
};
use etherparse::{EtherType, LaxSlicedPacket, TransportSlice};

const ETHERNET: i32 = 1;
const RAW_IP: [i32; 5] = [12, 14, 101, 228, 229];
/// BSD loopback: four bytes for the family of addresses.
const LOOPBACK: [i32; 2] = [0, 108];
const COOKED: i32 = 113;
const COOKED_2: i32 = 276;
const SOCKETCAN: i32 = 227;
/// Link types that are read, for a message.
pub(super) const READ: &str =
    "Ethernet (1), Linux cooked (113, 276), raw IP (12, 101, 228, 229), loopback (0, 108) or SocketCAN (227)";

/// Protocols of cooked captures: CAN, CAN FD, CAN XL.
const CAN: [u16; 2] = [0x000c, 0x000d];
const CAN_XL: u16 = 0x000e;

/// Whether packets of a link type are read.
pub(super) fn is_read(link_type: i32) -> bool {
    RAW_IP.contains(&link_type)
        || LOOPBACK.contains(&link_type)
        || [ETHERNET, COOKED, COOKED_2, SOCKETCAN].contains(&link_type)
}

/// The stream and the payload of a packet. `is_big` is the order of bytes of the computer that captured it.
pub(super) fn content(link_type: i32, packet: &[u8], is_big: bool) -> Result<(Stream, &[u8]), Skip> {
    let cut = |from: usize| packet.get(from..).ok_or(Skip::Protocol);
    let protocol = |at: usize| {
        packet.get(at..at + 2).map(|bytes| u16::from_be_bytes([bytes[0], bytes[1]])).ok_or(Skip::Protocol)
    };
    match link_type {
        SOCKETCAN => can(packet, true),
        ETHERNET => udp(LaxSlicedPacket::from_ethernet(packet).map_err(|_| Skip::Protocol)?),
        COOKED => cooked(protocol(14)?, cut(16)?, is_big),
        COOKED_2 => cooked(protocol(0)?, cut(20)?, is_big),
        _ => {
            let ip = cut(if LOOPBACK.contains(&link_type) { 4 } else { 0 })?;
            udp(LaxSlicedPacket::from_ip(ip).map_err(|_| Skip::Protocol)?)
        }
    }
}

fn cooked(protocol: u16, rest: &[u8], is_big: bool) -> Result<(Stream, &[u8]), Skip> {
    match protocol {
        _ if CAN.contains(&protocol) => can(rest, is_big),
        CAN_XL => Err(Skip::Xl),
        _ => udp(LaxSlicedPacket::from_ether_type(EtherType(protocol), rest)),
    }
}

fn udp(packet: LaxSlicedPacket<'_>) -> Result<(Stream, &[u8]), Skip> {
    match packet.transport {
        Some(TransportSlice::Udp(udp)) => Ok((Stream::Udp(udp.destination_port()), udp.payload())),
        _ => Err(Skip::Protocol),
    }
}

/// Identifier with flags, length, flags of CAN FD, two bytes, data.
fn can(frame: &[u8], is_big: bool) -> Result<(Stream, &[u8]), Skip> {
    const EXTENDED: u32 = 1 << 31;
    const REMOTE: u32 = 1 << 30;
    const ERROR: u32 = 1 << 29;
    const XL: u8 = 0x80;
    let &[a, b, c, d, len, _, _, _, ref data @ ..] = frame else { return Err(Skip::Protocol) };
    let id = if is_big { u32::from_be_bytes([a, b, c, d]) } else { u32::from_le_bytes([a, b, c, d]) };
    match () {
        () if len & XL != 0 => Err(Skip::Xl),
        () if id & ERROR != 0 => Err(Skip::Error),
        () if id & REMOTE != 0 => Err(Skip::Remote),
        () => {
            let is_extended = id & EXTENDED != 0;
            let number = id & if is_extended { 0x1fff_ffff } else { 0x7ff };
            Ok((Stream::Can(CanId { number, is_extended }), &data[..data.len().min(usize::from(len))]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn can_frames_are_read_in_either_order_of_bytes() {
        let payload = [7, 8];
        let big = [&[0x80, 0, 1, 0x23, 2, 0, 0, 0][..], &payload].concat();
        let id = CanId { number: 0x123, is_extended: true };
        assert_eq!(content(SOCKETCAN, &big, false), Ok((Stream::Can(id), payload.as_slice())));
        let little = [&[0; 14][..], &[0, 0xc], &[0x23, 1, 0, 0, 8, 0, 0, 0], &payload].concat();
        let id = CanId { number: 0x123, is_extended: false };
        assert_eq!(
            content(COOKED, &little, false),
            Ok((Stream::Can(id), payload.as_slice())),
            "cut to the begin"
        );
        assert_eq!(content(SOCKETCAN, &[0x20, 0, 0, 4, 8, 0, 0, 0, 0], false), Err(Skip::Error));
        assert_eq!(content(SOCKETCAN, &[0x40, 0, 1, 0x23, 8, 0, 0, 0], false), Err(Skip::Remote));
    }

    #[test]
    fn udp_is_found_below_every_link_layer() {
        let ip =
            [&[0x45, 0, 0, 30, 0, 1, 0, 0, 64, 17][..], &[0; 10], &[0, 5, 0x13, 0x8a, 0, 10, 0, 0], &[7, 8]]
                .concat();
        let expected = Ok((Stream::Udp(0x138a), [7, 8].as_slice()));
        for (link_type, before) in [
            (101, vec![]),
            (0, vec![2, 0, 0, 0]),
            (ETHERNET, [&[0; 12][..], &[8, 0]].concat()),
            (ETHERNET, [&[0; 12][..], &[0x88, 0xa8, 0, 100, 0x81, 0, 0, 5, 8, 0]].concat()),
            (COOKED, [&[0; 14][..], &[8, 0]].concat()),
            (COOKED_2, [&[8, 0][..], &[0; 18]].concat()),
        ] {
            assert_eq!(content(link_type, &[before, ip.clone()].concat(), false), expected, "{link_type}");
        }
        let tcp = [&[0x45, 0, 0, 40, 0, 1, 0, 0, 64, 6][..], &[0; 30]].concat();
        assert_eq!(content(101, &tcp, false), Err(Skip::Protocol));
    }
}
