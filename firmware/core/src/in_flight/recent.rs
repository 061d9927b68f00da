//! The sequences of the last cycles, in a ring.

use crate::{Scalar, Tick, sequence::ControlSequence};
use heapless::Vec;

/// What was sent in each of the last `C` cycles, sequences of up to `N` inputs.
///
/// Of a cycle in which nothing was sent it keeps a sequence without inputs: who wants an input looks at the length anyway.
#[derive(Debug, Clone)]
pub(super) struct Recent<T: Scalar, const NU: usize, const N: usize, const C: usize> {
    cycles: [ControlSequence<T, NU, N>; C],
    /// Where the newest is.
    newest: usize,
}

impl<T: Scalar, const NU: usize, const N: usize, const C: usize> Default for Recent<T, NU, N, C> {
    fn default() -> Self {
        Self { cycles: [const { ControlSequence { tick: Tick(0), inputs: Vec::new() } }; C], newest: 0 }
    }
}

impl<T: Scalar, const NU: usize, const N: usize, const C: usize> Recent<T, NU, N, C> {
    /// Takes what was sent in one more cycle, for that of `C` cycles before.
    pub(super) fn push(&mut self, sent: ControlSequence<T, NU, N>) -> ControlSequence<T, NU, N> {
        self.newest = after::<C>(self.newest);
        match self.cycles.get_mut(self.newest) {
            Some(oldest) => core::mem::replace(oldest, sent),
            None => sent,
        }
    }

    /// What was sent `ago` cycles before the newest.
    pub(super) fn get(&self, ago: usize) -> Option<&ControlSequence<T, NU, N>> {
        if ago < C { self.cycles.get(self.place(ago)) } else { None }
    }

    /// What was sent less than `since <= C` cycles before the newest, oldest first, and how many cycles before it.
    #[inline(always)]
    pub(super) fn since(&self, since: usize) -> Since<'_, T, NU, N, C> {
        Since { recent: self, place: self.place(since), ago: since }
    }

    /// All sequences that were sent, newest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = &ControlSequence<T, NU, N>> {
        (0..C).filter_map(|ago| self.get(ago)).filter(|sent| !sent.inputs.is_empty())
    }

    /// Where that of `ago` cycles before the newest is; for `C` it is where the newest is, too.
    fn place(&self, ago: usize) -> usize {
        if ago <= self.newest { self.newest - ago } else { (self.newest + C).saturating_sub(ago) }
    }
}

/// See [`Recent::since`].
pub(super) struct Since<'r, T: Scalar, const NU: usize, const N: usize, const C: usize> {
    recent: &'r Recent<T, NU, N, C>,
    place: usize,
    ago: usize,
}

impl<'r, T: Scalar, const NU: usize, const N: usize, const C: usize> Iterator for Since<'r, T, NU, N, C> {
    type Item = (usize, &'r ControlSequence<T, NU, N>);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        self.ago = self.ago.checked_sub(1)?;
        self.place = after::<C>(self.place);
        Some((self.ago, self.recent.cycles.get(self.place)?))
    }
}

/// The place after `place` in a ring of `C`.
#[inline(always)]
const fn after<const C: usize>(place: usize) -> usize {
    if place + 1 < C { place + 1 } else { 0 }
}
