//! Worst-case response times of periodic messages on a bus without errors, by analysis. Not by simulation.

use super::time::Time;

/// A message as the analysis sees it. Times in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Periodic {
    /// Longest time on the bus, C: worst length with the intermission of 3 bits.
    pub transmission: Time,
    /// Least time between two, T.
    pub period: Time,
    /// Most that its release lags behind its period, J.
    pub jitter: Time,
    /// Longest response time allowed, D.
    pub deadline: Time,
}

/// Worst-case response times R of messages given from the most urgent to the least, each sent by any node; `bit` is the time of a
/// nominal bit. All in nanoseconds.
///
/// Davis, Burns, Bril, Lukkien: Controller Area Network (CAN) schedulability analysis: refuted, revisited and revised,
/// Real-Time Systems 35, 2007: with blocking B (the longest less urgent frame), hp the more urgent messages,
///
/// ```text
/// t    = B + sum over hp and m of ceil((t + J_k) / T_k) C_k                  busy period; Q = ceil((t + J_m) / T_m)
/// w(q) = B + q C_m + sum over hp of ceil((w + J_k + bit) / T_k) C_k          q = 0 .. Q - 1
/// R    = max over q of J_m + w(q) - q T_m + C_m
/// ```
///
/// None where the message and those above it take all of the bus, so that no bound exists. A deadline decides nothing
/// here; see [`meets_deadlines`].
pub fn response_times(messages: &[Periodic], bit: Time) -> Vec<Option<Time>> {
    (0..messages.len()).map(|m| response_time(messages, m, bit)).collect()
}

/// Whether every message has a bound, and none is beyond its deadline.
pub fn meets_deadlines(messages: &[Periodic], bit: Time) -> bool {
    let bounds = response_times(messages, bit);
    bounds.iter().zip(messages).all(|(bound, message)| bound.is_some_and(|bound| bound <= message.deadline))
}

fn response_time(messages: &[Periodic], m: usize, bit: Time) -> Option<Time> {
    let (above, rest) = messages.split_at(m);
    let (this, below) = rest.split_first()?;
    let load = |message: &Periodic| message.transmission as f64 / message.period as f64;
    if messages[..=m].iter().map(load).sum::<f64>() >= 1.0 {
        return None;
    }
    let blocking = below.iter().map(|message| message.transmission).max().unwrap_or(0);
    let busy = fixed_point(this.transmission, |t| {
        messages[..=m]
            .iter()
            .try_fold(blocking, |sum, k| sum.checked_add(interference(k, t.checked_add(k.jitter)?)?))
    })?;
    let instances = busy.checked_add(this.jitter)?.div_ceil(this.period);
    let mut worst = None;
    let mut delay = blocking;
    for q in 0..instances {
        let ahead = blocking.checked_add(q.checked_mul(this.transmission)?)?;
        delay = fixed_point(delay.max(ahead), |w| {
            above.iter().try_fold(ahead, |sum, k| {
                sum.checked_add(interference(k, w.checked_add(k.jitter)?.checked_add(bit)?)?)
            })
        })?;
        let end = this.jitter.checked_add(delay)?.checked_add(this.transmission)?;
        worst = worst.max(Some(end.saturating_sub(q * this.period)));
    }
    worst
}

/// Time that the releases of a message within `window` take on the bus.
fn interference(message: &Periodic, window: Time) -> Option<Time> {
    window.div_ceil(message.period).checked_mul(message.transmission)
}

/// Iterates a function that never falls, from below its least fixed point.
fn fixed_point(start: Time, next: impl Fn(Time) -> Option<Time>) -> Option<Time> {
    let mut time = start;
    loop {
        match next(time)? {
            same if same == time => return Some(time),
            other => time = other,
        }
    }
}
