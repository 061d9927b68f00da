//! The header: what the law is, how to use it in a cycle, and its declarations.

use super::{Names, comment, generated};
use crate::design::DeviceScalar;
use crate::emit::standing;
use crate::report::{Report, counted, figure, scalar_name};
use slqg::DefaultInput;
use slqg::blob::DesignId;

/// How to use the law. Lines that only a design with limits or hold needs are added by the functions below.
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

const DECLARATIONS: &str = "\
/* A sequence as it was sent. */
typedef struct {
    uint32_t tick; /* the cycle it was made in */
    bool sent;     /* false: nothing was sent in that cycle */
    @scalar@ inputs[@LAW@_SEQUENCE_LENGTH][@LAW@_INPUTS];
} @law@_packet;

/* What the law remembers of one loop. Read what you like; write by the functions below only. */
typedef struct {
    /* Number of the current cycle, modulo 2^32. */
    uint32_t tick;
    /* The input that left the actuator in the last cycle, in input units, as far as is known. */
    @scalar@ applied[@LAW@_INPUTS];
    /* Age of the sequence it came from: cycles since that was made; @LAW@_EMPTY: the default input. */
    uint8_t age;
    /* Place of the current cycle in the ring of the last cycles. */
    uint8_t next;
@held@    @law@_packet packets[@LAW@_SEQUENCE_LENGTH];
} @law@_state;

/* Begins: the first cycle is `tick`, nothing was sent and the actuator applied zero so far. */
void @law@_init(@law@_state *state, uint32_t tick);

/*
 * Tells what the actuator applied in the last cycle, the one before state->tick: the input of the sequence made
 * `age` cycles before it, or the default input (@LAW@_EMPTY). At most once a cycle, before @law@_sequence.
 * Updates state->applied@saturation@.
 *
 * Without it the actuator is held to have played on without a new packet. An acknowledgement that comes later than
 * this is of no use here: do not pass it.
 *
 * Returns false and changes nothing if no such sequence was sent: the acknowledgement deserves no belief.
 */
bool @law@_acknowledge(@law@_state *state, uint8_t age);

/*
 * Computes the control sequence of the current cycle, remembers it as sent, and begins the next cycle.
 *
 * state_estimate: the state in the current cycle, given all measurements up to now, in state units.
 * sequence: receives one row a cycle, the first for the current one, in input units@unsaturated@.
 *
 * Returns false if a number is not finite. Do not send such a sequence; it is remembered as not sent.
 */
bool @law@_sequence(@law@_state *state, const @scalar@ state_estimate[@LAW@_STATES],
    @scalar@ sequence[@LAW@_SEQUENCE_LENGTH][@LAW@_INPUTS]);

/* Tells, after @law@_sequence, that the sequence was not sent after all. */
void @law@_unsent(@law@_state *state);

/* Instead of @law@_sequence: sends nothing in the current cycle and begins the next one. */
void @law@_skip(@law@_state *state);
";

const HELD: &str = "    /* The input of the cycle before the last: what the default input held in that. */
    @scalar@ held[@LAW@_INPUTS];
";

/// The header for `report`. `mark`: checksum of both files.
pub(super) fn text(report: &Report, origin: &str, names: &Names, mark: DesignId) -> String {
    let (hold, limits) = (
        report.solution.law.default_input == DefaultInput::Hold,
        report.design.controller.input_limits.is_some(),
    );
    let declarations = DECLARATIONS
        .replace("@held@", if hold { HELD } else { "" })
        .replace("@saturation@", if limits { ", within the limits of the actuator" } else { "" })
        .replace("@unsaturated@", if limits { "; the actuator saturates them" } else { "" });
    let text = format!(
        "{law}{USE} */\n\n{sizes}\n{declarations}\n#ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
        law = law(report),
        sizes = sizes(report, mark),
    );
    // Names that are not ours stay out of the replacements.
    let first = format!(
        "/*\n * {}\n * {}.c belongs to this header.\n *\n{} *\n",
        generated(report, origin),
        comment(&names.stem),
        standing::lines(report).iter().map(|line| format!(" * {}\n", comment(line))).collect::<String>()
    );
    first + &names.fill(&text, report)
}

/// What is computed, with shapes, units, rate and cost.
fn law(report: &Report) -> String {
    let (law, plant) = (&report.solution.law, &report.design.plant);
    let scalar = report.design.controller.scalar;
    let decay = report.time_constant().map_or("none".into(), |steps| {
        format!("{} cycles ({} s)", figure(steps), figure(steps * plant.sample_time))
    });
    let numbers = law.table_floats();
    let scalar_bytes = match scalar {
        DeviceScalar::F32 => 4,
        DeviceScalar::F64 => 8,
    };
    format!(
        " * The control law of one loop over a link that loses and delays packets, computed in {scalar} (@scalar@):
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
 * With the state known, second moments shrink by the factor {rate} per cycle of {time} s,
 * time constant {decay}; the long-run cost is {cost} per cycle.
 *
",
        scalar = scalar_name(scalar),
        states = counted(plant.states(), "state"),
        in_flight = counted(report.in_flight() * plant.inputs(), "input"),
        inputs = counted(plant.inputs(), "input"),
        cycles = counted(law.length, "cycle"),
        rows = law.lx.nrows(),
        nx = law.lx.ncols(),
        columns = law.m.ncols(),
        arrivals = counted(law.arrival.len(), "number"),
        bytes = numbers * scalar_bytes,
        numbers = counted(numbers, "number"),
        rate = figure(report.solution.mean_square_rate),
        time = figure(plant.sample_time),
        cost = figure(report.control_cost()),
    )
}

fn sizes(report: &Report, mark: DesignId) -> String {
    let plant = &report.design.plant;
    format!(
        "\
#ifndef @LAW@_H
#define @LAW@_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern \"C\" {{
#endif

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
/* The same number in header and source tells that they were generated together. */
#define @LAW@_GENERATED {mark}u
",
        states = plant.states(),
        inputs = plant.inputs(),
        length = report.solution.law.length,
        default = match report.solution.law.default_input {
            DefaultInput::Zero => "zero",
            DefaultInput::Hold => "the one applied last",
        },
        time = plant.sample_time,
        design = super::design_id(&report.design),
    )
}
