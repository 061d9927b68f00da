//! The source: tables and arithmetic, in the order of `slqg::in_flight::add_newer` and `slqg::gains::Gains`.
//!
//! The text is put together from parts; those that a design has no use for (no limits, no in-flight inputs) are left
//! out, as C has no empty arrays and compilers warn about loops that never run.

use super::{Names, generated};
use crate::emit::EmitError;
use crate::emit::literal::Table;
use crate::report::Report;
use slqg::DefaultInput;
use slqg::blob::DesignId;

const PRELUDE: &str = "
#include <string.h>

#if @LAW@_GENERATED != @mark@u
#error \"header and source were not generated together\"
#endif

#ifdef __FAST_MATH__
#error \"without -ffast-math: it reorders sums, and takes for granted that all numbers are finite\"
#endif

/* Every product and every sum is rounded by itself, as in the simulation: no fused multiply-add. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize (\"fp-contract=off\")
#elif defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract (off)
#else
#pragma STDC FP_CONTRACT OFF
#endif
";

const SENT: &str = "\
/* The sequence sent `ago` cycles before the current one, 1 to N; NULL if none was. */
static const @law@_packet *@law@_sent(const @law@_state *state, unsigned int ago)
{
    const unsigned int at = (state->next + @LAW@_SEQUENCE_LENGTH - ago) % @LAW@_SEQUENCE_LENGTH;
    const @law@_packet *packet = &state->packets[at];

    return packet->sent && packet->tick == (uint32_t)(state->tick - ago) ? packet : NULL;
}

/* Takes `age` for what was played in the last cycle, and works out the input that left the actuator. */
static void @law@_play(@law@_state *state, uint8_t age)
{
    const @law@_packet *packet = age < @LAW@_SEQUENCE_LENGTH ? @law@_sent(state, age + 1u) : NULL;

    state->age = age;
    for (unsigned int i = 0; i < @LAW@_INPUTS; i++) {
        @scalar@ input = packet != NULL ? packet->inputs[age][i] : @default@;

@saturate@        state->applied[i] = input;
    }
}

/* Begins the next cycle. Until told otherwise, the actuator played on without a new packet. */
static void @law@_finish(@law@_state *state)
{
    const unsigned int older = state->age + 1u;

    state->next = (uint8_t)((state->next + 1u) % @LAW@_SEQUENCE_LENGTH);
    state->tick++;
@hold@    @law@_play(state, older < @LAW@_SEQUENCE_LENGTH ? (uint8_t)older : (uint8_t)@LAW@_EMPTY);
}
";

const SATURATE: &str = "        if (input < @law@_min[i]) {
            input = @law@_min[i];
        }
        if (input > @law@_max[i]) {
            input = @law@_max[i];
        }
";

/// Where packets older than the current cycle may still be applied: `N > 1`.
const ARRIVAL: &str = "
/* Probability that a packet of age b >= 1 arrives by m cycles from now, given that it had not by the last cycle. */
static @scalar@ @law@_arrival(unsigned int b, unsigned int m)
{
    const unsigned int last = @LAW@_SEQUENCE_LENGTH - 1u - b;

    return @law@_r[(b - 1u) * (2u * @LAW@_SEQUENCE_LENGTH - b) / 2u + (m < last ? m : last)];
}

/* Input `i` meant for m cycles from now in a packet sent `ago` cycles before the current one; past its end the
 * default input. */
static @scalar@ @law@_entry(const @law@_packet *packet, unsigned int ago, unsigned int m, unsigned int i)
{
    return ago + m < @LAW@_SEQUENCE_LENGTH ? packet->inputs[ago + m][i] : @past_end@;
}
";

const EXPECTED: &str = "
/* v: the input to expect in each of the coming cycles if nothing sent from now on arrived. */
static void @law@_expect(const @law@_state *state, @scalar@ expected[@LAW@_IN_FLIGHT][@LAW@_INPUTS])
{
@body@}
";

const ONLY_HELD: &str = "    /* A sequence of one input has run out when the next cycle begins. */
    for (unsigned int i = 0; i < @LAW@_INPUTS; i++) {
        expected[0][i] = state->applied[i];
    }
";

const FROM_OLD_TO_NEW: &str = "    const unsigned int buffered = state->age < @LAW@_SEQUENCE_LENGTH ? state->age + 1u : @LAW@_SEQUENCE_LENGTH;
    const @law@_packet *packet = buffered < @LAW@_SEQUENCE_LENGTH ? @law@_sent(state, buffered) : NULL;

    /* What is in the buffer, played on. */
    for (unsigned int m = 0; m < @LAW@_IN_FLIGHT; m++) {
        for (unsigned int i = 0; i < @LAW@_INPUTS; i++) {
            expected[m][i] = packet != NULL ? @law@_entry(packet, buffered, m, i) : @run_out@;
        }
    }
    /* Each newer packet replaces it where it has arrived by then. */
    for (unsigned int b = buffered - 1u; b >= 1u; b--) {
        packet = @law@_sent(state, b);
        if (packet == NULL) {
            continue;
        }
        for (unsigned int m = 0; m < @LAW@_IN_FLIGHT; m++) {
            const @scalar@ arrived = @law@_arrival(b, m);

            for (unsigned int i = 0; i < @LAW@_INPUTS; i++) {
                const @scalar@ input = @law@_entry(packet, b, m, i);

                expected[m][i] = input * arrived + expected[m][i] * (@one@ - arrived);
            }
        }
    }
";

const FUNCTIONS: &str = "
void @law@_init(@law@_state *state, uint32_t tick)
{
    memset(state, 0, sizeof *state);
    state->tick = tick;
    state->age = @LAW@_EMPTY;
}

bool @law@_acknowledge(@law@_state *state, uint8_t age)
{
    if (age != @LAW@_EMPTY && (age >= @LAW@_SEQUENCE_LENGTH || @law@_sent(state, age + 1u) == NULL)) {
        return false;
    }
    @law@_play(state, age);
    return true;
}

bool @law@_sequence(@law@_state *state, const @scalar@ state_estimate[@LAW@_STATES],
    @scalar@ sequence[@LAW@_SEQUENCE_LENGTH][@LAW@_INPUTS])
{
    @law@_packet *packet = &state->packets[state->next];
    bool finite = true;
@expect@
    for (unsigned int step = 0; step < @LAW@_SEQUENCE_LENGTH; step++) {
        for (unsigned int i = 0; i < @LAW@_INPUTS; i++) {
            const unsigned int row = step * @LAW@_INPUTS + i;
            @scalar@ input = @zero@;
@from_sent_declaration@
            for (unsigned int j = 0; j < @LAW@_STATES; j++) {
                input += @law@_lx[row][j] * state_estimate[j];
            }
@from_sent@            /* Infinite minus infinite is no number, and no number equals none. */
            finite = finite && input - input == @zero@;
            packet->inputs[step][i] = input;
            sequence[step][i] = input;
        }
    }
    packet->tick = state->tick;
    packet->sent = finite;
    @law@_finish(state);
    return finite;
}

void @law@_unsent(@law@_state *state)
{
    state->packets[(state->next + @LAW@_SEQUENCE_LENGTH - 1u) % @LAW@_SEQUENCE_LENGTH].sent = false;
}

void @law@_skip(@law@_state *state)
{
    state->packets[state->next].sent = false;
    @law@_finish(state);
}
";

const EXPECT: &str = "    @scalar@ expected[@LAW@_IN_FLIGHT][@LAW@_INPUTS];

    @law@_expect(state, expected);";

const FROM_SENT: &str = "            for (unsigned int m = 0; m < @LAW@_IN_FLIGHT; m++) {
                for (unsigned int j = 0; j < @LAW@_INPUTS; j++) {
                    from_sent += @law@_m[row][m * @LAW@_INPUTS + j] * expected[m][j];
                }
            }
            input += from_sent;
";

/// The source for `report`. `mark`: checksum of both files.
pub(super) fn text(
    report: &Report,
    origin: &str,
    names: &Names,
    mark: DesignId,
) -> Result<String, EmitError> {
    let hold = report.solution.law.default_input == DefaultInput::Hold;
    let limits = report.design.controller.input_limits.is_some();
    let (in_flight, length) = (report.in_flight(), report.solution.law.length);
    let text = [
        PRELUDE.replace("@mark@", &mark.to_string()),
        tables(report)?,
        SENT.into(),
        if length > 1 { ARRIVAL.into() } else { String::new() },
        if in_flight > 0 { EXPECTED.into() } else { String::new() },
        FUNCTIONS.into(),
    ]
    .concat()
    .replace("@body@", if length > 1 { FROM_OLD_TO_NEW } else { ONLY_HELD })
    .replace("@saturate@", if limits { SATURATE } else { "" })
    .replace("@default@", if hold { "state->held[i]" } else { "@zero@" })
    .replace("@run_out@", if hold { "state->applied[i]" } else { "@zero@" })
    .replace("@past_end@", if hold { "packet->inputs[@LAW@_SEQUENCE_LENGTH - 1u][i]" } else { "@zero@" })
    .replace(
        "@hold@",
        if hold { "    memcpy(state->held, state->applied, sizeof state->held);\n" } else { "" },
    )
    .replace("@expect@\n", &if in_flight > 0 { format!("{EXPECT}\n") } else { String::new() })
    .replace(
        "@from_sent_declaration@\n",
        if in_flight > 0 { "            @scalar@ from_sent = @zero@;\n\n" } else { "\n" },
    )
    .replace("@from_sent@", if in_flight > 0 { FROM_SENT } else { "" });
    // Names that are not ours stay out of the replacements.
    let first = format!("/*\n * {}\n */\n\n#include \"{}.h\"\n", generated(report, origin), names.stem);
    Ok(first + &names.fill(&text, report))
}

/// The constants that a law has: arrays of no numbers are left out.
fn tables(report: &Report) -> Result<String, EmitError> {
    let (law, settings) = (&report.solution.law, &report.design.controller);
    let scalar = settings.scalar;
    let mut text = format!(
        "\n/* Lx: inputs of the sequence by states. */\n\
         static const @scalar@ @law@_lx[@LAW@_SEQUENCE_LENGTH * @LAW@_INPUTS][@LAW@_STATES] = {};\n",
        Table { name: "Lx", scalar }.c_rows(&law.lx)?
    );
    if report.in_flight() > 0 {
        text.push_str(&format!(
            "\n/* Coming cycles for which an input is to be expected. */\n\
             #define @LAW@_IN_FLIGHT {}u\n\
             /* M: inputs of the sequence by expected inputs, cycle by cycle. */\n\
             static const @scalar@ @law@_m[@LAW@_SEQUENCE_LENGTH * @LAW@_INPUTS][@LAW@_IN_FLIGHT * @LAW@_INPUTS] = {};\n",
            report.in_flight(),
            Table { name: "M", scalar }.c_rows(&law.m)?
        ));
    }
    if !law.arrival.is_empty() {
        text.push_str(&format!(
            "\n/* r: for packets of age 1 to N-1, how likely they arrive by 0, 1, .. cycles from now. */\n\
             static const @scalar@ @law@_r[{}] = {};\n",
            law.arrival.len(),
            Table { name: "r", scalar }.c_list(&law.arrival, 0)?
        ));
    }
    if let Some(pairs) = &settings.input_limits {
        let table = Table { name: "controller.input_limits", scalar };
        let (min, max): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        text.push_str(&format!(
            "\n/* Limits of the actuator, in input units. */\n\
             static const @scalar@ @law@_min[@LAW@_INPUTS] = {};\n\
             static const @scalar@ @law@_max[@LAW@_INPUTS] = {};\n",
            table.c_list(&min, 0)?,
            table.c_list(&max, 0)?
        ));
    }
    Ok(text + "\n")
}
