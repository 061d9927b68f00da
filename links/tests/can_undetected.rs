//! Wrong bits that a CAN bus does not see: how often a compact frame with some is handed over, and how often its check then
//! fits as well. The table of `docs/can.md` is printed by the long one of these tests.

#[path = "wrong_bits/receiver.rs"]
mod receiver;
#[path = "wrong_bits/search.rs"]
mod search;

use embedded_can::{Frame, Id, StandardId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use search::{Search, Unseen, found_by};
use slqg::nalgebra::SVector;
use slqg::wire::can::{Compact, Grid, Identifiers, LARGEST_COUNT, LARGEST_OF_FULL_FRAME};
use slqg::wire::{self, Measurement};
use slqg::{Tick, blob::DesignId, sequence::ControlSequence};
use slqg_links::can;

const MEASUREMENT: u16 = 0x704;
const CONTROL: u16 = 0x705;

#[derive(Debug)]
struct BusFrame {
    id: Id,
    data: Vec<u8>,
}

impl Frame for BusFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Some(Self { id: id.into(), data: data.to_vec() })
    }
    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }
    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        false
    }
    fn id(&self) -> Id {
        self.id
    }
    fn dlc(&self) -> usize {
        self.data.len()
    }
    fn data(&self) -> &[u8] {
        &self.data
    }
}

fn standard(id: u16) -> Id {
    Id::Standard(StandardId::new(id).expect("11 bits"))
}

fn form() -> Compact<f32, 1, 2> {
    let identifiers = Identifiers {
        measurement: standard(MEASUREMENT),
        control: standard(CONTROL),
        acknowledgement: standard(0x706),
    };
    let inputs = Grid { step: SVector::from([0.25]), largest_count: LARGEST_OF_FULL_FRAME };
    let outputs = Grid { step: SVector::from([0.25; 2]), largest_count: LARGEST_COUNT };
    Compact::new(DesignId(0x1122_3344), identifiers, inputs, outputs).expect("a form")
}

/// A frame of the loop with values and a tick that can be anything: a full control frame, or a measurement of two outputs.
fn frame(random: &mut ChaCha8Rng, form: &Compact<f32, 1, 2>) -> (u16, Tick, Vec<u8>) {
    let tick = Tick(random.random());
    let mut buffer = [0; 64];
    let (id, full) = if random.random() {
        let inputs = [0; 3].map(|_| SVector::from([0.25 * f32::from(random.random_range(-4095_i16..=4095))]));
        (CONTROL, wire::encode_control(&ControlSequence { tick, inputs: &inputs }, &mut buffer))
    } else {
        let output = SVector::from([0; 2].map(|_| 0.25 * f32::from(random.random_range(-32767_i16..=32767))));
        (MEASUREMENT, wire::encode_measurement(&Measurement { tick, output }, &mut buffer))
    };
    let packed: BusFrame = form.pack(full.expect("room")).expect("fits");
    (id, tick, packed.data)
}

/// What became of errors of so many bits.
#[derive(Debug, Default)]
struct Tally {
    /// Errors that there are, of the frames looked at.
    errors: f64,
    /// Frames that the bus handed over with one of the loop's identifiers, and not what was sent.
    handed_over: u64,
    /// Of these, those that the loop takes.
    taken: u64,
}

impl Tally {
    fn note(&mut self, form: &Compact<f32, 1, 2>, tick: Tick, unseen: &Unseen) {
        if [MEASUREMENT, CONTROL].contains(&unseen.id) {
            self.handed_over += 1;
            let frame = BusFrame { id: standard(unseen.id), data: unseen.data[..unseen.len].to_vec() };
            self.taken += u64::from(form.unpack(&frame, tick, &mut [0; 64]).is_ok());
        }
    }

    /// Handed over for each one that is taken, four standard errors of a Poisson count below what was found.
    fn at_least(&self) -> f64 {
        let taken = self.taken as f64;
        self.handed_over as f64 / (taken + 4.0 * (taken + 1.0).sqrt())
    }
}

fn choose(of: usize, count: usize) -> f64 {
    (0..count).map(|taken| (of - taken) as f64 / (taken + 1) as f64).product()
}

/// Errors of `count` bits in `frames` random frames; `thin` as of [`Search::unseen`].
fn searched(count: usize, frames: usize, thin: usize) -> Tally {
    let mut random = ChaCha8Rng::seed_from_u64(count as u64);
    let (form, mut table, mut tally) = (form(), vec![None; 1 << receiver::CRC], Tally::default());
    for _ in 0..frames {
        let (id, tick, data) = frame(&mut random, &form);
        let search = Search::new(receiver::plain(id, &data), &mut table);
        tally.errors += choose(search.covered() - 1, count) / thin as f64;
        search.unseen(count, thin, &table, |unseen| tally.note(&form, tick, &unseen));
    }
    tally
}

#[test]
fn the_receiver_takes_what_the_simulated_bus_sends() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let form = form();
    for _ in 0..2000 {
        let (id, _, data) = frame(&mut random, &form);
        let (line, covered) = receiver::stuffed(&receiver::plain(id, &data));
        let sent = can::Frame::new(can::Id::base(id).expect("11 bits"), can::Format::Classic, &data)
            .expect("8 bytes");
        let bits: Vec<u8> = can::bits(&sent).into_iter().map(u8::from).collect();
        assert_eq!(line, bits[..covered + 9]);
        let (found, bytes, len) = receiver::received(&line).expect("nothing is wrong");
        assert_eq!((found, &bytes[..len]), (id, &data[..]));
    }
}

#[test]
fn an_error_that_moves_no_stuff_bit_is_seen_by_the_bus() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let form = form();
    for _ in 0..20 {
        let (id, _, data) = frame(&mut random, &form);
        let plain = receiver::plain(id, &data);
        let (line, covered) = receiver::stuffed(&plain);
        // One wrong bit, and every pair that is close together: a burst.
        for first in 1..covered {
            for second in first..covered.min(first + 8) {
                let wrong = if first == second { vec![first] } else { vec![first, second] };
                found_by(&line, &plain, &wrong, &mut |_| panic!("{wrong:?} of {data:02x?}"));
            }
        }
    }
}

#[test]
fn the_search_finds_every_pair_that_trying_all_of_them_finds() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (form, mut table) = (form(), vec![None; 1 << receiver::CRC]);
    let (mut tried, mut searched) = (0, 0);
    for _ in 0..30_000 {
        let (id, _, data) = frame(&mut random, &form);
        let plain = receiver::plain(id, &data);
        let search = Search::new(plain.clone(), &mut table);
        let mut of_frame = 0;
        search.unseen(2, 1, &table, |_| of_frame += 1);
        searched += of_frame;
        // Trying them all is slow: where the search has found something, and in a few frames where it has not.
        if of_frame > 0 || random.random_ratio(1, 100) {
            let (line, covered) = receiver::stuffed(&plain);
            for first in 1..covered {
                for second in first + 1..covered {
                    found_by(&line, &plain, &[first, second], &mut |_| tried += 1);
                }
            }
        }
    }
    assert!(searched >= 5 && tried == searched, "{tried} tried, {searched} searched");
}

#[test]
fn the_check_finds_all_but_one_in_two_hundred_of_the_errors_that_the_bus_does_not_see() {
    for (count, frames, thin) in [(3, 120_000, 1), (4, 4000, 1), (5, 800, 1)] {
        let tally = searched(count, frames, thin);
        assert!(tally.handed_over > 5000, "{count}: {tally:?}");
        assert!(tally.handed_over as f64 >= 200.0 * tally.taken as f64, "{count}: {tally:?}");
    }
}

#[test]
#[ignore = "takes minutes: prints the table of docs/can.md"]
fn errors_of_two_to_five_bits_that_the_bus_does_not_see() {
    println!("    bits  errors looked at  handed over      rate  taken     rate    ratio  at least");
    for (count, frames, thin) in [(2, 6_000_000, 1), (3, 400_000, 1), (4, 20_000, 1), (5, 3_000, 1)] {
        let tally = searched(count, frames, thin);
        let Tally { errors, handed_over, taken } = tally;
        println!(
            "    {count:<4}  {errors:>16.2e}  {handed_over:>11}  {:>8.1e}  {taken:>5}  {:>7.1e}  {:>7.0}  {:>8.0}",
            handed_over as f64 / errors,
            taken as f64 / errors,
            handed_over as f64 / taken as f64,
            tally.at_least(),
        );
        assert!(handed_over as f64 >= 200.0 * taken as f64, "{count}: {tally:?}");
    }
}
