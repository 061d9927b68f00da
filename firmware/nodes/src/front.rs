//! What stands between a board's line and its node: a guard, if the nodes are built with keys, else nothing.

#[cfg(feature = "authentication")]
mod keyed {
    use crate::board::Node;
    use crate::dimensions::DESIGN_ID;
    use crate::guarded::{Guarded, Vault};
    use crate::hardware::KEPT;
    use core::num::NonZeroU64;
    use slqg::authentication::{
        AlarmSettings, Association, Guard, HEAD_LEN, HELLO_LEN, Identity, Keys, Nonces, Session, Side,
    };

    include!(concat!(env!("OUT_DIR"), "/keys.rs"));

    const IDENTITY: Identity = Identity { loop_id: LOOP_ID, design: DESIGN_ID };
    /// Words of the memory that outlives power: how often the board was started, and the newest version of gains.
    const BOOTS: usize = 0;
    const VERSION: usize = 4;

    /// Bytes of the longest frame on the line, where the node's longest has `len`.
    pub const fn longest(len: usize) -> usize {
        if len + HEAD_LEN > HELLO_LEN { len + HEAD_LEN } else { HELLO_LEN }
    }

    /// A controller node behind its guard.
    pub fn of_controller(node: impl Node) -> impl Node {
        let session = |association, side, keys| Session::new(association, side, IDENTITY, keys);
        let of_loop = Keys { downstream: CONTROL, upstream: ACKNOWLEDGEMENT };
        let sessions = [
            session(Association::Timing, Side::Downstream, Keys::one_way(CLOCK)),
            session(Association::Sensing, Side::Downstream, Keys::one_way(MEASUREMENT)),
            session(Association::Loop, Side::Upstream, of_loop),
            session(Association::Service, Side::Downstream, Keys::one_way(GAINS)),
        ];
        let guard = cortex_m::singleton!(: Guard<4> = Guard::new(sessions, AlarmSettings::default()));
        Guarded::new(node, only(guard), Kept::new())
    }

    /// An actuator node behind its guard.
    pub fn of_actuator(node: impl Node) -> impl Node {
        let session = |association, keys| Session::new(association, Side::Downstream, IDENTITY, keys);
        let of_loop = Keys { downstream: CONTROL, upstream: ACKNOWLEDGEMENT };
        let sessions =
            [session(Association::Timing, Keys::one_way(CLOCK)), session(Association::Loop, of_loop)];
        let guard = cortex_m::singleton!(: Guard<2> = Guard::new(sessions, AlarmSettings::default()));
        Guarded::new(node, only(guard), Kept::new())
    }

    fn only<const S: usize>(guard: Option<&'static mut Guard<S>>) -> &'static mut Guard<S> {
        let Some(guard) = guard else { panic!("a board has one node") };
        guard
    }

    /// The board's memory that outlives power: who starts the emulator counts the boots in it.
    struct Kept {
        boots: u32,
        count: u32,
    }

    impl Kept {
        fn new() -> Self {
            Self { boots: KEPT.read(BOOTS), count: 0 }
        }
    }

    impl Nonces for Kept {
        fn next(&mut self) -> NonZeroU64 {
            if ARE_KNOWN && self.count == 0 {
                defmt::warn!("these keys are for tests: everybody knows them");
            }
            // A board that takes 2^32 nonces in one boot has been attacked for years.
            self.count = self.count.saturating_add(1);
            let nonce = u64::from(self.boots) << 32 | u64::from(self.count);
            NonZeroU64::new(nonce).unwrap_or(NonZeroU64::MIN)
        }
    }

    impl Vault for Kept {
        fn gains_version(&self) -> u32 {
            KEPT.read(VERSION)
        }

        fn keep_gains_version(&mut self, version: u32) {
            KEPT.write(VERSION, version);
        }
    }
}

#[cfg(not(feature = "authentication"))]
mod plain {
    use crate::board::Node;

    /// Bytes of the longest frame on the line, where the node's longest has `len`.
    pub const fn longest(len: usize) -> usize {
        len
    }

    /// A controller node, as it is.
    pub fn of_controller<N: Node>(node: N) -> N {
        node
    }

    /// An actuator node, as it is.
    pub fn of_actuator<N: Node>(node: N) -> N {
        node
    }
}

#[cfg(feature = "authentication")]
pub use keyed::{longest, of_actuator, of_controller};
#[cfg(not(feature = "authentication"))]
pub use plain::{longest, of_actuator, of_controller};
