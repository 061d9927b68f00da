//! Memory to lend, which nobody has to keep: it is never given back. It holds rubbish, so that whoever reads what it has not
//! written is found out.
#![allow(dead_code)]

use slqg::actuator::{self, Actuator, Settings};
use slqg::bank::{self, Bank};
use slqg::blob::Shape;
use slqg::controller::{Controller, Design, InvalidDesign, Memory, Sizes};
use slqg::estimator::{Cycle, Estimate, ModeFilter, Model, Remembered, estimates_len};
use slqg::gains::Gains;
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::played::Played;
use slqg::sequence::ControlSequence;
use slqg::tracking::{Preview, RejectedReference};
use slqg::wire::{self, DecodeError};
use slqg::{DefaultInput, Scalar, Tick};

/// No number.
pub(crate) fn rubbish<T: Scalar>() -> T {
    T::nearest(f64::NAN)
}

/// `count` times `entry`.
pub(crate) fn entries<E: Clone>(entry: E, count: usize) -> &'static mut [E] {
    vec![entry; count].leak()
}

/// `count` inputs.
pub(crate) fn inputs<T: Scalar, const NU: usize>(count: usize) -> &'static mut [SVector<T, NU>] {
    entries(SVector::repeat(rubbish()), count)
}

fn estimates<T: Scalar, const NX: usize>(count: usize) -> &'static mut [Estimate<T, NX>] {
    let mut estimate = Estimate::EMPTY;
    estimate.mean = SVector::repeat(rubbish());
    entries(estimate, count)
}

/// Memory of this size for a controller.
pub(crate) fn memory<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    sizes: Sizes,
) -> Memory<'static, T, NX, NU, NY> {
    Memory {
        cycles: entries(Cycle::EMPTY, sizes.cycles),
        estimates: estimates(sizes.estimates),
        ages: entries(rubbish(), sizes.ages),
        sent: entries(true, sizes.sent),
        inputs: inputs(sizes.inputs),
    }
}

/// A controller in exactly the memory that its design takes.
pub(crate) fn controller<'d, T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: Design<'d, T, NX, NU, NY>,
    tick: Tick,
) -> Result<Controller<'d, T, NX, NU, NY>, InvalidDesign> {
    Controller::new(design, tick, memory(design.sizes()))
}

/// An actuator for sequences of up to `length` inputs.
pub(crate) fn actuator<T: Scalar, const NU: usize>(
    settings: Settings<T, NU>,
    tick: Tick,
    length: usize,
) -> Actuator<'static, T, NU> {
    Actuator::new(settings, tick, inputs(actuator::memory_len(length)))
}

/// A record that remembers `cycles` cycles, the first one being `tick`.
pub(crate) fn in_flight<T: Scalar, const NU: usize>(
    length: usize,
    cycles: usize,
    tick: Tick,
) -> InFlight<'static, T, NU> {
    InFlight::new(length, tick, entries(true, cycles + 1), inputs((cycles + 1) * length))
}

/// A filter that remembers `history` cycles, the current one included, and keeps `kept` estimates.
pub(crate) fn filter<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    model: &Model<T, NX, NU, NY>,
    late: usize,
    tick: Tick,
    (length, history, kept): (usize, usize, usize),
) -> ModeFilter<'static, T, NX, NU, NY> {
    let cycles = history + 1;
    let remembered = Remembered::new(
        entries(Cycle::EMPTY, cycles),
        entries(rubbish(), cycles * (length + 1)),
        estimates(estimates_len(cycles, kept)),
        length,
        kept,
    );
    ModeFilter::new(model, late, tick, remembered.expect("memory enough"))
}

/// A bank for sequences of `length` inputs.
pub(crate) fn bank<T: Scalar, const NX: usize, const NU: usize>(
    length: usize,
    default_input: DefaultInput,
) -> Bank<'static, T, NX, NU> {
    let shape = Shape { length, states: NX, inputs: NU, default_input };
    Bank::new(length, default_input, entries(rubbish(), bank::memory_len(&shape))).expect("memory enough")
}

/// Ends a cycle in which these inputs were sent, or nothing.
pub(crate) fn push<T: Scalar, const NU: usize>(
    in_flight: &mut InFlight<'_, T, NU>,
    sent: Option<&[SVector<T, NU>]>,
) {
    if let Some(inputs) = sent {
        in_flight.candidate().copy_from_slice(inputs);
    }
    in_flight.push(sent.is_some());
}

/// What [`InFlight::fill_expected`] writes.
pub(crate) fn expected<T: Scalar, const NX: usize, const NU: usize>(
    in_flight: &InFlight<'_, T, NU>,
    gains: &Gains<'_, T, NX, NU>,
    played: &Played<'_, T, NU>,
) -> Vec<SVector<T, NU>> {
    in_flight.fill_expected(gains, played, inputs(gains.in_flight())).to_vec()
}

/// What [`Gains::fill_sequence`] writes.
pub(crate) fn sequence<T: Scalar, const NX: usize, const NU: usize>(
    gains: &Gains<'_, T, NX, NU>,
    posterior_mean: &SVector<T, NX>,
    expected: &[SVector<T, NU>],
) -> Vec<SVector<T, NU>> {
    let mut sequence = vec![SVector::repeat(rubbish()); gains.length()];
    gains.fill_sequence(posterior_mean, expected, &mut sequence);
    sequence
}

/// What [`Preview::fill_feedforward`] writes: the inputs, and what those in flight are worth.
#[allow(clippy::type_complexity)]
pub(crate) fn feedforward<T: Scalar, const NU: usize, const NZ: usize>(
    preview: &Preview<'_, T, NU>,
    reference: &[SVector<T, NZ>],
) -> Result<(Vec<SVector<T, NU>>, Vec<SVector<T, NU>>), RejectedReference> {
    let (sequence, in_flight) = (inputs(preview.length()), inputs(preview.length()));
    let feedforward = preview.fill_feedforward(reference, sequence, in_flight)?;
    Ok((feedforward.inputs.to_vec(), feedforward.displaced.to_vec()))
}

/// What [`wire::decode_control`] reads where there is room for `length` inputs.
pub(crate) fn decoded<T: Scalar, const NU: usize>(
    frame: &[u8],
    length: usize,
) -> Result<ControlSequence<'static, T, NU>, DecodeError> {
    wire::decode_control(frame, inputs(length))
}
