/*
 * Runs a law on cycles read from stdin and prints what it does; numbers are bit patterns in hexadecimal.
 *
 * First comes the tick, then for each cycle: the age acknowledged (256: no acknowledgement), what becomes of the
 * sequence (0: sent, 1: computed and not sent, 2: not computed) and the state. Answers a line a cycle: whether the
 * acknowledgement was believed (2: there was none) and the input applied; then whether the sequence is finite, and if
 * so the sequence.
 *
 * The test puts the scalar and its bits in the place of @scalar@ and @bits@.
 */
#include "law.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static bool take(@scalar@ *value)
{
    uint@bits@_t bits;
    const bool taken = scanf("%" SCNx@bits@, &bits) == 1;
    memcpy(value, &bits, sizeof *value);
    return taken;
}

static void give(@scalar@ value)
{
    uint@bits@_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf(" %" PRIx@bits@, bits);
}

int main(void)
{
    static law_state law;
    uint32_t tick;
    unsigned int age, action;

    if (scanf("%" SCNu32, &tick) != 1) {
        return 1;
    }
    law_init(&law, tick);
    while (scanf("%u %u", &age, &action) == 2) {
        @scalar@ state[LAW_STATES], sequence[LAW_SEQUENCE_LENGTH][LAW_INPUTS];
        for (unsigned int j = 0; j < LAW_STATES; j++) {
            if (!take(&state[j])) {
                return 1;
            }
        }
        printf("%u", age == 256u ? 2u : law_acknowledge(&law, (uint8_t)age) ? 1u : 0u);
        for (unsigned int i = 0; i < LAW_INPUTS; i++) {
            give(law.applied[i]);
        }
        if (action == 2u) {
            law_skip(&law);
        } else {
            const bool finite = law_sequence(&law, state, sequence);
            printf(finite ? " finite" : " not finite");
            for (unsigned int step = 0; finite && step < LAW_SEQUENCE_LENGTH; step++) {
                for (unsigned int i = 0; i < LAW_INPUTS; i++) {
                    give(sequence[step][i]);
                }
            }
            if (action == 1u) {
                law_unsent(&law);
            }
        }
        printf("\n");
    }
    return 0;
}
