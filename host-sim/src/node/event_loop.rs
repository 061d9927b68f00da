//! The loop of every node: act when it is time, sleep until then or until something arrives, send what comes of it.
//!
//! One thread, no busy waiting. What a node does is behind [`Node`] and knows neither sockets nor the clock; how packets
//! travel is behind [`Transport`].

use super::{
    clock::WallTime,
    statistics::{Figure, Section},
    transport::Transport,
};
use indicatif::{ProgressBar, ProgressDrawTarget};
use std::{
    io,
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant},
};

/// The longest sleep: the clock may have been set meanwhile.
const NAP: Duration = Duration::from_millis(500);
/// Packets taken between two looks at the clock.
const AT_ONCE: usize = 64;

/// What a packet is, which decides where it goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// A measurement frame.
    Measurement,
    /// A control frame.
    Control,
    /// An acknowledgement frame.
    Acknowledgement,
    /// The applied input, on the wire between actuator and plant.
    AppliedInput,
    /// Whatever a relay passes on.
    Relayed,
}

/// Packets to be sent, in order.
pub type Outbox = Vec<(Channel, Vec<u8>)>;

/// A node of the loop; the time is always told.
pub trait Node {
    /// When it wants to act next; `None` until something arrives.
    fn next(&self) -> Option<WallTime>;
    /// Does what is due at `now`; called at any time, it may be nothing.
    fn act(&mut self, now: WallTime, outbox: &mut Outbox);
    /// Takes a packet that arrived at `now`.
    fn receive(&mut self, packet: &[u8], now: WallTime);
    /// Cycles done.
    fn cycles(&self) -> u64;
    /// Whether going on makes no sense.
    fn is_over(&self) -> bool {
        false
    }
    /// One line on how it goes.
    fn progress(&self) -> String;
    /// What is wrong with the loop as far as this node can tell, in sentences.
    fn findings(&self) -> Vec<String> {
        Vec::new()
    }
    /// What it counted.
    fn sections(&self) -> Vec<Section>;
}

/// When a node ends by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// After so many cycles.
    Cycles(u64),
    /// After so long.
    Time(Duration),
    /// Never.
    None,
}

/// Runs `node` until its limit or until `stop`; returns what was counted on the way.
///
/// A packet that cannot be sent is lost and counted.
///
/// # Errors
/// If the transport cannot wait any more.
pub fn run(
    node: &mut dyn Node,
    transport: &mut dyn Transport,
    limit: Limit,
    stop: &AtomicBool,
) -> io::Result<Section> {
    let begun = Instant::now();
    let progress = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let mut told = begun;
    let (mut outbox, mut buffer) = (Outbox::new(), vec![0; 4096]);
    let (mut sent, mut not_sent, mut not_received) = (0, 0, 0);
    loop {
        node.act(WallTime::now(), &mut outbox);
        for (channel, packet) in outbox.drain(..) {
            *(if transport.send(channel, &packet).is_ok() { &mut sent } else { &mut not_sent }) += 1;
        }
        let done = match limit {
            Limit::Cycles(cycles) => node.cycles() >= cycles,
            Limit::Time(time) => begun.elapsed() >= time,
            Limit::None => false,
        };
        if done || node.is_over() || stop.load(Ordering::Relaxed) {
            break;
        }
        if told.elapsed() >= Duration::from_secs(1) {
            told = Instant::now();
            let findings = node.findings().concat();
            progress.set_message(if findings.is_empty() { node.progress() } else { findings });
            progress.tick();
        }
        let mut nap = NAP;
        if let Some(next) = node.next() {
            nap = nap.min(WallTime::now().until(next));
        }
        if let Limit::Time(time) = limit {
            nap = nap.min(time.saturating_sub(begun.elapsed()));
        }
        if !transport.wait(nap)? {
            continue;
        }
        for _ in 0..AT_ONCE {
            match transport.receive(&mut buffer) {
                Ok(Some(length)) => node.receive(&buffer[..length], WallTime::now()),
                Ok(None) => break,
                // Some systems report here that nobody listened to an earlier packet.
                Err(_) => not_received += 1,
            }
        }
    }
    progress.finish_and_clear();
    let figures = vec![
        ("sent", Figure::Count(sent)),
        ("not_sent", Figure::Count(not_sent)),
        ("not_received", Figure::Count(not_received)),
        ("of_strangers", Figure::Count(transport.of_strangers())),
    ];
    Ok(("packets", figures))
}
