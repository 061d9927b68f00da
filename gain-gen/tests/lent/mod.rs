//! What was sent, in memory that is never given back: for tests only.

use slqg::{Scalar, Tick, in_flight::InFlight, nalgebra::SVector};

/// Nothing was sent in the last `cycles` cycles before `tick`, nor before.
pub(crate) fn nothing_sent<T: Scalar, const NU: usize>(
    length: usize,
    cycles: usize,
    tick: Tick,
) -> InFlight<'static, T, NU> {
    let sent = vec![false; cycles + 1].leak();
    InFlight::new(length, tick, sent, vec![SVector::zeros(); (cycles + 1) * length].leak())
}

/// These sequences were sent, the first one in cycle 0; `None` where nothing was.
#[allow(dead_code, reason = "each test uses its part")]
pub(crate) fn sent<T: Scalar, const NU: usize>(
    length: usize,
    sequences: impl IntoIterator<Item = Option<Vec<SVector<T, NU>>>>,
) -> InFlight<'static, T, NU> {
    let sequences: Vec<_> = sequences.into_iter().collect();
    let mut in_flight = nothing_sent(length, sequences.len(), Tick(0));
    for sequence in sequences {
        if let Some(inputs) = &sequence {
            in_flight.candidate().copy_from_slice(inputs);
        }
        in_flight.push(sequence.is_some());
    }
    in_flight
}
