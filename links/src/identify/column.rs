//! [`Column`]: what was seen at one end, in the order logged, a few bytes each.

use super::{
    bytes::{Place, Rows, put, put_time, take, take_time},
    time::Nanoseconds,
};

/// A packet seen at one of the ends.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Sighting {
    /// What its counter says, or its tick.
    pub(super) number: u32,
    pub(super) time: Nanoseconds,
}

/// Sightings at one end.
#[derive(Debug, Clone, Default)]
pub(super) struct Column {
    rows: Rows,
    last: Sighting,
    /// How many.
    pub(super) len: u64,
    /// Time of the earliest and of the latest.
    pub(super) span: Option<(Nanoseconds, Nanoseconds)>,
    /// Whether one is earlier than the one before.
    is_shuffled: bool,
}

impl Column {
    pub(super) fn push(&mut self, sighting: Sighting) {
        let row = self.rows.row();
        put(row, i64::from(sighting.number.wrapping_sub(self.last.number) as i32));
        put_time(row, sighting.time - self.last.time);
        self.is_shuffled |= self.len > 0 && sighting.time < self.last.time;
        self.len += 1;
        let (first, last) = self.span.unwrap_or((sighting.time, sighting.time));
        self.span = Some((first.min(sighting.time), last.max(sighting.time)));
        self.last = sighting;
    }

    /// In the order of time.
    pub(super) fn sorted(self) -> Self {
        if !self.is_shuffled {
            return self;
        }
        let mut all: Vec<Sighting> = self.drain().collect();
        all.sort_by_key(|sighting| sighting.time);
        all.into_iter().collect()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Sighting> + '_ {
        let (mut place, mut before) = (Place::default(), Sighting::default());
        std::iter::from_fn(move || {
            before = next(self.rows.at(&mut place)?, &mut place.byte, before);
            Some(before)
        })
    }

    /// Gives the sightings and their memory back.
    pub(super) fn drain(mut self) -> impl Iterator<Item = Sighting> {
        let (mut place, mut before) = (Place::default(), Sighting::default());
        std::iter::from_fn(move || {
            self.rows.forget(&mut place);
            before = next(self.rows.at(&mut place)?, &mut place.byte, before);
            Some(before)
        })
    }
}

impl FromIterator<Sighting> for Column {
    fn from_iter<I: IntoIterator<Item = Sighting>>(sightings: I) -> Self {
        let mut column = Self::default();
        sightings.into_iter().for_each(|sighting| column.push(sighting));
        column
    }
}

fn next(row: &[u8], at: &mut usize, before: Sighting) -> Sighting {
    let number = before.number.wrapping_add(take(row, at) as u32);
    Sighting { number, time: before.time + take_time(row, at) }
}
