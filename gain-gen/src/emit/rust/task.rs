//! Time-varying gains of a task as Rust source: one checked [`slqg::gains::Gains`] a cycle.

use super::{PER_LINE, default_input};
use crate::emit::EmitError;
use crate::emit::literal::Table;
use crate::report::{Report, figure};
use crate::solve::FiniteHorizon;

/// What stands where a steady-state design has its one law.
pub(super) fn gains(report: &Report, task: &FiniteHorizon) -> Result<String, EmitError> {
    let scalar = report.design.controller.scalar;
    let arrival = &task.laws[0].arrival;
    let mut laws = String::new();
    for law in &task.laws {
        laws.push_str(&format!(
            "    slqg::gains::Gains::<Scalar, STATES, INPUTS>::new(
        SEQUENCE_LENGTH,
        {default},
        slqg::gains::Tables {{
            lx: &[
{lx}            ],
            m: &[
{m}            ],
            arrival: &ARRIVAL,
        }},
    ),
",
            default = default_input(report),
            lx = Table { name: "Lx", scalar }.rows(&law.lx, 16)?,
            m = Table { name: "M", scalar }.rows(&law.m, 16)?,
        ));
    }
    let (rows, states, expected) = (task.laws[0].lx.nrows(), task.laws[0].lx.ncols(), task.laws[0].m.ncols());
    Ok(format!(
        "\
/// Cycles of the task.
pub const CYCLES: usize = {cycles};

/// Conditional arrival probabilities `r(b, m)` of the link from controller to actuator, the same in every cycle.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
static ARRIVAL: [Scalar; {arrivals}] = [
{arrival}];

/// The control law of each cycle of the task, `U = Lx xhat + M vbar`: before cycle `k` hand `HORIZON[k]` to the
/// controller's `set_gains`.
///
/// `Lx` is {rows} x {states}, `M` {rows} x {expected}, both by rows. With the state known{ahead} the whole task is expected to
/// cost {cost}, its terminal cost included.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static HORIZON: [slqg::gains::Gains<'static, Scalar, STATES, INPUTS>; CYCLES] = [
{laws}];
",
        cycles = task.laws.len(),
        arrivals = arrival.len(),
        arrival = Table { name: "r", scalar }.lines(arrival, PER_LINE, 4)?,
        ahead = if task.tracked.is_some() { " and the reference ahead," } else { "" },
        cost = figure(report.task_cost().unwrap_or(f64::NAN)),
    ))
}
