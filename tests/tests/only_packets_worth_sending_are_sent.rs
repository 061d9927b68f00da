//! The event-triggered pendulum at 1000 a packet: it never costs more in total than sending always, and it sends less.

use gain_gen::design::{Design, Event};
use host_sim::{
    contender::{Contender, ContenderError, Kind},
    monte_carlo::{Outcome, Plan, Simulate},
    sample::{mean, standard_error},
};

const GOOD: &str = include_str!("../../designs/pendulum_event.toml");
const BAD: &str = include_str!("../../designs/pendulum_event_bad.toml");
const PLAN: Plan = Plan { runs: 200, steps: 200, seed: 1 };

fn design(text: &str, length: usize) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    design
}

fn outcome(design: &Design, kind: Kind) -> Result<Outcome, ContenderError> {
    let contender = Contender::new(kind, design, PLAN.steps)?;
    let simulate = Simulate { design, contender: &contender, plan: PLAN, done: &|| () };
    Ok(simulate.outcome().expect("it can be simulated"))
}

#[test]
fn it_never_costs_more_in_total_than_sending_always_and_sends_less() {
    for text in [GOOD, BAD] {
        let mut stable = 0;
        for length in 1..=10 {
            let design = design(text, length);
            let Ok(triggered) = outcome(&design, Kind::Slqg) else {
                assert!(text == BAD && length < 4, "N_crit is 4 on the bad network");
                continue;
            };
            let always = outcome(&design, Kind::SlqgAlways).expect("the same gains");
            stable += 1;
            assert!(triggered.summary.send_rate < 0.5 && always.summary.send_rate == 1.0);
            let [total, error] = [mean, standard_error].map(|of| of(&triggered.total_costs));
            let without = mean(&always.total_costs);
            assert!(total + 4.0 * error < without, "{} N = {length}: {total} {without}", design.name);
            assert!(mean(&triggered.costs) >= mean(&always.costs), "what is saved is paid in control cost");
        }
        assert_eq!(stable, if text == GOOD { 10 } else { 7 });
    }
}

/// From N = 8 on it rises again, by a quarter up to N = 12: a longer sequence is planned as if more packets were to follow,
/// and when none does it leaves the cart faster. The rate stays far below that of short sequences.
#[test]
fn longer_sequences_need_fewer_packets_up_to_seven_inputs() {
    let rate = |length| outcome(&design(GOOD, length), Kind::Slqg).expect("stable").summary.send_rate;
    let rates: Vec<f64> = (1..=10).map(rate).collect();
    assert!(rates[..7].windows(2).all(|pair| pair[1] < pair[0]), "{rates:?}");
    assert!(rates[7..].iter().all(|rate| *rate < 0.3 * rates[0]), "{rates:?}");
}

#[test]
fn packets_that_cost_nothing_are_sent_as_if_there_were_no_trigger() {
    for text in [GOOD, BAD] {
        let mut design = design(text, 6);
        design.event = None;
        let plain = outcome(&design, Kind::Slqg).expect("stable");
        design.event = Some(Event::at(0.0));
        let triggered = outcome(&design, Kind::Slqg).expect("stable");
        assert_eq!(triggered.costs, plain.costs, "bit for bit");
        assert_eq!(triggered.summary.send_rate, 1.0);
        assert_eq!(triggered.total_costs, triggered.costs);
    }
}

#[test]
fn dearer_packets_are_sent_more_rarely() {
    let mut design = design(GOOD, 6);
    let mut last = 1.0;
    for send_cost in [1e-4, 1e-2, 1.0, 100.0] {
        design.event = Some(Event::at(send_cost));
        let rate = outcome(&design, Kind::Slqg).expect("stable").summary.send_rate;
        assert!(rate < last, "{rate} at {send_cost}");
        last = rate;
    }
}
