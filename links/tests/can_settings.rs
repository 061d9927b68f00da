//! Settings with which no bus can run, and frames that a bus cannot take.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{
    Attempts, Bus, Errors, Format, Frame, Id, NodeId, OfferError, Pattern, Settings, SettingsError, Source,
    Time,
};

const MILLISECOND: Time = 1_000_000;

fn base(value: u16) -> Id {
    Id::base(value).unwrap()
}

fn frame(id: Id) -> Frame {
    Frame::new(id, Format::Classic, &[0x5A; 8]).unwrap()
}

fn idle_bus() -> Bus {
    Bus::new(Settings::new(500_000, 4), ChaCha8Rng::seed_from_u64(7)).unwrap()
}

fn source(id: Id, node: u16) -> Source {
    Source {
        node: NodeId(node),
        id,
        format: Format::Classic,
        bytes: 8,
        pattern: Pattern::Periodic { period: MILLISECOND, offset: 0, jitter: 0 },
        attempts: Attempts::Unlimited,
    }
}

#[test]
fn two_nodes_with_one_identifier_are_refused() {
    let id = base(0x100);
    let sources = vec![source(id, 0), source(id, 1)];
    let settings = Settings { sources, ..Settings::new(500_000, 2) };
    let error = Bus::new(settings, ChaCha8Rng::seed_from_u64(0)).unwrap_err();
    assert_eq!(error, SettingsError::SharedIdentifier { id, first: NodeId(0), second: NodeId(1) });

    let identifiers = vec![(id, NodeId(1))];
    let sources = vec![source(id, 0)];
    let settings = Settings { sources, identifiers, ..Settings::new(500_000, 2) };
    assert!(matches!(
        Bus::new(settings, ChaCha8Rng::seed_from_u64(0)),
        Err(SettingsError::SharedIdentifier { .. })
    ));

    let mut bus = idle_bus();
    bus.offer(0, NodeId(0), frame(id), 0).unwrap();
    let error = bus.offer(0, NodeId(1), frame(id), 1).unwrap_err();
    assert_eq!(error, OfferError::ForeignIdentifier { id, node: NodeId(1), owner: NodeId(0) });
}

#[test]
fn settings_that_cannot_be_are_refused_with_what_to_do() {
    let refused = |change: fn(&mut Settings)| {
        let mut settings = Settings::new(500_000, 2);
        settings.sources.push(source(base(0x100), 0));
        change(&mut settings);
        Bus::new(settings, ChaCha8Rng::seed_from_u64(0)).unwrap_err().to_string()
    };
    assert!(refused(|settings| settings.bit_rate = 83_333).contains("whole number of nanoseconds"));
    assert!(refused(|settings| settings.nodes = 1).contains("at least 2"));
    assert!(refused(|settings| settings.queue = 0).contains("at least 1"));
    assert!(refused(|settings| settings.sources[0].bytes = 9).contains("source 0: found 9 bytes"));
    assert!(refused(|settings| settings.sources[0].node = NodeId(2)).contains("nodes are 0 to 1"));
    assert!(
        refused(|settings| settings.sources[0].format = Format::Fd { bit_rate_switch: true })
            .contains("data_bit_rate")
    );
    assert!(
        refused(
            |settings| settings.sources[0].pattern = Pattern::Periodic { period: 5, offset: 0, jitter: 6 }
        )
        .contains("at most the period")
    );
    assert!(
        refused(|settings| settings.sources[0].pattern = Pattern::Sporadic { minimum: 0, extra: 0 })
            .contains("must be positive")
    );
    assert!(
        refused(|settings| settings.errors = Errors::Independent { probability: 1.0 }).contains("below 1")
    );
}

#[test]
fn a_frame_for_the_past_or_for_nobody_is_refused() {
    let mut bus = idle_bus();
    bus.run_until(100);
    assert_eq!(bus.offer(99, NodeId(0), frame(base(1)), 0), Err(OfferError::Past { at: 99, now: 100 }));
    assert_eq!(
        bus.offer(100, NodeId(4), frame(base(1)), 0),
        Err(OfferError::NoSuchNode { node: NodeId(4), nodes: 4 })
    );
    let switched = Frame::new(base(1), Format::Fd { bit_rate_switch: true }, &[]).unwrap();
    assert_eq!(bus.offer(100, NodeId(0), switched, 0), Err(OfferError::NoDataBitRate));
}
