//! All sessions of an end: what comes is opened, what goes is sealed.

use super::{
    Alarm, AlarmSettings, Association, Failures, HEAD_LEN, HELLO, HELLO_LEN, Nonces, NotSealed, Refused,
    SEALED, Session, failures::Watch, hello::Hello,
};
use crate::wire::{Kind, RawFrame, frame_len};

/// `S` sessions, each of another association.
///
/// ```
/// use core::num::NonZeroU64;
/// use slqg::authentication::{AlarmSettings, Association, Guard, Identity, Key, Keys, Nonces, Opened, Session, Side};
/// use slqg::{Age, Tick, blob::DesignId, wire};
///
/// /// On a board, of a counter that outlives power.
/// struct Counter(u64);
/// impl Nonces for Counter {
///     fn next(&mut self) -> NonZeroU64 {
///         self.0 += 1;
///         NonZeroU64::MIN.saturating_add(self.0)
///     }
/// }
/// let (mut first, mut second) = (Counter(100), Counter(200));
///
/// let keys = Keys { downstream: Key::new([1; 16]), upstream: Key::new([2; 16]) };
/// let identity = Identity { loop_id: 7, design: DesignId(0x1234_5678) };
/// let session = |side| Session::new(Association::Loop, side, identity, keys.clone());
/// let mut controller = Guard::new([session(Side::Upstream)], AlarmSettings::default());
/// let mut actuator = Guard::new([session(Side::Downstream)], AlarmSettings::default());
///
/// let mut hello = controller.due(&mut first);
/// while let Some(bytes) = hello {
///     let Ok(Opened::Hello(answer)) = actuator.open(&bytes, &mut second) else { unreachable!() };
///     let Some(answer) = answer else { break };
///     let Ok(Opened::Hello(next)) = controller.open(&answer, &mut first) else { unreachable!() };
///     hello = next;
/// }
///
/// let acknowledgement = wire::Acknowledgement::of(Tick(0), Age::Empty);
/// let (mut plain, mut sealed) = ([0; 12], [0; 21]);
/// let plain = wire::encode_acknowledgement::<f32>(&acknowledgement, &mut plain).expect("there is room");
/// let sealed = actuator.seal(plain, &mut sealed).expect("there is a session");
/// assert_eq!(controller.open(sealed, &mut first), Ok(Opened::Frame(plain)));
/// assert!(controller.open(sealed, &mut first).is_err(), "it was taken");
/// ```
#[derive(Debug)]
pub struct Guard<const S: usize> {
    sessions: [Session; S],
    watch: Watch,
    /// The newest gains that there were, and whether they were whole: gains that are not newer are refused.
    version: (u32, bool),
}

/// What was opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opened<'f> {
    /// A plain frame that its sender has sealed, and that was not taken before.
    Frame(&'f [u8]),
    /// A hello, and the answer that is to be sent.
    Hello(Option<[u8; HELLO_LEN]>),
}

impl<const S: usize> Guard<S> {
    /// A guard of these sessions, none of which stands yet.
    pub fn new(sessions: [Session; S], alarm: AlarmSettings) -> Self {
        Self { sessions, watch: Watch::new(alarm), version: (0, true) }
    }

    /// The sessions.
    pub fn sessions(&self) -> &[Session; S] {
        &self.sessions
    }

    /// Whether all sessions stand.
    pub fn stands(&self) -> bool {
        self.sessions.iter().all(Session::stands)
    }

    /// What was refused since the start.
    pub fn failures(&self) -> Failures {
        self.watch.total()
    }

    /// What has come too often in the last cycles. It changes nothing: frames that are right are taken as before.
    pub fn alarm(&self) -> Option<Alarm> {
        self.watch.alarm()
    }

    /// Gains up to this version, the number of their transfer, are refused from now on. Whoever makes the guard tells it the
    /// version that was kept over the last reset, and whoever puts gains in force the version that is to be kept.
    pub fn keep_version(&mut self, version: u32) {
        if version >= self.version.0 {
            self.version = (version, true);
        }
    }

    /// A cycle has begun: whoever is silent is asked, refused frames are forgotten by the alarm.
    pub fn cycle(&mut self) {
        self.watch.cycle();
        self.sessions.iter_mut().for_each(Session::cycle);
    }

    /// A hello that is due; to be called until there is none: at the start, and after each [`Guard::cycle`].
    pub fn due(&mut self, nonces: &mut impl Nonces) -> Option<[u8; HELLO_LEN]> {
        self.sessions.iter_mut().find_map(|session| session.due(nonces))
    }

    /// Takes bytes from the link: a sealed frame, whose plain one whoever decodes it checks as any, or a hello.
    ///
    /// # Errors
    /// Says why they are not taken. It is counted; nothing else has changed.
    pub fn open<'f>(&mut self, bytes: &'f [u8], nonces: &mut impl Nonces) -> Result<Opened<'f>, Refused> {
        let opened = match bytes.first() {
            Some(&HELLO) => self.take_hello(bytes, nonces).map(Opened::Hello),
            Some(&SEALED) => self.take_sealed(bytes).map(Opened::Frame),
            _ => Err(Refused::Form),
        };
        opened.inspect_err(|refused| self.watch.count(*refused))
    }

    fn take_hello(
        &mut self,
        bytes: &[u8],
        nonces: &mut impl Nonces,
    ) -> Result<Option<[u8; HELLO_LEN]>, Refused> {
        let hello = bytes.try_into().map_err(|_| Refused::Form)?;
        let number = Hello::association_of(bytes);
        let mut sessions = self.sessions.iter_mut();
        let session = sessions.find(|session| Some(session.association() as u8) == number);
        session.ok_or(Refused::Kind)?.take_hello(hello, nonces)
    }

    fn take_sealed<'f>(&mut self, bytes: &'f [u8]) -> Result<&'f [u8], Refused> {
        let (head, frame) = bytes.split_first_chunk::<HEAD_LEN>().ok_or(Refused::Form)?;
        let [_, tag @ ..] = head;
        let raw = RawFrame::of(frame).ok_or(Refused::Form)?;
        // Before the tag: what is damaged on the way costs little, and is no alarm.
        if !raw.is_whole() {
            return Err(Refused::Damaged);
        }
        let kind = raw.kind().ok_or(Refused::Kind)?;
        let (association, sender) = Association::of(kind).ok_or(Refused::Kind)?;
        let mut sessions = self.sessions.iter_mut();
        let session = sessions
            .find(|session| (session.association(), session.side()) == (association, sender.other()))
            .ok_or(Refused::Kind)?;
        session.open(kind, &raw, tag)?;
        if kind == Kind::GainsPart {
            self.take_version(raw.tick().0)?;
        }
        Ok(frame)
    }

    /// Parts of the newest gains, until they are whole.
    fn take_version(&mut self, version: u32) -> Result<(), Refused> {
        let (newest, is_whole) = self.version;
        if version < newest || version == newest && is_whole {
            return Err(Refused::Version);
        }
        self.version = (version, false);
        Ok(())
    }

    /// Seals a frame: `buffer` holds [`HEAD_LEN`] bytes more than `frame`.
    ///
    /// # Errors
    /// Says why the frame cannot be sent.
    pub fn seal<'b>(&mut self, frame: &[u8], buffer: &'b mut [u8]) -> Result<&'b [u8], NotSealed> {
        let sealed = buffer.get_mut(..HEAD_LEN + frame.len()).ok_or(NotSealed::BufferTooSmall)?;
        let (head, plain) = sealed.split_at_mut(HEAD_LEN);
        head.copy_from_slice(&self.head(frame)?);
        plain.copy_from_slice(frame);
        Ok(sealed)
    }

    /// The bytes that go before `frame`, for whoever has it in a buffer already.
    ///
    /// # Errors
    /// As [`Guard::seal`].
    pub fn head(&mut self, frame: &[u8]) -> Result<[u8; HEAD_LEN], NotSealed> {
        let raw = RawFrame::of(frame).ok_or(NotSealed::Kind)?;
        let kind = raw.kind().ok_or(NotSealed::Kind)?;
        let place = Association::of(kind).ok_or(NotSealed::Kind)?;
        let mut sessions = self.sessions.iter_mut();
        let session = sessions.find(|session| (session.association(), session.side()) == place);
        session.ok_or(NotSealed::Kind)?.head(kind, &raw, frame)
    }
}

/// Bytes of the sealed frame or hello that `bytes` begins with, for carriers that hand over more than was sent: as
/// [`frame_len`], and of the same kinds of frame.
pub fn sealed_len(bytes: &[u8]) -> Option<usize> {
    let len = match *bytes.first()? {
        HELLO => HELLO_LEN,
        SEALED => HEAD_LEN + frame_len(bytes.get(HEAD_LEN..)?)?,
        _ => return None,
    };
    (len <= bytes.len()).then_some(len)
}
