/*
 * The control law of the crate `slqg` in C99: the declarations, under the names and sizes of one design.
 *
 * This file is the same for every design. Do not include it: include the header that gain-gen wrote for the design,
 * say motor.h. That defines the macros below and includes this file, so that here SLQG_LAW(init) reads motor_init.
 * Headers of several designs may be included in one source.
 *
 *     SLQG_LAW(name)           name of a type, function or table: motor_##name
 *     SLQG_LAW_SCALAR          float or double
 *     SLQG_LAW_STATES          states of the plant, nx
 *     SLQG_LAW_INPUTS          inputs of the plant, nu
 *     SLQG_LAW_LENGTH          inputs per control sequence, N, 1 to 254
 *     SLQG_LAW_HOLD            1: the default input is the one applied last; 0: it is zero
 *     SLQG_LAW_LIMITS          1: the actuator keeps its inputs within limits; 0: it has none
 *     SLQG_LAW_FORM_EXPECTED   the form of this file that the design's header was written for
 */

/* Raised whenever a header of an older gain-gen would be misread. */
#ifndef SLQG_LAW_FORM
#define SLQG_LAW_FORM 1u
#endif
#if SLQG_LAW_FORM != SLQG_LAW_FORM_EXPECTED
#error "slqg_law.h and the design's header were written by different versions of gain-gen: write them anew, together"
#endif

/* In place of an age: the actuator applied the default input. */
#ifndef SLQG_LAW_EMPTY
#define SLQG_LAW_EMPTY 255u
#endif

/* Coming cycles for which an input is to be expected, n_v. */
#define SLQG_LAW_IN_FLIGHT (SLQG_LAW_LENGTH - 1u + SLQG_LAW_HOLD)

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A sequence as it was sent. */
typedef struct {
    uint32_t tick; /* the cycle it was made in */
    bool sent;     /* false: nothing was sent in that cycle */
    SLQG_LAW_SCALAR inputs[SLQG_LAW_LENGTH][SLQG_LAW_INPUTS];
} SLQG_LAW(packet);

/* What the law remembers of one loop. Read what you like; write by the functions below only. */
typedef struct {
    /* Number of the current cycle, modulo 2^32. */
    uint32_t tick;
    /* The input that left the actuator in the last cycle, in input units, as far as is known. */
    SLQG_LAW_SCALAR applied[SLQG_LAW_INPUTS];
    /* Age of the sequence it came from: cycles since that was made; SLQG_LAW_EMPTY: the default input. */
    uint8_t age;
    /* Place of the current cycle in the ring of the last cycles. */
    uint8_t next;
#if SLQG_LAW_HOLD
    /* The input of the cycle before the last: what the default input held in that. */
    SLQG_LAW_SCALAR held[SLQG_LAW_INPUTS];
#endif
    SLQG_LAW(packet) packets[SLQG_LAW_LENGTH];
} SLQG_LAW(state);

/* Begins: the first cycle is `tick`, nothing was sent and the actuator applied zero so far. */
void SLQG_LAW(init)(SLQG_LAW(state) *state, uint32_t tick);

/*
 * Tells what the actuator applied in the last cycle, the one before state->tick: the input of the sequence made
 * `age` cycles before it, or the default input (SLQG_LAW_EMPTY). At most once a cycle, before SLQG_LAW(sequence).
 * Updates state->applied, within the limits of the actuator if it has any.
 *
 * Without it the actuator is held to have played on without a new packet. An acknowledgement that comes later than
 * this is of no use here: do not pass it.
 *
 * Returns false and changes nothing if no such sequence was sent: the acknowledgement deserves no belief.
 */
bool SLQG_LAW(acknowledge)(SLQG_LAW(state) *state, uint8_t age);

/*
 * Computes the control sequence of the current cycle, remembers it as sent, and begins the next cycle.
 *
 * state_estimate: the state in the current cycle, given all measurements up to now, in state units.
 * sequence: receives one row a cycle, the first for the current one, in input units; limits are the actuator's to keep.
 *
 * Returns false if a number is not finite. Do not send such a sequence; it is remembered as not sent.
 */
bool SLQG_LAW(sequence)(SLQG_LAW(state) *state, const SLQG_LAW_SCALAR state_estimate[SLQG_LAW_STATES],
    SLQG_LAW_SCALAR sequence[SLQG_LAW_LENGTH][SLQG_LAW_INPUTS]);

/* Tells, after SLQG_LAW(sequence), that the sequence was not sent after all. */
void SLQG_LAW(unsent)(SLQG_LAW(state) *state);

/* Instead of SLQG_LAW(sequence): sends nothing in the current cycle and begins the next one. */
void SLQG_LAW(skip)(SLQG_LAW(state) *state);

#ifdef __cplusplus
}
#endif

/* The source works under the same names. All others may include the header of another design next. */
#ifndef SLQG_LAW_SOURCE
#undef SLQG_LAW
#undef SLQG_LAW_SCALAR
#undef SLQG_LAW_STATES
#undef SLQG_LAW_INPUTS
#undef SLQG_LAW_LENGTH
#undef SLQG_LAW_HOLD
#undef SLQG_LAW_LIMITS
#undef SLQG_LAW_FORM_EXPECTED
#undef SLQG_LAW_IN_FLIGHT
#endif
