//! Captures: pcap and pcapng, with the resolution of each interface.

use super::{
    super::{about::Skip, collector::Collector, source::Source, time::Nanoseconds, trace::TraceError},
    message::Message,
    packet::{READ, content, is_read},
};
use pcap_parser::{
    Block, LegacyPcapReader, PcapBlockOwned, PcapError, PcapNGReader, traits::PcapReaderIterator,
};
use std::{path::Path, str};

const CAPACITY: usize = 1 << 18;
/// No block of a capture is longer.
const LONGEST: usize = 1 << 26;
const PCAPNG: [u8; 4] = [0x0a, 0x0d, 0x0d, 0x0a];
const SECOND: i64 = 1_000_000_000;
/// Beyond 146 years the difference of two times would not fit.
const FARTHEST: i64 = i64::MAX / 2;

/// An interface of a capture.
struct Interface {
    link_type: i32,
    /// Units per second as an exponent, of 2 if the upper bit is set, else of 10.
    resolution: u8,
    /// Seconds.
    offset: i64,
    /// How `--tx` and `--rx` call it.
    label: Vec<u8>,
}

/// What a capture has told so far.
#[derive(Default)]
struct Capture {
    interfaces: Vec<Interface>,
    is_big: bool,
    /// Link types that are not read, and packets of those that are.
    unread: Option<i32>,
    read: u64,
}

pub(in super::super) fn read(
    file: &Path,
    source: Source<'_>,
    collector: &mut Collector<'_>,
) -> Result<(), TraceError> {
    let wrong = |problem: String| TraceError::file(file, problem);
    let begin =
        |_| wrong("found no header of a capture; give one of tcpdump -w, dumpcap or Wireshark".into());
    let mut capture = Capture::default();
    if source.head().starts_with(&PCAPNG) {
        let mut reader = PcapNGReader::new(CAPACITY, source.into_read()).map_err(begin)?;
        blocks(&mut reader, &mut capture, collector).map_err(wrong)?;
    } else {
        let mut reader = LegacyPcapReader::new(CAPACITY, source.into_read()).map_err(begin)?;
        blocks(&mut reader, &mut capture, collector).map_err(wrong)?;
    }
    match (capture.unread, capture.read) {
        (Some(link_type), 0) => Err(wrong(format!("found link type {link_type}; give {READ}"))),
        _ => Ok(()),
    }
}

/// What came of an attempt to read a block.
enum Step {
    Taken(usize),
    More,
    End { is_cut: bool },
}

fn blocks(
    reader: &mut impl PcapReaderIterator,
    capture: &mut Capture,
    collector: &mut Collector<'_>,
) -> Result<(), String> {
    let mut capacity = CAPACITY;
    loop {
        let step = match reader.next() {
            Ok((size, block)) => {
                capture.block(&block, collector)?;
                Step::Taken(size)
            }
            Err(PcapError::Eof) => Step::End { is_cut: false },
            Err(PcapError::UnexpectedEof) => Step::End { is_cut: true },
            Err(PcapError::Incomplete(_) | PcapError::BufferTooSmall) => Step::More,
            Err(error) => return Err(damaged(&error)),
        };
        match step {
            Step::Taken(size) => reader.consume(size),
            Step::End { is_cut } => {
                if is_cut {
                    collector.skip(Skip::Cut);
                }
                return Ok(());
            }
            Step::More => {
                let there = reader.data().len();
                if there >= capacity {
                    capacity *= 2;
                    if capacity > LONGEST || !reader.grow(capacity) {
                        return Err("found a block of more than 64 MB: the capture is damaged".into());
                    }
                }
                let refilled = reader.refill().map_err(|error| damaged(&error));
                refilled?;
                if reader.data().len() == there && reader.reader_exhausted() {
                    if there > 0 {
                        collector.skip(Skip::Cut);
                    }
                    return Ok(());
                }
            }
        }
        collector.decide_if_enough().map_err(|error| error.to_string())?;
    }
}

fn damaged(error: &PcapError<&[u8]>) -> String {
    let what = match error {
        PcapError::ReadError => "cannot read it".to_string(),
        PcapError::NomError(_, kind) => format!("found a block that is none ({kind:?})"),
        other => other.to_string(),
    };
    format!("{what}: the capture is damaged; what is whole can be saved with editcap IN OUT")
}

impl Capture {
    fn block(&mut self, block: &PcapBlockOwned<'_>, collector: &mut Collector<'_>) -> Result<(), String> {
        match block {
            PcapBlockOwned::LegacyHeader(header) => {
                self.is_big = header.is_bigendian();
                let resolution = if header.is_nanosecond_precision() { 9 } else { 6 };
                // The upper bits tell of frame check sequences.
                let link_type = header.network.0 & 0xffff;
                self.unread = Some(link_type).filter(|link_type| !is_read(*link_type));
                self.interfaces.push(Interface { link_type, resolution, offset: 0, label: b"0".to_vec() });
                Ok(())
            }
            PcapBlockOwned::Legacy(packet) => {
                let below =
                    if self.interfaces.first().is_some_and(|of| of.resolution == 9) { 1 } else { 1000 };
                let time = i64::from(packet.ts_sec) * SECOND + i64::from(packet.ts_usec) * below;
                self.packet(0, time, packet.data, collector);
                Ok(())
            }
            PcapBlockOwned::NG(Block::SectionHeader(section)) => {
                self.is_big = section.big_endian();
                self.interfaces.clear();
                Ok(())
            }
            PcapBlockOwned::NG(Block::InterfaceDescription(description)) => {
                let selection = collector.selection;
                let named = description.options.iter().filter(|option| matches!(option.code.0, 2 | 3));
                let names = named.filter_map(|option| str::from_utf8(option.as_bytes().ok()?).ok());
                let name = names
                    .map(|name| name.trim_end_matches('\0'))
                    .find(|name| [selection.tx, selection.rx].contains(&Some(*name)));
                self.interfaces.push(Interface {
                    link_type: description.linktype.0 & 0xffff,
                    resolution: description.if_tsresol,
                    offset: description.if_tsoffset,
                    label: name
                        .map_or_else(|| self.interfaces.len().to_string(), str::to_string)
                        .into_bytes(),
                });
                Ok(())
            }
            PcapBlockOwned::NG(Block::EnhancedPacket(packet)) => {
                let ticks = u64::from(packet.ts_high) << 32 | u64::from(packet.ts_low);
                let index = packet.if_id as usize;
                let Some(interface) = self.interfaces.get(index) else {
                    return Err(format!(
                        "found a packet of interface {index}, which the capture does not describe: it is damaged"
                    ));
                };
                let time = interface
                    .time(ticks)
                    .ok_or("found a time beyond 146 years from 1970: the capture is damaged")?;
                let captured = packet.data.get(..packet.caplen as usize).unwrap_or(packet.data);
                self.packet(index, time, captured, collector);
                Ok(())
            }
            // Without a time.
            PcapBlockOwned::NG(Block::SimplePacket(_)) => Err(
                "found packets without times (simple packet blocks): capture again with dumpcap or tcpdump"
                    .into(),
            ),
            PcapBlockOwned::NG(_) => Ok(()),
        }
    }

    fn packet(&mut self, index: usize, time: Nanoseconds, packet: &[u8], collector: &mut Collector<'_>) {
        let Some(interface) = self.interfaces.get(index) else { return };
        if !is_read(interface.link_type) {
            self.unread = Some(interface.link_type);
            return collector.skip(Skip::Protocol);
        }
        self.read += 1;
        match content(interface.link_type, packet, self.is_big) {
            Ok((stream, data)) => {
                collector.message(&Message {
                    time,
                    interface: &interface.label,
                    direction: None,
                    stream,
                    data,
                });
            }
            Err(skip) => collector.skip(skip),
        }
    }
}

impl Interface {
    fn time(&self, ticks: u64) -> Option<Nanoseconds> {
        const BINARY: u8 = 0x80;
        let nanoseconds = u128::from(ticks) * SECOND as u128;
        let time = match self.resolution {
            exponent if exponent & BINARY != 0 => nanoseconds.checked_shr(u32::from(exponent & !BINARY))?,
            exponent => nanoseconds / 10_u128.checked_pow(u32::from(exponent))?,
        };
        let time = i64::try_from(time).ok()?.checked_add(self.offset.checked_mul(SECOND)?)?;
        (time.abs() < FARTHEST).then_some(time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_in_every_resolution() {
        let interface = |resolution, offset| Interface { link_type: 1, resolution, offset, label: vec![] };
        assert_eq!(interface(6, 0).time(1_500_000), Some(1_500_000_000));
        assert_eq!(interface(9, 2).time(1_500_000_000), Some(3_500_000_000));
        assert_eq!(interface(0x80 | 10, 0).time(1536), Some(1_500_000_000));
        assert_eq!((interface(127, 0).time(1), interface(0, 0).time(u64::MAX)), (None, None));
    }
}
