//! A design in other units of its states, inputs and outputs gets the same verdict, and the same gains, costs and figures but
//! for the units: metres or nanometres, pascals or bars.

use gain_gen::{
    design::Design,
    margins::state_known,
    report::Report,
    solve::{Method, Outcome},
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use slqg_tests::drawn::{Drawn, Units, inverse, scaled};
use std::{mem::discriminant, ops::Range};

/// Seeds of designs, none of which takes long to be found on the limit of stability, and changes of units for each.
const SEEDS: Range<u64> = 66..128;
const CHANGES: u64 = 2;
/// How far a figure may be from itself in other units, relative to the largest number of its table.
const SAME: f64 = 1e-9;
/// The same for margins: a boundary is narrowed to 1e-9, where the rate that passes 1 there is as certain as [`SAME`].
const SAME_MARGIN: f64 = 1e-7;
/// Second moments that shrink by less than this a step sum up the rounding of their units: only words are compared.
const SLOWEST: f64 = 0.9999;

/// What is told of a design, in the units of the design it was drawn as.
struct Told {
    /// What is one or the other.
    words: Vec<(&'static str, String)>,
    /// What has no unit, or that of the cost.
    figures: Vec<(&'static str, f64)>,
    margins: Vec<(&'static str, f64)>,
    tables: Vec<(&'static str, DMatrix<f64>)>,
}

fn told(file: &str, units: &Units) -> Told {
    let design = match Design::parse(file, "drawn") {
        Ok(design) => design,
        Err(refused) => {
            let words = vec![("refused", refused.key)];
            return Told { words, figures: vec![], margins: vec![], tables: vec![] };
        }
    };
    let mut report = Report::new(&design, Method::InFlight);
    let certified = report.certify().is_ok();
    let failed: Vec<_> = report.failed_conditions.iter().map(discriminant).collect();
    let mut words = vec![
        ("verdict", report.verdict().name().to_string()),
        ("failed conditions", format!("{failed:?}")),
        ("n_min", format!("{:?}", report.n_min)),
        ("n_crit", format!("{:?}", report.n_crit)),
        ("estimation", report.estimation.verdict.name().to_string()),
        ("certified", certified.to_string()),
    ];
    let mut figures =
        vec![("open-loop modulus", report.open_loop_modulus), ("q_crit", report.estimation.critical)];
    let (mut tables, mut margin_figures) = (vec![], vec![]);
    let (per_state, inputs) = (inverse(&units.states), &units.inputs);
    let (per_input, none) = (inverse(inputs), DVector::from_element(1, 1.0));
    let rate = report.solution.mean_square_rate;
    if rate > SLOWEST {
        return Told { words, figures: vec![], margins: vec![], tables };
    }
    if report.solution.outcome == Outcome::Converged {
        let law = &report.solution.law;
        figures.extend([
            ("mean-square rate", rate),
            ("control cost", report.control_cost()),
            ("least cost with estimation", report.estimation.cost_lower),
            ("greatest cost with estimation", report.estimation.cost_upper),
        ]);
        tables.extend([
            ("Lx", scaled(&law.lx, &per_input, &units.states)),
            ("M", scaled(&law.m, &per_input, inputs)),
            ("P", scaled(&report.solution.cost_to_go, &units.states, &units.states)),
        ]);
    }
    if report.converged()
        && let Some(margins) = state_known(&design, &report.solution)
    {
        words.push(("extra delay", format!("{:?}", margins.extra_delay)));
        margin_figures.extend([
            ("margin of loss", margins.extra_loss),
            ("least input gain", margins.input_gain_min),
            ("greatest input gain", margins.input_gain_max),
        ]);
    }
    if let Some(Ok(preview)) = &report.preview {
        tables.push(("preview gains", scaled(&preview.sequence, &per_input, &none)));
    }
    if let Some(trigger) = &report.trigger {
        let states = units.states.len();
        let table = DMatrix::from_row_slice(states, trigger.state.len() / states, &trigger.state);
        tables.push(("trigger", scaled(&table, &units.states, inputs)));
    }
    let covariance = &report.estimation.covariance;
    for (name, bound) in [("least covariance", &covariance.lower), ("greatest covariance", &covariance.upper)]
    {
        if let Some(bound) = bound {
            tables.push((name, scaled(bound, &per_state, &per_state)));
        }
    }
    Told { words, figures, margins: margin_figures, tables }
}

/// What differs but for rounding.
fn differences(expected: &Told, found: &Told) -> Vec<String> {
    let mut differences = vec![];
    if expected.words != found.words {
        differences.push(format!("{:?}, not {:?}", found.words, expected.words));
        return differences;
    }
    for ((name, expected), (_, found)) in expected.figures.iter().zip(&found.figures) {
        let difference = (found - expected).abs() / expected.abs().max(1.0);
        if found != expected && (difference.is_nan() || difference > SAME) {
            differences.push(format!("{name}: {found}, not {expected}"));
        }
    }
    for ((name, expected), (_, found)) in expected.margins.iter().zip(&found.margins) {
        let difference = (found - expected).abs() / expected.abs().max(1.0);
        if difference.is_nan() || difference > SAME_MARGIN {
            differences.push(format!("{name}: {found}, not {expected}"));
        }
    }
    for ((name, expected), (_, found)) in expected.tables.iter().zip(&found.tables) {
        let largest = expected.amax();
        let difference = (found - expected).amax() / if largest > 0.0 { largest } else { 1.0 };
        if !expected.is_empty() && (difference.is_nan() || difference > SAME) {
            differences.push(format!("{name}: {difference:.1e} apart"));
        }
    }
    differences
}

#[test]
fn units_change_nothing_but_units() {
    let faults: Vec<_> = SEEDS
        .into_par_iter()
        .flat_map_iter(|seed| {
            let design = Drawn::new(seed);
            let one = |count| DVector::from_element(count, 1.0);
            let own = Units {
                states: one(design.a.nrows()),
                inputs: one(design.b.ncols()),
                outputs: one(design.c.nrows()),
            };
            let expected = told(&design.file(), &own);
            (0..CHANGES).filter_map(move |change| {
                let units = Units::draw(&design, seed * CHANGES + change);
                let differences = differences(&expected, &told(&design.told_in(&units).file(), &units));
                let told = || format!("seed {seed}, change {change}: {}", differences.join("; "));
                (!differences.is_empty()).then(told)
            })
        })
        .collect();
    assert!(
        faults.is_empty(),
        "{} of {}:\n{}",
        faults.len(),
        (SEEDS.end - SEEDS.start) * CHANGES,
        faults.join("\n")
    );
}
