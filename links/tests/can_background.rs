//! The helper that makes other traffic for a given load.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{Background, BackgroundError, Bus, Id, NodeId, Pattern, Settings, Stuffing};
use std::collections::HashSet;

fn reserved() -> Vec<Id> {
    [0x080, 0x100, 0x200].map(|value| Id::base(value).unwrap()).to_vec()
}

#[test]
fn the_load_is_the_one_asked_for() {
    for bit_rate in [125_000, 250_000, 500_000, 1_000_000] {
        for load in [0.0, 0.003, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99] {
            let background = Background::load(load, bit_rate, &reserved(), 3..7).unwrap();
            let part = |source: &slqg_links::can::Source| match source.pattern {
                Pattern::Periodic { period, .. } => 135.0 / f64::from(bit_rate) * 1e9 / period as f64,
                Pattern::Sporadic { .. } => panic!("background traffic is periodic"),
            };
            let sum: f64 = background.sources.iter().map(part).sum();
            assert!((sum - load).abs() < 1e-6, "{sum} for {load} at {bit_rate} bit/s");
        }
    }
}

#[test]
fn the_bus_is_as_busy_as_the_load_says() {
    let sources = Background::load(0.5, 500_000, &reserved(), 0..4).unwrap().sources;
    let load = |stuffing| {
        let settings = Settings { sources: sources.clone(), stuffing, ..Settings::new(500_000, 4) };
        let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(1)).unwrap();
        bus.run_until(20_000_000_000);
        bus.statistics().load()
    };
    assert!((load(Stuffing::Worst) - 0.5).abs() < 1e-3, "{}", load(Stuffing::Worst));
    let actual = load(Stuffing::Actual);
    assert!((0.40..0.46).contains(&actual), "{actual}");
}

#[test]
fn identifiers_are_free_ones_above_and_below_the_reserved_on_several_nodes() {
    let background = Background::load(0.4, 500_000, &reserved(), 3..7).unwrap();
    let ids: HashSet<Id> = background.sources.iter().map(|source| source.id).collect();
    assert_eq!(ids.len(), background.sources.len());
    for id in reserved() {
        assert!(
            !ids.contains(&id) && ids.iter().any(|other| *other < id) && ids.iter().any(|other| *other > id)
        );
    }
    let nodes: HashSet<NodeId> = background.sources.iter().map(|source| source.node).collect();
    assert_eq!(nodes, (3..7).map(NodeId).collect());
}

#[test]
fn the_same_request_gives_the_same_messages() {
    let ask = || Background::load(0.4, 500_000, &reserved(), 3..7).unwrap();
    assert_eq!(ask(), ask());
}

#[test]
fn a_load_that_cannot_be_is_refused() {
    for load in [-0.1, 1.0, f64::NAN] {
        assert!(
            matches!(Background::load(load, 500_000, &[], 0..1), Err(BackgroundError::Load(_))),
            "{load}"
        );
    }
    assert_eq!(Background::load(0.5, 500_000, &[], 3..3), Err(BackgroundError::NoNodes));
    assert!(matches!(Background::load(0.5, 83_333, &[], 0..1), Err(BackgroundError::Rate(_))));
}
