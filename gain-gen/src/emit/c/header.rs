//! The header of a design: what the law is, how to use it in a cycle, and its names, sizes and tables.

use super::{Names, comment, generated};
use crate::design::DeviceScalar;
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError};
use crate::figure::{counted, figure};
use slqg::DefaultInput;

/// The form of `slqg_law.h` that headers are written for.
const FORM: u32 = 1;

/// How to use the law.
const USE: &str = " * Once, for `static @law@_state law;`:
 *
 *     @law@_init(&law, 0);
 *
 * In each cycle of the controller, every @LAW@_SAMPLE_TIME seconds:
 *
 *     if (the acknowledgement of the last cycle has come)
 *         @law@_acknowledge(&law, age);
 *     x = estimate of the state, from the measurements and from law.applied, the input of the last cycle
 *     tick = law.tick;
 *     if (@law@_sequence(&law, x, u) && !send(tick, u))
 *         @law@_unsent(&law);
 *
 * The actuator keeps the sequence with the newest tick. In cycle k it applies u[k - tick] while that exists,
 * and the default input after it; it acknowledges its age, k - tick, or @LAW@_EMPTY for the default input.
 *
 * One object is one loop: functions have no memory of their own, allocate nothing, call nothing but memset and
 * memcpy, and never wait. Results are those of the Rust crate `slqg` to the bit if products and sums are rounded
 * one by one. The source asks the compiler for that, which most honour; -ffp-contract=off makes sure, and so does
 * -msse2 -mfpmath=sse on 32-bit x86. It does not compile with -ffast-math.
";

/// The header for `emission`.
pub(super) fn text(emission: &Emission<'_>, origin: &str, names: &Names) -> Result<String, EmitError> {
    let text = format!(
        "{law}{USE} */\n\n{sizes}\n{declarations}\n{tables}#endif\n",
        law = law(emission),
        sizes = sizes(emission),
        declarations = declarations(emission),
        tables = tables(emission)?,
    );
    // Names that are not ours stay out of the replacements.
    let first = format!(
        "/*\n * {}\n * {}.c compiles the law under the names of this header: slqg_law.c, with its sizes and tables.\n *\n{} *\n",
        generated(emission, origin),
        comment(&names.stem),
        emission.standing.lines().iter().map(|line| format!(" * {}\n", comment(line))).collect::<String>()
    );
    Ok(first + &names.fill(&text))
}

fn c_scalar(scalar: DeviceScalar) -> &'static str {
    match scalar {
        DeviceScalar::F32 => "float",
        DeviceScalar::F64 => "double",
    }
}

/// What is computed, with shapes, units, rate and cost.
fn law(emission: &Emission<'_>) -> String {
    let (law, plant) = (emission.law, &emission.design.plant);
    let (scalar, conditions) = (emission.design.controller.scalar, emission.conditions());
    let decay = emission.time_constant.map_or("none".into(), |steps| {
        format!("{} cycles ({} s)", figure(steps), figure(steps * plant.sample_time))
    });
    let numbers = law.table_floats();
    let scalar_bytes = match scalar {
        DeviceScalar::F32 => 4,
        DeviceScalar::F64 => 8,
    };
    format!(
        " * The control law of one loop over a link that loses and delays packets, computed in {scalar} ({c_scalar}):
 *
 *     U = Lx x + M v
 *
 *     x    estimate of the {states}, in state units
 *     v    the {in_flight} to expect in the coming cycles if nothing sent from now on arrived, in input units;
 *          computed from what was sent and acknowledged, and r, the probabilities that a packet still arrives
 *     U    the sequence: {inputs} in each of {cycles}, the first of them the current one, in input units
 *     Lx   {rows} x {nx}, in input units per state unit
 *     M    {rows} x {columns}, in input units per input unit
 *     r    {arrivals}
 *
 * Tables take {numbers}, {bytes} bytes.
 *
 * {known}, second moments shrink by the factor {rate} per cycle of {time} s,
 * time constant {decay}; the long-run cost is {cost} per cycle{of}.
 *
",
        scalar = scalar.name(),
        c_scalar = c_scalar(scalar),
        states = counted(plant.states(), "state"),
        in_flight = counted(emission.in_flight() * plant.inputs(), "input"),
        inputs = counted(plant.inputs(), "input"),
        cycles = counted(law.length, "cycle"),
        rows = law.lx.nrows(),
        nx = law.lx.ncols(),
        columns = law.m.ncols(),
        arrivals = counted(law.arrival.len(), "number"),
        bytes = numbers * scalar_bytes,
        numbers = counted(numbers, "number"),
        rate = figure(emission.mean_square_rate),
        time = figure(plant.sample_time),
        cost = figure(emission.control_cost),
        known = conditions.0,
        of = conditions.1,
    )
}

fn sizes(emission: &Emission<'_>) -> String {
    let plant = &emission.design.plant;
    format!(
        "\
#ifndef @LAW@_H
#define @LAW@_H

/* States of the plant, nx. */
#define @LAW@_STATES {states}u
/* Inputs of the plant, nu. */
#define @LAW@_INPUTS {inputs}u
/* Inputs per control sequence, N. */
#define @LAW@_SEQUENCE_LENGTH {length}u
/* In place of an age: the actuator applied the default input, {default}. */
#define @LAW@_EMPTY 255u
/* Length of a cycle, in seconds. */
#define @LAW@_SAMPLE_TIME {time:?}
/* Which design this is, as in blobs. */
#define @LAW@_DESIGN_ID {design}u
",
        states = plant.states(),
        inputs = plant.inputs(),
        length = emission.law.length,
        default = match emission.law.default_input {
            DefaultInput::Zero => "zero",
            DefaultInput::Hold => "the one applied last",
        },
        time = plant.sample_time,
        design = super::design_id(emission.design),
    )
}

/// What `slqg_law.h` is told of the design, which then declares its types and functions.
fn declarations(emission: &Emission<'_>) -> String {
    format!(
        "\
/* Declares the types @law@_packet and @law@_state, and the functions @law@_init, @law@_acknowledge, @law@_sequence,
 * @law@_unsent and @law@_skip, with what each of them does. */
#define SLQG_LAW(name) @law@_##name
#define SLQG_LAW_SCALAR {scalar}
#define SLQG_LAW_STATES @LAW@_STATES
#define SLQG_LAW_INPUTS @LAW@_INPUTS
#define SLQG_LAW_LENGTH @LAW@_SEQUENCE_LENGTH
#define SLQG_LAW_HOLD {hold}
#define SLQG_LAW_LIMITS {limits}
#define SLQG_LAW_FORM_EXPECTED {FORM}u
#include \"slqg_law.h\"
",
        scalar = c_scalar(emission.design.controller.scalar),
        hold = u8::from(emission.law.default_input == DefaultInput::Hold),
        limits = u8::from(emission.design.controller.input_limits.is_some()),
    )
}

/// The constants that a law has: arrays of no numbers are left out.
fn tables(emission: &Emission<'_>) -> Result<String, EmitError> {
    let (law, settings) = (emission.law, &emission.design.controller);
    let (scalar, c_scalar) = (settings.scalar, c_scalar(settings.scalar));
    let mut text = format!(
        "/* For slqg_law.c alone. */\n\
         #ifdef SLQG_LAW_SOURCE\n\n\
         /* Lx: inputs of the sequence by states. */\n\
         static const {c_scalar} @law@_lx[SLQG_LAW_LENGTH * SLQG_LAW_INPUTS][SLQG_LAW_STATES] = {};\n\n",
        Table { name: "Lx", scalar }.c_rows(&law.lx)?
    );
    if emission.in_flight() > 0 {
        text.push_str(&format!(
            "/* M: inputs of the sequence by expected inputs, cycle by cycle. */\n\
             static const {c_scalar} @law@_m[SLQG_LAW_LENGTH * SLQG_LAW_INPUTS][SLQG_LAW_IN_FLIGHT * SLQG_LAW_INPUTS] = {};\n\n",
            Table { name: "M", scalar }.c_rows(&law.m)?
        ));
    }
    if !law.arrival.is_empty() {
        text.push_str(&format!(
            "/* r: for packets of age 1 to N-1, how likely they arrive by 0, 1, .. cycles from now. */\n\
             static const {c_scalar} @law@_r[{}] = {};\n\n",
            law.arrival.len(),
            Table { name: "r", scalar }.c_list(&law.arrival, 0)?
        ));
    }
    if let Some(pairs) = &settings.input_limits {
        let table = Table { name: "controller.input_limits", scalar };
        let (min, max): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        text.push_str(&format!(
            "/* Limits of the actuator, in input units. */\n\
             static const {c_scalar} @law@_min[SLQG_LAW_INPUTS] = {};\n\
             static const {c_scalar} @law@_max[SLQG_LAW_INPUTS] = {};\n\n",
            table.c_list(&min, 0)?,
            table.c_list(&max, 0)?
        ));
    }
    Ok(text + "#endif\n\n")
}
