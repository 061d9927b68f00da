//! Errors of two to five bits that the bus does not see, found rather than waited for.
//!
//! CAN's CRC finds every error of up to five bits in the bits that it covers. What it does not find are errors that move stuff
//! bits: one wrong bit takes a stuff bit for data, or data for a stuff bit, a second one undoes that, and all between them is
//! received one place off. So the search takes pairs of such bits, and as many further bits as there are to be, each wrong by
//! itself. The CRC is linear: what a pair and further bits come to is a sum of syndromes, and the last bit is looked up by what
//! the sum lacks. Whatever is found goes through the whole receiver again.

use super::receiver::{Bit, CRC, HEADER, Run, received, stuffed};
use crc::CRC_15_CAN;

/// Stuffed bits until a wrong one is forgotten, at most; those that take longer are left out.
const FORGOTTEN: usize = 24;

/// A wrong bit, and what it does until the receiver is in step again.
#[derive(Debug, Clone, Copy)]
struct Flip {
    /// Place in the stuffed line.
    at: usize,
    /// The first place after which the receiver counts its run as before.
    until: usize,
    /// Place of the first plain bit that it touches, and of the first one after, as the sender counts.
    plain: (usize, usize),
    /// Plain bits that the receiver counts too many (1) or too few (-1).
    offset: i32,
    /// The plain bits that the receiver takes meanwhile, the first one lowest.
    bits: u64,
}

/// One frame and its wrong bits.
pub(crate) struct Search {
    plain: Vec<u8>,
    line: Vec<u8>,
    /// Stuffed bits that may be wrong: all but SOF, the data length and what is before it, to the end of the CRC.
    flips: Vec<Flip>,
    /// By place of a plain bit: the flip that makes this bit wrong and no other.
    single: Vec<Option<Flip>>,
    syndromes: Vec<u16>,
    /// By offset -1 and 1: sums of the syndromes of all bits before a place, where they are received one place off.
    shifted: [Vec<u16>; 2],
    covered: usize,
}

/// An error and the data that is received with it.
pub(crate) struct Unseen {
    pub(crate) id: u16,
    pub(crate) data: [u8; 8],
    pub(crate) len: usize,
}

impl Search {
    pub(crate) fn new(plain: Vec<u8>, table: &mut [Option<usize>]) -> Self {
        let (line, covered) = stuffed(&plain);
        let syndromes = syndromes(plain.len());
        table.fill(None);
        (HEADER..plain.len()).for_each(|place| table[usize::from(syndromes[place])] = Some(place));
        let shifted = [-1, 1].map(|offset: i32| {
            let mut sums = vec![0_u16; plain.len() + 1];
            for place in 0..plain.len() {
                let from = place as i32 - offset;
                let differs =
                    usize::try_from(from).ok().and_then(|from| plain.get(from)) != Some(&plain[place]);
                sums[place + 1] = sums[place] ^ if differs { syndromes[place] } else { 0 };
            }
            sums
        });
        let flips = flips(&line, covered, plain.len());
        let single = vec![None; plain.len()];
        let mut search = Self { plain, line, flips, single, syndromes, shifted, covered };
        for flip in &search.flips {
            if flip.offset == 0 && search.local(flip, 0) == Some(search.syndromes[flip.plain.0]) {
                search.single[flip.plain.0] = Some(*flip);
            }
        }
        search
    }

    /// Stuffed bits, of which any may be wrong.
    pub(crate) fn covered(&self) -> usize {
        self.covered
    }

    /// Syndrome of what a flip does where it stands, if the receiver is `before` places ahead when it comes.
    fn local(&self, flip: &Flip, before: i32) -> Option<u16> {
        let begin = usize::try_from(flip.plain.0 as i32 + before).ok()?;
        let taken = flip.plain.1 as i32 - flip.plain.0 as i32 + flip.offset;
        let mut sum = 0;
        for step in 0..usize::try_from(taken).ok()? {
            if *self.plain.get(begin + step)? != (flip.bits >> step & 1) as u8 {
                sum ^= self.syndromes[begin + step];
            }
        }
        Some(sum)
    }

    /// Every pair of wrong bits that leaves the length as it was, and its syndrome.
    fn pairs(&self) -> Vec<(Flip, Flip, u16)> {
        let mut pairs = Vec::new();
        let moving: Vec<&Flip> = self.flips.iter().filter(|flip| flip.offset != 0).collect();
        for (index, first) in moving.iter().enumerate() {
            let Some(begin) = self.local(first, 0) else { continue };
            for second in &moving[index + 1..] {
                if second.offset + first.offset != 0 || second.at < first.until {
                    continue;
                }
                let Some(end) = self.local(second, first.offset) else { continue };
                let sums = &self.shifted[usize::from(first.offset == 1)];
                let from = (first.plain.1 as i32 + first.offset) as usize;
                let to = (second.plain.0 as i32 + first.offset) as usize;
                if from <= to && to < sums.len() {
                    pairs.push((**first, **second, begin ^ end ^ sums[from] ^ sums[to]));
                }
            }
        }
        pairs
    }

    /// The wrong bit that receivers see at this place, if the bits of a pair are wrong too.
    fn further(&self, pair: &(Flip, Flip, u16), place: usize) -> Option<usize> {
        let (first, second, _) = pair;
        let of = |place: usize| self.single.get(place).copied().flatten();
        let outside = of(place).filter(|flip| flip.until <= first.at || flip.at >= second.until);
        let moved = usize::try_from(place as i32 - first.offset).ok().and_then(of);
        let inside = moved.filter(|flip| flip.at >= first.until && flip.until <= second.at);
        outside.or(inside).map(|flip| flip.at)
    }

    /// Calls `found` with every error of `count` bits of the searched kind that the receiver takes; with `thin` only every
    /// so manieth pair is looked at.
    pub(crate) fn unseen(
        &self,
        count: usize,
        thin: usize,
        table: &[Option<usize>],
        mut found: impl FnMut(Unseen),
    ) {
        for pair in self.pairs().iter().step_by(thin) {
            self.complete(
                pair,
                &mut vec![pair.0.at, pair.1.at],
                pair.2,
                HEADER,
                count - 2,
                table,
                &mut found,
            );
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn complete(
        &self,
        pair: &(Flip, Flip, u16),
        wrong: &mut Vec<usize>,
        syndrome: u16,
        from: usize,
        left: usize,
        table: &[Option<usize>],
        found: &mut impl FnMut(Unseen),
    ) {
        match left {
            0 if syndrome == 0 => found_by(&self.line, &self.plain, wrong, found),
            0 => (),
            1 => {
                // The places are in order, so that no error is found twice.
                let Some(place) = table[usize::from(syndrome)].filter(|place| *place >= from) else { return };
                if let Some(at) = self.further(pair, place) {
                    wrong.push(at);
                    found_by(&self.line, &self.plain, wrong, found);
                    wrong.pop();
                }
            }
            _ => {
                for place in from..self.plain.len() {
                    let Some(at) = self.further(pair, place) else { continue };
                    wrong.push(at);
                    let sum = syndrome ^ self.syndromes[place];
                    self.complete(pair, wrong, sum, place + 1, left - 1, table, found);
                    wrong.pop();
                }
            }
        }
    }
}

/// What the receiver takes from the line with these bits wrong, if it is not what was sent.
pub(crate) fn found_by(line: &[u8], plain: &[u8], wrong: &[usize], found: &mut impl FnMut(Unseen)) {
    let mut line = line.to_vec();
    wrong.iter().for_each(|at| line[*at] ^= 1);
    if let Some((id, data, len)) = received(&line) {
        let sent = super::receiver::plain(id, &data[..len]);
        if sent != plain {
            found(Unseen { id, data, len });
        }
    }
}

/// What a wrong plain bit at each place comes to in the CRC.
fn syndromes(len: usize) -> Vec<u16> {
    let mut syndromes = vec![0; len];
    let mut value = 1_u16;
    for place in (0..len).rev() {
        syndromes[place] = value;
        let carried = value << 1;
        value = if carried >> CRC == 1 { (carried ^ CRC_15_CAN.poly) & 0x7fff } else { carried };
    }
    syndromes
}

fn flips(line: &[u8], covered: usize, plain_len: usize) -> Vec<Flip> {
    let (mut run, mut plain) = (Run::START, 0);
    let mut flips = Vec::new();
    for at in 0..covered {
        if plain >= HEADER && plain < plain_len {
            flips.extend(flip(line, covered, at, run, plain));
        }
        plain += usize::from(run.take(line[at]) == Bit::Plain);
    }
    flips
}

/// The wrong bit at `at`, where the run and the number of plain bits so far are these; `None` if the receiver notices.
fn flip(line: &[u8], covered: usize, at: usize, run: Run, plain: usize) -> Option<Flip> {
    let (mut sent, mut taken) = (run, run);
    let (mut own, mut others, mut bits) = (plain, 0, 0_u64);
    for place in at..covered.min(at + FORGOTTEN) {
        let bit = line[place] ^ u8::from(place == at);
        own += usize::from(sent.take(line[place]) == Bit::Plain);
        match taken.take(bit) {
            Bit::Plain => {
                bits |= u64::from(bit) << others;
                others += 1;
            }
            Bit::Stuffed => (),
            Bit::Wrong => return None,
        }
        if sent == taken {
            let offset = others - (own - plain) as i32;
            return Some(Flip { at, until: place + 1, plain: (plain, own), offset, bits });
        }
    }
    None
}
