//! What `solve` takes: one solution a run, to be counted by a tool that counts instructions.
//!
//! ```text
//! cargo bench -p gain-gen --bench solve --profile dev -- double_integrator 20
//! ```
//!
//! prints the rate and the steps it took. Under `valgrind --tool=callgrind --toggle-collect='solve::counted*'` the program it has
//! built counts the instructions of `solve` and nothing else. With this file and its entry in `Cargo.toml` put into the sources
//! of commit 2dd7b08, that takes 29.5 million for the double integrator with N = 20, 2262 million with N = 100, and 116.0 million
//! for the pendulum with N = 16; with the sources beside it 5.6, 308 and 12.8 million. `docs/accuracy.md` says where they went.

use gain_gen::{
    design::Design,
    solve::{LoopProblem, Method, Solution, solve},
};
use std::hint::black_box;

const DESIGNS: [(&str, &str); 3] = [
    ("double_integrator", include_str!("../../designs/double_integrator.toml")),
    ("double_integrator_bad", include_str!("../../designs/double_integrator_bad.toml")),
    ("pendulum", include_str!("../../designs/pendulum.toml")),
];

/// Not inlined, so that it has a name to be counted by.
#[inline(never)]
fn counted(problem: &LoopProblem) -> Solution {
    solve(black_box(problem), Method::InFlight)
}

fn main() {
    // cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let cases = match arguments.as_slice() {
        [] => vec![("double_integrator", 20), ("double_integrator", 100), ("pendulum", 16)],
        [design, length] => vec![(design.as_str(), length.parse().expect("a length"))],
        _ => panic!("usage: solve [DESIGN LENGTH]"),
    };
    for (name, length) in cases {
        let (_, text) = DESIGNS.iter().find(|design| design.0 == name).expect("one of the designs");
        let design = Design::parse(text, "design.toml").expect("a design of the project");
        let found = counted(&LoopProblem::of(&design).with_length(length));
        println!(
            "{name:<18} N = {length:>3}  {:?}, rate {:.12}, {} steps, {} policy iterations, residual {:.1e}",
            found.outcome, found.mean_square_rate, found.iterations, found.policy_iterations, found.residual
        );
    }
}
