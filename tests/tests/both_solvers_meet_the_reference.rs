//! Gains, costs, rates and age chains of both solvers agree with an independent oracle.

use gain_gen::solve::{Method, age_transitions, solve};
use slqg_tests::{ReferenceCase, matrix, relative_difference};

fn every_case_agrees(method: Method) {
    for case in ReferenceCase::all() {
        let solution = solve(&case.problem(), method);
        let name = format!("{} by {}", case.name, method.name());
        assert!(solution.is_stabilising(), "{name}: {:?}", solution.outcome);
        let mode_gains = solution.mode_gains();
        assert_eq!(mode_gains.len(), case.gains.len(), "{name}");
        for (mode, (found, expected)) in mode_gains.iter().zip(&case.gains).enumerate() {
            let difference = relative_difference(found, &matrix(expected));
            assert!(difference < 1e-9, "{name}: gain of mode {mode} differs by {difference:e}");
        }
        for expected in &case.cost_to_go_xx {
            assert!(
                relative_difference(&solution.cost_to_go, &matrix(expected)) < 1e-9,
                "{name}: cost-to-go"
            );
        }
        let rate = (solution.mean_square_rate - case.spectral_radius).abs();
        assert!(rate < 1e-9, "{name}: rate differs by {rate:e}");
        let cost = solution.control_cost(&matrix(&case.process_noise)) / case.lrac_control_cost - 1.0;
        assert!(cost.abs() < 1e-9, "{name}: cost differs by {cost:e}");
    }
}

#[test]
fn the_in_flight_recursion_meets_every_reference_case() {
    every_case_agrees(Method::InFlight);
}

#[test]
fn the_coupled_recursion_meets_every_reference_case() {
    every_case_agrees(Method::Coupled);
}

#[test]
fn the_age_chain_meets_every_reference_case() {
    for case in ReferenceCase::all() {
        let chain = age_transitions(&case.problem().link, case.sequence_length);
        assert!(relative_difference(&chain, &matrix(&case.transition_matrix)) < 1e-14, "{}", case.name);
    }
}
