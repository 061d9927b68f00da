//! Every error says in a sentence what was found or what is allowed.

use slqg::actuator::{self, RejectedSequence};
use slqg::bank::InvalidLaw;
use slqg::blob::{self, BlobError, DesignId};
use slqg::controller::{self, CycleError, InvalidDesign, RejectedInputs, Sizes};
use slqg::estimator::RejectedMeasurement;
use slqg::event::InvalidTrigger;
use slqg::gains::InvalidGains;
use slqg::synthesis::InvalidProblem;
use slqg::tracking::{InvalidPreview, RejectedReference};
use slqg::tuning::{InvalidTuner, Kept, Unsolved};
use slqg::wire::can::{InvalidCompact, PackError, UnpackError};
use slqg::wire::{DecodeError, EncodeError};
use std::collections::HashSet;
use std::error::Error;

/// Checks that the messages are sentences, each another one, and that `numbers` are in them.
fn have_messages<E: Error>(errors: &[E], numbers: &[&str]) {
    let messages: Vec<String> = errors.iter().map(ToString::to_string).collect();
    for message in &messages {
        assert!(message.len() >= 10 && message.contains(' '), "{message:?}");
        assert!(!message.ends_with('.') && !message.contains('\n'), "{message:?}");
    }
    assert_eq!(messages.iter().collect::<HashSet<_>>().len(), errors.len(), "{messages:?}");
    for number in numbers {
        assert!(messages.iter().any(|message| message.contains(number)), "{number} in {messages:?}");
    }
}

#[test]
fn what_either_end_refuses_has_a_message() {
    use RejectedSequence as Sequence;
    have_messages(
        &[
            Sequence::Past,
            Sequence::RunOut,
            Sequence::Future,
            Sequence::NotFinite,
            Sequence::NoInputs,
            Sequence::TooLong,
        ],
        &[],
    );
    use actuator::RejectedFrame as AtActuator;
    have_messages(
        &[AtActuator::Decode(DecodeError::Kind(77)), AtActuator::Sequence(Sequence::Past)],
        &["77"],
    );
    use RejectedMeasurement as Measurement;
    let measurements =
        [Measurement::TooOld, Measurement::Future, Measurement::Duplicate, Measurement::NotFinite];
    have_messages(&measurements, &[]);
    use controller::RejectedFrame as AtController;
    have_messages(
        &[
            AtController::Decode(DecodeError::Version(9)),
            AtController::Measurement(Measurement::TooOld),
            AtController::Acknowledgement,
        ],
        &["9"],
    );
    have_messages(&[RejectedInputs::Length, RejectedInputs::NotFinite], &[]);
    use RejectedReference as Reference;
    have_messages(
        &[Reference::NoPreview, Reference::Dimension, Reference::NoSamples, Reference::NotFinite],
        &[],
    );
}

#[test]
fn what_does_not_fit_together_has_a_message() {
    let sizes = Sizes { cycles: 11, estimates: 22, ages: 33, sent: 44, inputs: 55 };
    let designs = [
        InvalidDesign::Capacity,
        InvalidDesign::DefaultInput,
        InvalidDesign::Memory(sizes),
        InvalidDesign::Length,
        InvalidDesign::Preview,
        InvalidDesign::NotAProbability,
        InvalidDesign::Grid,
    ];
    have_messages(&designs, &["11 cycles", "22", "33", "44", "55 inputs", "255", "0..=1"]);
    have_messages(&[CycleError::Law(InvalidDesign::Length), CycleError::Encode(EncodeError::TooMany)], &[]);
    use InvalidGains as Gains;
    let gains = [
        Gains::NoInputs,
        Gains::StateGainLength,
        Gains::InFlightGainLength,
        Gains::ArrivalLength,
        Gains::NotFinite,
        Gains::NotAProbability,
    ];
    have_messages(&gains, &[]);
    have_messages(&[InvalidLaw::Gains(Gains::NotFinite), InvalidLaw::NotAProbability], &[]);
    have_messages(&[InvalidTrigger::TableLength, InvalidTrigger::NotFinite], &[]);
    use InvalidPreview as Preview;
    have_messages(
        &[Preview::Empty, Preview::SequenceLength, Preview::DisplacedLength, Preview::NotFinite],
        &[],
    );
    have_messages(&[InvalidCompact::Identifiers, InvalidCompact::Grid], &[]);
}

#[test]
fn what_cannot_be_solved_has_a_message() {
    use InvalidProblem as Problem;
    let problems = [
        Problem::Empty,
        Problem::A,
        Problem::B,
        Problem::Q,
        Problem::R,
        Problem::Survival,
        Problem::Workspace,
    ];
    have_messages(&problems, &[]);
    let tuners = [
        InvalidTuner::Preview,
        InvalidTuner::Trigger,
        InvalidTuner::Basis,
        InvalidTuner::Problem(Problem::Workspace),
        InvalidTuner::Parameters,
    ];
    have_messages(&tuners, &[]);
    have_messages(&[Unsolved::Diverged, Unsolved::NotConverged, Unsolved::NotProved], &[]);
    let law = InvalidLaw::Gains(InvalidGains::NotFinite);
    have_messages(&[Kept::Unsolved(Unsolved::Diverged), Kept::Law(law)], &[]);
}

#[test]
fn what_is_no_frame_and_no_blob_has_a_message() {
    use DecodeError as Decode;
    let decode = [
        Decode::TooShort,
        Decode::Checksum,
        Decode::Version(201),
        Decode::Kind(202),
        Decode::Scalar(203),
        Decode::Dimension(204),
        Decode::Capacity(205),
        Decode::Ages(206),
        Decode::Length,
        Decode::Value,
        Decode::NotFinite,
    ];
    have_messages(&decode, &["201", "202", "203", "204", "205", "206"]);
    have_messages(&[EncodeError::BufferTooSmall, EncodeError::TooMany, EncodeError::NoAges], &["255"]);
    let pack = [
        PackError::Decode(Decode::Length),
        PackError::Values(41),
        PackError::Cycles(42),
        PackError::Counts(3),
        PackError::Period(9000001),
        PackError::Refused,
    ];
    have_messages(&pack, &["41", "42", "4095", "9000001"]);
    let unpack = [
        UnpackError::Identifier,
        UnpackError::Remote,
        UnpackError::Length(43),
        UnpackError::Check,
        UnpackError::Count,
        UnpackError::Encode(EncodeError::BufferTooSmall),
    ];
    have_messages(&unpack, &["43"]);
    let blobs = [
        BlobError::TooShort,
        BlobError::Checksum,
        BlobError::Magic,
        BlobError::Version(51),
        BlobError::Scalar(52),
        BlobError::DefaultInput(53),
        BlobError::Length,
        BlobError::Design(DesignId(0xabcd)),
        BlobError::States(54),
        BlobError::Inputs(55),
        BlobError::Sequence,
        BlobError::StorageTooSmall { needed: 56 },
        BlobError::Gains(InvalidGains::NotFinite),
    ];
    have_messages(&blobs, &["51", "52", "53", "abcd", "54", "55", "56"]);
    let encode = [
        blob::EncodeError::TooLarge,
        blob::EncodeError::Gains(InvalidGains::NotFinite),
        blob::EncodeError::BufferTooSmall,
    ];
    have_messages(&encode, &["255"]);
}
