//! The record of a cycle tells what became of every frame: also of acknowledgements, and of copies that links make.

use gain_gen::design::{Acknowledgement, DelayDistribution, Design, Link};
use host_sim::{
    closed_loop::CycleRecord,
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
};
use slqg_links::{loop_bus::Role, path::Fate};

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const CAN: &str = include_str!("../../designs/pendulum_can.toml");
const STEPS: usize = 400;

fn design(text: &str) -> Design {
    Design::parse(text, "design.toml").expect("a design")
}

fn cycles(design: &Design, kind: Kind) -> Vec<CycleRecord> {
    let contender = Contender::new(kind, design, STEPS).expect("a stabilised loop");
    let plan = Plan { runs: 1, steps: STEPS, seed: 5 };
    let simulate = Simulate { design, contender: &contender, plan, done: &|| () };
    simulate.outcome().expect("it can be simulated").first_run
}

/// The pendulum with acknowledgements over a link, and copies of this share of all packets.
fn doubled(share: f64) -> Design {
    let mut design = design(PENDULUM);
    let mut told = Link::independent(DelayDistribution::new(vec![0.5, 0.2, 0.1]).expect("a distribution"));
    told.duplicates = share;
    design.network.acknowledgement = Acknowledgement::Over(told);
    design.network.sensor_to_controller.duplicates = share;
    design.network.controller_to_actuator.duplicates = share;
    design
}

fn fate(record: &CycleRecord, role: Role) -> Option<Fate> {
    match role {
        Role::Measurement => record.measurement_frame,
        Role::Control => record.control_frame,
        Role::Acknowledgement => record.acknowledgement_frame,
    }
}

#[test]
fn acknowledgements_are_as_late_as_their_link_says() {
    let mut counts = [0_usize; 4];
    for record in cycles(&doubled(0.0), Kind::Slqg) {
        assert!(record.arrivals.is_empty(), "without copies the fates tell everything");
        match record.acknowledgement_frame {
            Some(Fate::Delayed(delay)) => counts[delay] += 1,
            Some(Fate::Lost) => counts[3] += 1,
            other => panic!("{other:?}"),
        }
    }
    for (count, share) in counts.into_iter().zip([0.5, 0.2, 0.1, 0.2]) {
        let deviation = (STEPS as f64 * share * (1.0 - share)).sqrt();
        assert!((count as f64 - STEPS as f64 * share).abs() < 4.0 * deviation, "{counts:?}");
    }
}

#[test]
fn an_acknowledgement_has_no_fate_where_there_is_no_way_back_and_is_there_at_once_where_it_is_instant() {
    let design = design(PENDULUM);
    assert!(cycles(&design, Kind::SlqgUdp).iter().all(|record| record.acknowledgement_frame.is_none()));
    let instant = cycles(&design, Kind::Slqg);
    assert!(instant.iter().all(|record| record.acknowledgement_frame == Some(Fate::Delayed(0))));
}

#[test]
fn on_a_bus_all_fates_but_the_last_are_decided() {
    for record in &cycles(&design(CAN), Kind::Slqg)[..STEPS - 20] {
        for role in Role::ALL {
            assert_ne!(fate(record, role), Some(Fate::Open), "{role:?}");
        }
    }
}

#[test]
fn every_packet_that_arrives_is_taken_when_its_fate_says_and_some_once_more() {
    let cycles = cycles(&doubled(0.25), Kind::Slqg);
    let taken = |at: usize, role, sent| {
        let record: Option<&CycleRecord> = cycles.get(at);
        record.map(|record| {
            record.arrivals.iter().filter(|arrival| (arrival.role, arrival.sent) == (role, sent)).count()
        })
    };
    for role in Role::ALL {
        let (mut arrived, mut copies) = (0, 0);
        // Longer than any delay before the end, so that copies have come too.
        for (sent, record) in cycles[..STEPS - 20].iter().enumerate() {
            let times: usize = (sent..STEPS).filter_map(|at| taken(at, role, sent)).sum();
            let Some(Fate::Delayed(delay)) = fate(record, role) else {
                assert_eq!(times, 0, "{role:?} {sent}");
                continue;
            };
            let at = sent + delay + usize::from(role == Role::Acknowledgement);
            assert!(taken(at, role, sent) >= Some(1), "{role:?} {sent}");
            assert!((1..=2).contains(&times), "{role:?} {sent}: {times}");
            arrived += 1;
            copies += times - 1;
        }
        assert!(
            (0.15..0.35).contains(&(copies as f64 / f64::from(arrived))),
            "{role:?}: {copies} of {arrived}"
        );
    }
}
