//! The handshake between two ends, and the frames of the session that comes of it.
//!
//! Each end has a nonce. Who sends a hello with both nonces has heard the other's, and the other knows that it is alive: mutual
//! authentication in three passes, ISO/IEC 9798-4, 5.2.2. A session's keys are derived from both nonces. An end's nonce serves one
//! session; then it takes a fresh one. So a recording proves nothing: it holds nonces that are spent.
//!
//! ```text
//! A: offer (a, 0)         B: answer (b, a)         A: session (a, b), confirms (a, b)         B: session (b, a)
//! ```
//!
//! A session stays in force until another one is proven. Hellos that prove nothing are answered, and change nothing else.

use super::{
    Association, HEAD_LEN, HELLO_LEN, Identity, Key, Keys, NotSealed, Refused, SEALED, Side, TAG_LEN,
    association::Binding, freshness::Freshness, hello::Hello, mac::Mac,
};
use crate::wire::{Kind, RawFrame};
use core::num::NonZeroU64;

/// Cycles of silence after which an end asks whether the session still stands.
const PATIENCE: u32 = 64;
/// Cycles between two hellos of an end that has had no answer.
const RETRY: u32 = 16;
/// Hellos that are answered in a cycle: whoever repeats them takes no more of link and processor than that.
const MOST_ANSWERS: u8 = 4;

/// Where nonces come from.
///
/// No number may ever come twice, not after a reset either: a boot counter in memory that outlives power, before a counter
/// that begins anew with each boot, or random numbers of 64 bits. They need not be secret.
pub trait Nonces {
    /// A number that has never been returned before.
    fn next(&mut self) -> NonZeroU64;
}

/// One end of an association.
pub struct Session {
    binding: Binding,
    side: Side,
    keys: Keys,
    /// Keys of hellos, sent and received.
    hello: [Key; 2],
    /// The nonce that the next session is to have.
    pending: Option<NonZeroU64>,
    agreed: Option<Agreed>,
    /// Cycles since the session was last known to stand, or since a hello was due.
    silence: u32,
    is_due: bool,
    answers: u8,
}

/// A session that both ends' nonces have proven.
struct Agreed {
    own: u64,
    peer: u64,
    incoming: Mac,
    outgoing: Mac,
    taken: Freshness,
    sent: Freshness,
}

impl Session {
    /// An end without a session.
    pub fn new(association: Association, side: Side, identity: Identity, keys: Keys) -> Self {
        let binding = Binding { association, identity };
        let hello = [side, side.other()].map(|sender| binding.hello(&keys, sender));
        Self { binding, side, keys, hello, pending: None, agreed: None, silence: 0, is_due: true, answers: 0 }
    }

    /// Which association it is one end of.
    pub fn association(&self) -> Association {
        self.binding.association
    }

    /// Which end.
    pub fn side(&self) -> Side {
        self.side
    }

    /// Whether there is a session that frames can be sent and taken in.
    pub fn stands(&self) -> bool {
        self.agreed.is_some()
    }

    /// A cycle has begun.
    pub(super) fn cycle(&mut self) {
        self.answers = 0;
        self.silence = self.silence.saturating_add(1);
        let is_old = self.agreed.as_ref().is_some_and(|agreed| agreed.taken.is_old() || agreed.sent.is_old());
        let patience = match self.stands() && !is_old {
            true if self.association().is_heard_by(self.side) => PATIENCE,
            true => return,
            false => RETRY,
        };
        if self.silence >= patience {
            self.is_due = true;
            // If nothing comes of it, another one is due after a while.
            self.silence = patience.saturating_sub(RETRY);
        }
    }

    /// The hello that is due, if one is.
    pub(super) fn due(&mut self, nonces: &mut impl Nonces) -> Option<[u8; HELLO_LEN]> {
        if !core::mem::take(&mut self.is_due) {
            return None;
        }
        let (own, echo) = match &self.agreed {
            Some(agreed) if !agreed.taken.is_old() && !agreed.sent.is_old() => (agreed.own, agreed.peer),
            _ => (self.nonce(nonces), 0),
        };
        Some(self.hello(own, echo, false))
    }

    /// Takes a hello; returns the answer, if there is one to be sent.
    pub(super) fn take_hello(
        &mut self,
        bytes: &[u8; HELLO_LEN],
        nonces: &mut impl Nonces,
    ) -> Result<Option<[u8; HELLO_LEN]>, Refused> {
        let mac = Mac::new(&self.hello[1]);
        let hello = Hello::read(bytes, self.association(), self.side.other(), &mac).ok_or(Refused::Forged)?;
        let stands = |agreed: &Agreed| (agreed.own, agreed.peer) == (hello.echo, hello.own);
        let is_proof = self.pending.is_some_and(|pending| pending.get() == hello.echo);
        let (own, has_session) = if is_proof {
            self.pending = None;
            self.agree(hello.echo, hello.own);
            (hello.echo, true)
        } else if self.agreed.as_ref().is_some_and(stands) {
            self.silence = 0;
            (hello.echo, true)
        } else {
            (self.nonce(nonces), false)
        };
        if hello.has_session && has_session || self.answers == MOST_ANSWERS {
            return Ok(None);
        }
        self.answers += 1;
        Ok(Some(self.hello(own, hello.own, has_session)))
    }

    fn agree(&mut self, own: u64, peer: u64) {
        let key = |sender, own, peer| Mac::new(&self.binding.frames(&self.keys, sender, own, peer));
        self.agreed = Some(Agreed {
            own,
            peer,
            incoming: key(self.side.other(), peer, own),
            outgoing: key(self.side, own, peer),
            taken: Freshness::default(),
            sent: Freshness::default(),
        });
        (self.silence, self.is_due) = (0, false);
    }

    fn nonce(&mut self, nonces: &mut impl Nonces) -> u64 {
        self.pending.get_or_insert_with(|| nonces.next()).get()
    }

    fn hello(&self, own: u64, echo: u64, has_session: bool) -> [u8; HELLO_LEN] {
        let (association, sender) = (self.association(), self.side);
        Hello { association, sender, has_session, own, echo }.write(&Mac::new(&self.hello[0]))
    }

    /// What goes before a plain frame of this kind. No cycle has two sealed frames: what the receiver would not take is not sent.
    pub(super) fn head(
        &mut self,
        kind: Kind,
        raw: &RawFrame<'_>,
        frame: &[u8],
    ) -> Result<[u8; HEAD_LEN], NotSealed> {
        let agreed = self.agreed.as_mut().ok_or(NotSealed::NoSession)?;
        if agreed.sent.take(kind, raw.tick(), begins(raw)) != Some(true) {
            // The receiver would refuse what comes, until a session begins in which nothing has come.
            self.agreed = None;
            self.is_due = true;
            return Err(NotSealed::Repeated);
        }
        let mut head = [SEALED; HEAD_LEN];
        let (_, tag) = head.split_at_mut(HEAD_LEN - TAG_LEN);
        tag.copy_from_slice(&agreed.outgoing.tag(frame));
        Ok(head)
    }

    /// Whether a frame with this tag is the peer's, and has not been taken before.
    pub(super) fn open(
        &mut self,
        kind: Kind,
        raw: &RawFrame<'_>,
        tag: &[u8; TAG_LEN],
    ) -> Result<(), Refused> {
        let agreed = self.agreed.as_mut().ok_or(Refused::NoSession)?;
        if !agreed.incoming.fits(raw.bytes(), tag) {
            return Err(Refused::Forged);
        }
        match agreed.taken.take(kind, raw.tick(), begins(raw)) {
            Some(true) => {
                self.silence = 0;
                Ok(())
            }
            Some(false) => Err(Refused::Repeated),
            None => {
                self.agreed = None;
                self.is_due = true;
                Err(Refused::NoSession)
            }
        }
    }
}

/// What a clock frame says of its cycle; of no account in others.
fn begins(raw: &RawFrame<'_>) -> bool {
    raw.payload().first().is_some_and(|begins| *begins != 0)
}

impl core::fmt::Debug for Session {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        // Neither keys nor what is derived from them.
        f.debug_struct("Session")
            .field("association", &self.association())
            .field("side", &self.side)
            .field("stands", &self.stands())
            .finish_non_exhaustive()
    }
}
