//! Every figure in `docs/thesis.md` that takes no more than seconds is what `host-sim figures` finds today.

use gain_gen::{
    report::Report,
    solve::{LoopProblem, Method, mean_square_rate},
};
use host_sim::{
    contender::{Contender, Kind},
    figures::{
        Figure,
        by_length::Point,
        cumulative,
        single_run::{self, BEFORE, CHANGE},
    },
    monte_carlo::Summary,
    output::columns,
};
use slqg_tests::page::{Page, design};
use std::ops::RangeInclusive;

const PAGE: Page = Page { name: "thesis.md", text: include_str!("../../docs/thesis.md") };
const SEED: u64 = 1;

/// What some controllers of a figure come to: runs and cycles are the figure's.
struct Found(Vec<Point>);

impl Found {
    /// On the figure's `good` network, the first, or on its `bad` one, the second.
    fn of(figure: Figure, network: usize, kinds: &[Kind], lengths: RangeInclusive<usize>) -> Self {
        let mut comparison = figure.comparison().expect("a figure over lengths");
        assert!(kinds.iter().all(|kind| comparison.kinds.contains(kind)), "none but those of the figure");
        comparison.designs = vec![comparison.designs.swap_remove(network)];
        comparison.kinds = kinds.to_vec();
        comparison.lengths = lengths;
        Self(comparison.points(SEED, || ()).expect("controllers of the figure"))
    }

    fn at(&self, kind: Kind, length: usize) -> Option<&Summary> {
        let point = self.0.iter().find(|point| (point.kind, point.length) == (kind, length));
        point.expect("a point of the figure").summary.as_ref()
    }

    fn summary(&self, kind: Kind, length: usize) -> &Summary {
        self.at(kind, length).expect("a stabilised loop")
    }

    fn mean(&self, kind: Kind, length: usize) -> f64 {
        self.summary(kind, length).mean_cost.expect("a finite cost")
    }

    /// The mean cost as tables have it.
    fn cost(&self, kind: Kind, length: usize) -> String {
        columns::figure(self.summary(kind, length).mean_cost)
    }
}

fn shown(value: f64) -> String {
    columns::figure(Some(value))
}

#[test]
fn costs_over_the_length() {
    let figure = Figure::CostOverLength;
    let good = Found::of(figure, 0, &[Kind::Slqg, Kind::LqgLoss, Kind::Nominal, Kind::HoldLast], 3..=5);
    let [slqg, loss, nominal] = [Kind::Slqg, Kind::LqgLoss, Kind::Nominal].map(|kind| good.cost(kind, 4));
    PAGE.says(&format!("holds: {slqg} (`slqg`), {loss} (`lqg-loss`) and {nominal} (`nominal`) with N = 4"));
    for kind in [Kind::Slqg, Kind::LqgLoss, Kind::Nominal] {
        let known = good.summary(kind, 4).std_error.expect("finite") / good.mean(kind, 4);
        assert!((0.010..0.020).contains(&known), "about 1.5 %: {known}");
    }
    PAGE.says(&format!("Holding the last value is far off: {} |", good.cost(Kind::HoldLast, 1)));
    let [three, four, five] = [3, 4, 5].map(|length| good.cost(Kind::Slqg, length));
    PAGE.says(&format!("on `good` from N = 3 ({three}, {four}, {five});"));

    let bad = Found::of(figure, 1, &[Kind::Slqg, Kind::LqgLoss, Kind::Nominal, Kind::HoldLast], 2..=6);
    let (four, six) = (bad.cost(Kind::Slqg, 4), bad.cost(Kind::Slqg, 6));
    PAGE.says(&format!(
        "holds, and more so: {four} with N = 4, while `lqg-loss`, `nominal` and `hold-last` diverge"
    ));
    PAGE.says(&format!("it still falls from {four} (N = 4) to {six} (N = 6)"));
    for length in 2..=6 {
        for kind in [Kind::LqgLoss, Kind::Nominal] {
            assert!(bad.summary(kind, length).diverged > 0, "{kind:?}, N = {length}");
        }
        assert_eq!(bad.summary(Kind::Slqg, length).diverged, 0);
    }
    assert!(bad.summary(Kind::HoldLast, 1).diverged > 0);
}

#[test]
fn costs_per_step() {
    let found = cumulative::simulate(4000, SEED, || ());
    let after = |length: usize, steps: usize| found.means[length - 1][steps - 1];
    PAGE.says(&format!(
        "With 4000 runs the mean cost per step is {} after 30 steps and {} after 50 for N = 1; for N = 3, 4 it falls from step \
         10 on, to {} and {} after 50.",
        shown(after(1, 30)),
        shown(after(1, 50)),
        shown(after(3, 50)),
        shown(after(4, 50)),
    ));
    for length in [3, 4] {
        let means = &found.means[length - 1][9..];
        assert!(means.windows(2).all(|pair| pair[1] < pair[0]), "N = {length}");
    }
}

#[test]
fn costs_without_acknowledgements() {
    let kinds = [Kind::Slqg, Kind::SlqgUdp];
    let good = Found::of(Figure::Unacknowledged, 0, &kinds, 4..=4);
    let percent = |found: &Found, length| {
        100.0 * (found.mean(Kind::SlqgUdp, length) / found.mean(Kind::Slqg, length) - 1.0)
    };
    let [with, without] = kinds.map(|kind| good.cost(kind, 4));
    PAGE.says(&format!("{:.0} % more ({without} against {with}, N = 4)", percent(&good, 4)));

    let bad = Found::of(Figure::Unacknowledged, 1, &kinds, 1..=6);
    let in_the_mean = |length| 1.0 + percent(&bad, length) / 100.0;
    let median = |kind, length| bad.summary(kind, length).median_cost.expect("finite");
    let in_the_median = |length| median(Kind::SlqgUdp, length) / median(Kind::Slqg, length);
    PAGE.says(&format!(
        "N = 1: {:.1} % more, both {:.1}e6; N = 2: {:.0} % more; N = 3, 4: {:.0} and {:.0} times as much in the mean, {:.1} and \
         {:.1} times in the median",
        percent(&bad, 1),
        bad.mean(Kind::Slqg, 1) / 1e6,
        percent(&bad, 2),
        in_the_mean(3),
        in_the_mean(4),
        in_the_median(3),
        in_the_median(4),
    ));
    PAGE.says(&format!("N = 6: {:.0} % more", percent(&bad, 6)));
}

#[test]
fn a_single_run() {
    let [good, bad] = &single_run::simulate(SEED)[..] else { panic!("two networks") };
    assert_eq!((CHANGE as f64 * good.sample_time, BEFORE as f64 * good.sample_time), (5.0, 4.0));
    let [with, without] = good.reactions();
    PAGE.says(&format!(
        "the two carts stay within {:.2} m of each other in the first second",
        good.apart(50)
    ));
    PAGE.says(&format!(
        "the one with preview turns after {:.2} s, at {} m, and passes {} m when the reference changes after 5 s; without it the cart \
         is at {} m then, and turns after {:.2} s.",
        with.turn,
        shown(with.farthest),
        shown(with.position),
        shown(without.position),
        without.turn,
    ));
    PAGE.says(&format!(
        "from 4 s on up to {} rad and {} rad/s against {} rad and {} rad/s, with inputs of up to {} N against {} N",
        shown(without.angle),
        shown(without.rate),
        shown(with.angle),
        shown(with.rate),
        shown(without.input),
        shown(with.input),
    ));
    let [with, without] = bad.reactions();
    PAGE.says(&format!("On `bad` they turn after {:.2} s and {:.2} s", with.turn, without.turn));
    PAGE.says(&format!(
        "On `bad` the angle does ({} rad against {} rad), the rate does not ({} rad/s against {} rad/s)",
        shown(without.angle),
        shown(with.angle),
        shown(without.rate),
        shown(with.rate),
    ));
    assert!(without.angle > with.angle && without.rate < with.rate);
}

#[test]
fn following_with_and_without_preview() {
    let good = Found::of(Figure::Tracking, 0, &[Kind::Slqg, Kind::SlqgNoPreview, Kind::Nominal], 4..=4);
    let [with, without, nominal] =
        [Kind::Slqg, Kind::SlqgNoPreview, Kind::Nominal].map(|kind| good.cost(kind, 4));
    PAGE.says(&format!("holds: {with} against {without} (`slqg-no-preview`, N = 4, `good`)"));
    let bad = Found::of(Figure::Tracking, 1, &[Kind::Slqg, Kind::Nominal], 6..=6);
    let dearer = 100.0 * (bad.mean(Kind::Nominal, 6) / bad.mean(Kind::Slqg, 6) - 1.0);
    PAGE.says(&format!(
        "is as good there ({nominal}), and {dearer:.0} % dearer on `bad` with N = 6 ({} against {})",
        bad.cost(Kind::Nominal, 6),
        bad.cost(Kind::Slqg, 6)
    ));
    let rate = |name: &str, length| {
        let mut design = design(name);
        design.set_sequence_length(length);
        let contender = Contender::new(Kind::Nominal, &design, 500).expect("it has a law for any length");
        mean_square_rate(&LoopProblem::of(&design), &contender.laws[0].mode_gains())
    };
    let [five, six] = [5, 6].map(|length| rate("pendulum_tracking_bad", length));
    PAGE.says(&format!(
        "second moments grow by {five:.3} a cycle with N = 5, and shrink by {six:.3} with N = 6"
    ));
    assert!((1..=5).all(|length| rate("pendulum_tracking_bad", length) > 1.0) && six < 1.0);
    assert!((1..=6).all(|length| rate("pendulum_tracking", length) < 1.0));
}

#[test]
fn sending_what_is_worth_it() {
    let total = |found: &Found, kind| columns::figure(found.summary(kind, 7).mean_total_cost);
    let good = Found::of(Figure::EventTriggered, 0, &[Kind::Slqg, Kind::SlqgAlways], 7..=7);
    let (event, always) = (total(&good, Kind::Slqg), total(&good, Kind::SlqgAlways));
    PAGE.says(&format!("holds: {event} with N = 7 against {always} |"));
    let good = Found::of(Figure::EventTriggered, 0, &[Kind::Deadband], 1..=10);
    let bad = Found::of(Figure::EventTriggered, 1, &[Kind::Slqg, Kind::Deadband], 1..=10);
    for found in [&good, &bad] {
        assert!((1..=10).all(|length| found.summary(Kind::Deadband, length).send_rate == 1.0));
    }
    let diverged = |length| bad.summary(Kind::Deadband, length).diverged;
    assert!(diverged(1) > 0 && diverged(2) > 0);
    PAGE.says(&format!("(for N = 3 in {} runs of 200)", diverged(3)));
    let rates = (4..=10).map(|length| 100.0 * bad.summary(Kind::Slqg, length).send_rate);
    let (least, most) =
        rates.fold((100.0, 0.0), |(least, most): (f64, f64), rate| (least.min(rate), most.max(rate)));
    PAGE.says(&format!("`slqg` sends in {least:.0} to {most:.0} % of the cycles for N = 4 to 10"));
    assert!((1..=3).all(|length| bad.at(Kind::Slqg, length).is_none()));
    let report = Report::new(&design("pendulum_event_bad"), Method::InFlight);
    assert_eq!((report.n_min, report.n_crit), (Some(3), Some(4)));
}
