//! The event-triggered pendulum whose trigger counts on a schedule: in total it never costs more than the best schedule, than
//! the trigger that takes all later packets to be sent, or than a deadband of any threshold; and longer sequences make it cheaper.
//! The tables are those of `docs/evaluation.md`.

use gain_gen::design::{Base, Design, Event};
use host_sim::{
    contender::{Contender, ContenderError, Kind},
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
};

const EVALUATION: &str = include_str!("../../docs/evaluation.md");
const NETWORKS: [(&str, &str); 2] = [
    ("good", include_str!("../../designs/pendulum_event.toml")),
    ("bad", include_str!("../../designs/pendulum_event_bad.toml")),
];
const PLAN: Plan = Plan { runs: 200, steps: 200, seed: 1 };
const SHORT: [usize; 10] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10];
const LONG: [usize; 3] = [12, 16, 20];

/// Total of a loop that falls apart.
const LOST: f64 = 1e6;

/// Mean total of a run, its standard error, and the part of cycles in which a packet is sent.
#[derive(Clone, Copy)]
struct Total {
    mean: f64,
    error: f64,
    sent: f64,
}

impl Total {
    /// Whether it is above `other` by more than chance may do: two standard errors of the difference.
    fn is_above(&self, other: &Self) -> bool {
        self.mean - other.mean > 2.0 * self.error.hypot(other.error)
    }
}

/// `None` if no gains stabilise the loop.
fn total(text: &str, length: usize, event: Event, kind: Kind, deadband: Option<f64>) -> Option<Total> {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    design.event = Some(event);
    let mut contender = match Contender::new(kind, &design, PLAN.steps) {
        Ok(contender) => contender,
        Err(ContenderError::Unstable { .. }) => return None,
        Err(other) => panic!("{other}"),
    };
    if let (Some(rule), Some(delta)) = (&mut contender.deadband, deadband) {
        rule.delta = delta;
    }
    let simulate = Simulate { design: &design, contender: &contender, plan: PLAN, done: &|| () };
    let outcome = simulate.outcome().expect("it can be simulated");
    let costs = &outcome.total_costs;
    Some(Total { mean: mean(costs), error: standard_error(costs), sent: outcome.summary.send_rate })
}

/// As many digits as fit a column.
fn spelled(value: f64) -> String {
    if value > LOST {
        return "-".into();
    }
    let decimals =
        if value >= 1e4 { 0 } else { (4 - value.abs().log10().floor() as i32).clamp(0, 4) as usize };
    format!("{value:.decimals$}")
}

/// A line of a table; where lengths cannot be stabilised it has a dash.
fn is_shown(label: &str, values: &[String]) -> bool {
    let line = format!("{label} {}", values.join(" "));
    EVALUATION.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()))
}

/// Runs every length at `send_cost`, compares, and looks the tables up in the page. `deadbands`: thresholds to compare with.
fn never_loses(send_cost: f64, lengths: &[usize], deadbands: &[f64]) {
    let today = Event::at(send_cost);
    let counting = Event { base: Base::Auto, ..today };
    let mut missing = Vec::new();
    for (network, text) in NETWORKS {
        let of = |event, kind| -> Vec<Option<Total>> {
            lengths.iter().map(|&length| total(text, length, event, kind, None)).collect()
        };
        let found = of(counting, Kind::Slqg);
        let [schedule, before] = [of(today, Kind::SlqgPeriodic), of(today, Kind::Slqg)];
        let mut last: Option<Total> = None;
        let mut best_deadbands: Vec<Option<Total>> = vec![None; lengths.len()];
        for (at, found) in found.iter().enumerate() {
            let Some(found) = found else { continue };
            let length = lengths[at];
            for (name, other) in [("the best schedule", schedule[at]), ("counting on all", before[at])] {
                let other = other.expect("stable if the other one is");
                assert!(
                    !found.is_above(&other),
                    "{network} {send_cost} N = {length}: {name} costs {}, this {}",
                    other.mean,
                    found.mean
                );
            }
            for &delta in deadbands {
                let Some(other) = total(text, length, today, Kind::Deadband, Some(delta)) else { continue };
                if best_deadbands[at].is_none_or(|best| other.mean < best.mean) {
                    best_deadbands[at] = Some(other);
                }
                assert!(
                    !found.is_above(&other),
                    "{network} N = {length}: deadband {delta} costs {}, this {}",
                    other.mean,
                    found.mean
                );
            }
            if let Some(shorter) = last {
                assert!(
                    !found.is_above(&shorter),
                    "{network} {send_cost} N = {length}: {} after {}",
                    found.mean,
                    shorter.mean
                );
            }
            last = Some(*found);
        }
        let column = |totals: &[Option<Total>], spell: &dyn Fn(&Total) -> String| -> Vec<String> {
            totals.iter().map(|total| total.as_ref().map_or("-".into(), spell)).collect()
        };
        let mean = |total: &Total| spelled(total.mean);
        for (what, values) in [
            ("base auto", column(&found, &mean)),
            ("std error", column(&found, &|total| spelled(total.error))),
            ("sent, %", column(&found, &|total| format!("{:.1}", 100.0 * total.sent))),
            ("best schedule", column(&schedule, &mean)),
            ("base 1", column(&before, &mean)),
            ("best deadband", column(&best_deadbands, &mean)),
        ] {
            if what == "best deadband" && deadbands.is_empty() {
                continue;
            }
            let label = format!("{network} {send_cost} {what}");
            let cells: String = values.iter().map(|value| format!("{value:>8}")).collect();
            eprintln!("    {label:<24}{cells}");
            if !is_shown(&label, &values) {
                missing.push(label);
            }
        }
    }
    assert!(missing.is_empty(), "not in docs/evaluation.md: {missing:?}");
}

#[test]
fn at_a_thousand_a_packet() {
    never_loses(1000.0, &SHORT, &[]);
}

#[test]
fn at_a_thousand_a_packet_with_long_sequences_and_deadbands() {
    never_loses(1000.0, &LONG, &[10.0, 30.0, 100.0, 300.0, 1000.0]);
}

#[test]
fn at_ten_a_packet() {
    never_loses(10.0, &SHORT, &[]);
}

#[test]
fn at_a_tenth_a_packet() {
    never_loses(0.1, &SHORT, &[]);
}

#[test]
fn at_no_price_it_sends_always() {
    for (_, text) in NETWORKS {
        let counting = Event { base: Base::Auto, ..Event::at(0.0) };
        let found = total(text, 6, counting, Kind::Slqg, None).expect("stable");
        let always = total(text, 6, counting, Kind::SlqgAlways, None).expect("stable");
        assert_eq!((found.mean, found.sent), (always.mean, 1.0));
    }
}
