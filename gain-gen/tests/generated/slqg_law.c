/*
 * The control law of the crate `slqg` in C99: U = Lx x + M v, in the order of `slqg::in_flight` and `slqg::gains`, so
 * that results agree with it to the bit.
 *
 * This file is the same for every design. It takes names, sizes and tables from the header that gain-gen wrote for the
 * design, which SLQG_LAW_DESIGN names. Compile the source written beside that header, motor.c, or this file once for
 * each design with
 *
 *     -DSLQG_LAW_DESIGN='"motor.h"'
 *
 * Without a design nothing is compiled: a build that takes every source of a folder may take this one, too.
 */

#ifndef SLQG_LAW_DESIGN

/* C knows no empty source. */
typedef int slqg_law_without_a_design;

#else

#include <string.h>

/* The design's header keeps the names of the law, and adds its tables. */
#define SLQG_LAW_SOURCE
#include SLQG_LAW_DESIGN

#ifdef __FAST_MATH__
#error "without -ffast-math: it reorders sums, and takes for granted that all numbers are finite"
#endif

/* Every product and every sum is rounded by itself, as in the simulation: no fused multiply-add. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize ("fp-contract=off")
#elif defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract (off)
#else
#pragma STDC FP_CONTRACT OFF
#endif

/* The sequence sent `ago` cycles before the current one, 1 to N; NULL if none was. */
static const SLQG_LAW(packet) *SLQG_LAW(sent)(const SLQG_LAW(state) *state, unsigned int ago)
{
    const unsigned int at = (state->next + SLQG_LAW_LENGTH - ago) % SLQG_LAW_LENGTH;
    const SLQG_LAW(packet) *packet = &state->packets[at];

    return packet->sent && packet->tick == (uint32_t)(state->tick - ago) ? packet : NULL;
}

/* `input` as the actuator applies it: entry `i` of an input, within the limits. */
static SLQG_LAW_SCALAR SLQG_LAW(saturated)(SLQG_LAW_SCALAR input, unsigned int i)
{
#if SLQG_LAW_LIMITS
    if (input < SLQG_LAW(min)[i]) {
        input = SLQG_LAW(min)[i];
    }
    if (input > SLQG_LAW(max)[i]) {
        input = SLQG_LAW(max)[i];
    }
#else
    (void)i;
#endif
    return input;
}

/* Takes `age` for what was played in the last cycle, and works out the input that left the actuator. */
static void SLQG_LAW(play)(SLQG_LAW(state) *state, uint8_t age)
{
    const SLQG_LAW(packet) *packet = age < SLQG_LAW_LENGTH ? SLQG_LAW(sent)(state, age + 1u) : NULL;

    state->age = age;
    for (unsigned int i = 0; i < SLQG_LAW_INPUTS; i++) {
#if SLQG_LAW_HOLD
        const SLQG_LAW_SCALAR run_out = state->held[i];
#else
        const SLQG_LAW_SCALAR run_out = 0;
#endif

        state->applied[i] = SLQG_LAW(saturated)(packet != NULL ? packet->inputs[age][i] : run_out, i);
    }
}

/* Begins the next cycle. Until told otherwise, the actuator played on without a new packet. */
static void SLQG_LAW(finish)(SLQG_LAW(state) *state)
{
    const unsigned int older = state->age + 1u;

    state->next = (uint8_t)((state->next + 1u) % SLQG_LAW_LENGTH);
    state->tick++;
#if SLQG_LAW_HOLD
    memcpy(state->held, state->applied, sizeof state->held);
#endif
    SLQG_LAW(play)(state, older < SLQG_LAW_LENGTH ? (uint8_t)older : (uint8_t)SLQG_LAW_EMPTY);
}

/* Packets older than the current cycle may still be applied. */
#if SLQG_LAW_LENGTH > 1

/* Probability that a packet of age b >= 1 arrives by m cycles from now, given that it had not by the last cycle. */
static SLQG_LAW_SCALAR SLQG_LAW(arrival)(unsigned int b, unsigned int m)
{
    const unsigned int last = SLQG_LAW_LENGTH - 1u - b;

    return SLQG_LAW(r)[(b - 1u) * (2u * SLQG_LAW_LENGTH - b) / 2u + (m < last ? m : last)];
}

/* Input `i` meant for m cycles from now in a packet sent `ago` cycles before the current one; past its end the
 * default input. */
static SLQG_LAW_SCALAR SLQG_LAW(entry)(const SLQG_LAW(packet) *packet, unsigned int ago, unsigned int m, unsigned int i)
{
#if SLQG_LAW_HOLD
    const SLQG_LAW_SCALAR past_end = packet->inputs[SLQG_LAW_LENGTH - 1u][i];
#else
    const SLQG_LAW_SCALAR past_end = 0;
#endif

    return ago + m < SLQG_LAW_LENGTH ? packet->inputs[ago + m][i] : past_end;
}

/* v: the input to expect in each of the coming cycles if nothing sent from now on arrived. */
static void SLQG_LAW(expect)(
    const SLQG_LAW(state) *state, SLQG_LAW_SCALAR expected[SLQG_LAW_IN_FLIGHT][SLQG_LAW_INPUTS])
{
    const unsigned int buffered = state->age < SLQG_LAW_LENGTH ? state->age + 1u : SLQG_LAW_LENGTH;
    const SLQG_LAW(packet) *packet = buffered < SLQG_LAW_LENGTH ? SLQG_LAW(sent)(state, buffered) : NULL;

    /* What is in the buffer, played on. */
    for (unsigned int m = 0; m < SLQG_LAW_IN_FLIGHT; m++) {
        for (unsigned int i = 0; i < SLQG_LAW_INPUTS; i++) {
#if SLQG_LAW_HOLD
            const SLQG_LAW_SCALAR run_out = state->applied[i];
#else
            const SLQG_LAW_SCALAR run_out = 0;
#endif

            expected[m][i] = packet != NULL ? SLQG_LAW(entry)(packet, buffered, m, i) : run_out;
        }
    }
    /* Each newer packet replaces it where it has arrived by then. */
    for (unsigned int b = buffered - 1u; b >= 1u; b--) {
        packet = SLQG_LAW(sent)(state, b);
        if (packet == NULL) {
            continue;
        }
        for (unsigned int m = 0; m < SLQG_LAW_IN_FLIGHT; m++) {
            const SLQG_LAW_SCALAR arrived = SLQG_LAW(arrival)(b, m);

            for (unsigned int i = 0; i < SLQG_LAW_INPUTS; i++) {
                const SLQG_LAW_SCALAR input = SLQG_LAW(entry)(packet, b, m, i);

                expected[m][i] = input * arrived + expected[m][i] * (1 - arrived);
            }
        }
    }
}

#elif SLQG_LAW_HOLD

/* A sequence of one input has run out when the next cycle begins: what was applied last is held. */
static void SLQG_LAW(expect)(
    const SLQG_LAW(state) *state, SLQG_LAW_SCALAR expected[SLQG_LAW_IN_FLIGHT][SLQG_LAW_INPUTS])
{
    for (unsigned int i = 0; i < SLQG_LAW_INPUTS; i++) {
        expected[0][i] = state->applied[i];
    }
}

#endif

void SLQG_LAW(init)(SLQG_LAW(state) *state, uint32_t tick)
{
    memset(state, 0, sizeof *state);
    state->tick = tick;
    state->age = SLQG_LAW_EMPTY;
}

bool SLQG_LAW(acknowledge)(SLQG_LAW(state) *state, uint8_t age)
{
    if (age != SLQG_LAW_EMPTY && (age >= SLQG_LAW_LENGTH || SLQG_LAW(sent)(state, age + 1u) == NULL)) {
        return false;
    }
    SLQG_LAW(play)(state, age);
    return true;
}

bool SLQG_LAW(sequence)(SLQG_LAW(state) *state, const SLQG_LAW_SCALAR state_estimate[SLQG_LAW_STATES],
    SLQG_LAW_SCALAR sequence[SLQG_LAW_LENGTH][SLQG_LAW_INPUTS])
{
    SLQG_LAW(packet) *packet = &state->packets[state->next];
    bool finite = true;
#if SLQG_LAW_IN_FLIGHT
    SLQG_LAW_SCALAR expected[SLQG_LAW_IN_FLIGHT][SLQG_LAW_INPUTS];

    SLQG_LAW(expect)(state, expected);
#endif
    for (unsigned int step = 0; step < SLQG_LAW_LENGTH; step++) {
        for (unsigned int i = 0; i < SLQG_LAW_INPUTS; i++) {
            const unsigned int row = step * SLQG_LAW_INPUTS + i;
            SLQG_LAW_SCALAR input = 0;
#if SLQG_LAW_IN_FLIGHT
            SLQG_LAW_SCALAR from_sent = 0;
#endif

            for (unsigned int j = 0; j < SLQG_LAW_STATES; j++) {
                input += SLQG_LAW(lx)[row][j] * state_estimate[j];
            }
#if SLQG_LAW_IN_FLIGHT
            for (unsigned int m = 0; m < SLQG_LAW_IN_FLIGHT; m++) {
                for (unsigned int j = 0; j < SLQG_LAW_INPUTS; j++) {
                    from_sent += SLQG_LAW(m)[row][m * SLQG_LAW_INPUTS + j] * expected[m][j];
                }
            }
            input += from_sent;
#endif
            /* Infinite minus infinite is no number, and no number equals none. */
            finite = finite && input - input == 0;
            packet->inputs[step][i] = input;
            sequence[step][i] = input;
        }
    }
    packet->tick = state->tick;
    packet->sent = finite;
    SLQG_LAW(finish)(state);
    return finite;
}

void SLQG_LAW(unsent)(SLQG_LAW(state) *state)
{
    state->packets[(state->next + SLQG_LAW_LENGTH - 1u) % SLQG_LAW_LENGTH].sent = false;
}

void SLQG_LAW(skip)(SLQG_LAW(state) *state)
{
    state->packets[state->next].sent = false;
    SLQG_LAW(finish)(state);
}

#endif
