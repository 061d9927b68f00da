//! Gains that come over the link in parts: a law that is refused leaves the one in force as it was, and one that is taken is in force
//! as it was sent.

use crate::blob::made;
use crate::script::{any_bytes, number, up_to, whole};
use arbitrary::{Result, Unstructured};
use slqg::DefaultInput;
use slqg::bank::{Bank, memory_len};
use slqg::blob::{self, DesignId, OVERHEAD, Reception, Shape};
use slqg::controller::Law;
use slqg::gains::{Gains, Tables};
use slqg::wire::{self, GainsPart, Verdict};

const NX: usize = 2;
const NU: usize = 1;
/// Bytes of the longest blob that there is room for.
const ROOM: usize = 128;
/// Dimensions of the laws.
const SHAPE: Shape = Shape { length: 2, states: NX, inputs: NU, default_input: DefaultInput::Zero };
/// Numbers of `Lx`, `M` and `r`.
const LX: usize = 4;
const M: usize = 2;
const NUMBERS: usize = LX + M + 1;
/// The plant.
pub(crate) const DESIGN: DesignId = DesignId(0x1122_3344);

/// The law that is to be in force: `q(0)`, and the tables one after the other.
type InForce = Option<(f32, Vec<f32>)>;

/// Plays a script of what comes to a bank.
pub fn check(bytes: &[u8]) {
    // A script that ends early has ended.
    let _ = play(&mut Unstructured::new(bytes));
}

fn play(script: &mut Unstructured<'_>) -> Result<()> {
    let mut memory = [f32::NAN; memory_len(&SHAPE)];
    let mut bank =
        Bank::<f32, NX, NU>::new(SHAPE.length, SHAPE.default_input, &mut memory).expect("memory enough");
    let mut reception = Reception::<ROOM>::default();
    let mut expected: InForce = None;
    while !script.is_empty() {
        match up_to(script, 6)? {
            0 => {
                let bytes = if up_to(script, 1)? == 0 { made(script)? } else { whole(any_bytes(script)?) };
                let chance = number::<f32>(script)? / 10.0;
                load(&mut bank, &bytes, chance, &mut expected);
            }
            1 => {
                let (blob, chance) = (own_blob(script)?, number::<f32>(script)? / 10.0);
                load(&mut bank, &blob, chance, &mut expected);
            }
            2 => {
                let (blob, chance) = (own_blob(script)?, number::<f32>(script)? / 10.0);
                let (transfer, most) = (up_to(script, 3)?.into(), usize::from(up_to(script, 40)?.max(1)));
                for (place, bytes) in blob.chunks(most).enumerate() {
                    let part = GainsPart {
                        transfer,
                        offset: (place * most) as u16,
                        total: blob.len() as u16,
                        bytes,
                    };
                    take(&mut reception, &mut bank, &part, chance, &mut expected);
                }
            }
            3 => {
                let (transfer, offset) = (up_to(script, 3)?.into(), script.arbitrary()?);
                let part =
                    GainsPart { transfer, offset, total: script.arbitrary()?, bytes: any_bytes(script)? };
                take(&mut reception, &mut bank, &part, 0.5, &mut expected);
            }
            4 => {
                // Whatever is written, the law in force is another one.
                let (place, value) = (up_to(script, NUMBERS as u8 - 1)?, number(script)?);
                bank.spare()[usize::from(place)] = value;
            }
            5 => {
                let spare = bank.spare().to_vec();
                let chance = number::<f32>(script)? / 10.0;
                let is_law =
                    spare.iter().all(|value| value.is_finite()) && (0.0..=1.0).contains(&spare[NUMBERS - 1]);
                let switched = bank.switch(chance);
                assert_eq!(switched.is_ok(), is_law && (0.0..=1.0).contains(&chance), "{switched:?}");
                if switched.is_ok() {
                    expected = Some((chance, spare));
                }
            }
            _ => {
                bank.withdraw();
                expected = None;
            }
        }
        assert!(is_in_force(&bank, &expected), "{:?} instead of {expected:?}", bank.law());
    }
    Ok(())
}

/// A blob of the bank's plant and dimensions, but for a byte that may be another one.
fn own_blob(script: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let mut numbers = [0.0_f32; NUMBERS];
    for number in &mut numbers {
        *number = crate::script::number(script)?;
    }
    numbers[NUMBERS - 1] /= 10.0;
    let finite = numbers.map(|number| if number.is_finite() { number } else { 0.0 });
    let chance = [finite[NUMBERS - 1].clamp(0.0, 1.0)];
    let tables = Tables::check(&finite[..LX], &finite[LX..LX + M], &chance).expect("finite");
    let mut buffer = [0; ROOM];
    let mut blob = blob::encode(DESIGN, &SHAPE, &tables, &mut buffer).expect("there is room").to_vec();
    let (place, change) = (usize::from(up_to(script, ROOM as u8)?), script.arbitrary::<u8>()?);
    if let Some(byte) = blob.get_mut(place) {
        *byte ^= change;
    }
    Ok(if up_to(script, 1)? == 0 { whole(&blob) } else { blob })
}

/// Hands a part to the bank, as a node does.
fn take(
    reception: &mut Reception<ROOM>,
    bank: &mut Bank<'_, f32, NX, NU>,
    part: &GainsPart<'_>,
    chance: f32,
    expected: &mut InForce,
) {
    let mut buffer = [0; ROOM + wire::gains_part_len(0)];
    let frame = wire::encode_gains_part::<f32>(part, &mut buffer).expect("there is room");
    let part = wire::decode_gains_part::<f32>(frame).expect("what was encoded");
    match reception.take(&part) {
        Ok(whole) => {
            assert_eq!(whole.len(), usize::from(part.total));
            assert!(whole.ends_with(part.bytes), "it ends with the part that came last");
            load(bank, whole, chance, expected);
        }
        Err(answer) => {
            assert!(usize::from(answer.received) <= ROOM);
            assert!(matches!(answer.verdict, Verdict::Incomplete | Verdict::TooLong));
        }
    }
}

/// Loads a blob; what is to be in force then is what it says, or what was before.
fn load(bank: &mut Bank<'_, f32, NX, NU>, blob: &[u8], chance: f32, expected: &mut InForce) {
    match bank.load(blob, DESIGN, chance) {
        Ok(()) => {
            let numbers = blob[OVERHEAD - 4..blob.len() - 4].chunks_exact(4);
            let numbers: Vec<f32> =
                numbers.map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four"))).collect();
            assert!(numbers.iter().all(|value| value.is_finite()) && (0.0..=1.0).contains(&chance));
            assert_eq!(numbers.len(), NUMBERS);
            assert_eq!(whole(blob), blob, "its checksum is right");
            *expected = Some((chance, numbers));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Whether this law is in force, and no other.
fn is_in_force(bank: &Bank<'_, f32, NX, NU>, expected: &InForce) -> bool {
    let law = expected.as_ref().map(|(arrives_at_once, numbers)| {
        let ([lx, m], chance) = ([&numbers[..LX], &numbers[LX..LX + M]], &numbers[LX + M..]);
        let tables = Tables::check(lx, m, chance).expect("only gains are put in force");
        let gains = Gains::check(SHAPE.length, SHAPE.default_input, tables).expect("of the bank's shape");
        Law { gains, arrives_at_once: *arrives_at_once }
    });
    bank.law() == law
}
