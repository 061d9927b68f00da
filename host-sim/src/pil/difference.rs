//! The first thing in which a board and the simulator differ.

use crate::size_class::LONGEST_SEQUENCE;
use nalgebra::SVector;
use slqg::{
    Scalar,
    actuator::Applied,
    sequence::ControlSequence,
    wire::{self, Tuned},
};

/// What differs, in which cycle.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Difference {
    /// The cycle.
    pub cycle: usize,
    /// What of it.
    pub what: String,
    /// As the simulator has it.
    pub host: String,
    /// As the board has it.
    pub board: String,
}

impl Difference {
    /// Of two control frames of the same dimensions; `None` if they are equal, byte by byte.
    pub(super) fn of_control<T: Scalar, const NU: usize>(
        cycle: usize,
        host: Option<&[u8]>,
        board: Option<&[u8]>,
    ) -> Option<Self> {
        if host == board {
            return None;
        }
        let differ = |what: String, host: String, board: String| Some(Self { cycle, what, host, board });
        let (Some(host), Some(board)) = (host, board) else {
            let said = |frame: Option<_>| if frame.is_some() { "sent" } else { "not sent" }.to_owned();
            return differ("the control frame".to_owned(), said(host), said(board));
        };
        let mut rooms = [[SVector::<T, NU>::zeros(); LONGEST_SEQUENCE]; 2];
        let [of_host, of_board] = &mut rooms;
        let sequences = (wire::decode_control(host, of_host), wire::decode_control(board, of_board));
        let (Ok(host), Ok(board)) = sequences else {
            return differ("the control frame".to_owned(), hexadecimal(host), hexadecimal(board));
        };
        if (host.tick, host.inputs.len()) != (board.tick, board.inputs.len()) {
            let said = |sequence: &ControlSequence<'_, T, NU>| {
                format!("{} inputs from cycle {} on", sequence.inputs.len(), sequence.tick.0)
            };
            return differ("the sequence".to_owned(), said(&host), said(&board));
        }
        for (step, (host, board)) in host.inputs.iter().zip(board.inputs).enumerate() {
            for (input, (host, board)) in host.iter().zip(board.iter()).enumerate() {
                if bits(*host) != bits(*board) {
                    let what = format!("input {} of entry {step} of the sequence", input + 1);
                    return differ(what, number(*host), number(*board));
                }
            }
        }
        None
    }

    /// Of what was applied, bit by bit.
    pub(super) fn of_applied<T: Scalar, const NU: usize>(
        cycle: usize,
        host: &Applied<T, NU>,
        board: &Applied<T, NU>,
    ) -> Option<Self> {
        let differ = |what: String, host: String, board: String| Some(Self { cycle, what, host, board });
        if (host.tick, host.age) != (board.tick, board.age) {
            let said = |applied: &Applied<T, NU>| format!("{:?} in cycle {}", applied.age, applied.tick.0);
            return differ("the age of what was applied".to_owned(), said(host), said(board));
        }
        let mut inputs = host.input.iter().zip(board.input.iter()).enumerate();
        let (input, (host, board)) = inputs.find(|(_, (host, board))| bits(**host) != bits(**board))?;
        differ(format!("applied input {}", input + 1), number(*host), number(*board))
    }

    /// Of what a controller did that tunes itself.
    pub(super) fn of_tuning(cycle: usize, host: Option<Tuned>, board: Option<Tuned>) -> Option<Self> {
        (host != board).then(|| Self {
            cycle,
            what: "what the tuner did".to_owned(),
            host: format!("{host:?}"),
            board: format!("{board:?}"),
        })
    }

    /// Of two acknowledgements, byte by byte.
    pub(super) fn of_acknowledgement(cycle: usize, host: Option<&[u8]>, board: &[u8]) -> Option<Self> {
        let host = host.unwrap_or_default();
        (host != board).then(|| Self {
            cycle,
            what: "the acknowledgement".to_owned(),
            host: hexadecimal(host),
            board: hexadecimal(board),
        })
    }
}

/// Widening is exact, and keeps the sign of zero.
fn bits<T: Scalar>(value: T) -> u64 {
    value.widen().to_bits()
}

fn number<T: Scalar>(value: T) -> String {
    format!("{:e} ({:#018x})", value.widen(), bits(value))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use slqg::{Age, Tick};

    fn control(last: f32) -> Vec<u8> {
        let inputs = [0.0, 1.5, last].map(|input| SVector::from([input]));
        let mut buffer = [0; 64];
        let sequence = ControlSequence { tick: Tick(3), inputs: &inputs };
        wire::encode_control(&sequence, &mut buffer).unwrap().to_vec()
    }

    #[test]
    fn one_bit_in_one_input_is_a_difference() {
        let (host, board) = (control(2.0), control(2.0_f32.next_up()));
        assert_eq!(Difference::of_control::<f32, 1>(7, Some(&host), Some(&host)), None);
        let difference = Difference::of_control::<f32, 1>(7, Some(&host), Some(&board)).unwrap();
        assert_eq!((difference.cycle, &*difference.what), (7, "input 1 of entry 2 of the sequence"));
        let difference = Difference::of_control::<f32, 1>(7, Some(&host), None).unwrap();
        assert_eq!((&*difference.host, &*difference.board), ("sent", "not sent"));
    }

    #[test]
    fn the_sign_of_zero_and_the_age_count() {
        let applied = |input: f32, age| Applied { tick: Tick(1), input: SVector::from([input]), age };
        let host = applied(0.0, Age::Empty);
        assert_eq!(Difference::of_applied(1, &host, &host), None);
        assert!(Difference::of_applied(1, &host, &applied(-0.0, Age::Empty)).is_some());
        assert!(Difference::of_applied(1, &host, &applied(0.0, Age::Steps(1))).is_some());
    }
}
