/* Receiver noise: receive/noise.py. */

#include <stdlib.h>

#include "geometry.h"

/* The next number of SFC64 (C. Doty-Humphrey, PractRand). */
static inline uint64_t next_of(uint64_t *s) {
    uint64_t number = s[0] + s[1] + s[3]++;
    s[0] = s[1] ^ (s[1] >> 11);
    s[1] = s[2] + (s[2] << 3);
    s[2] = (s[2] << 24 | s[2] >> 40) + number;
    return number;
}

/* Normal numbers by the 16-bit words of random ones, `quantile` of each, times `weight`: one row after the other, `above` columns
 * from the first on and `below` up to the last, `gap` of 0 between; or adds them to the rows. `state`: of SFC64. */
/* Arrays: state (4); quantile (65536); weight (above + below); spectrum (rows, above + gap + below) */
KERNEL int64_t weighted_normals(int64_t rows, int64_t above, int64_t gap, int64_t below, int64_t adds, const int64_t *state,
                                const float *quantile, const float *weight, float *spectrum) {
    int64_t count = above + below, drawn = 0;
    uint64_t random[4] = {(uint64_t)state[0], (uint64_t)state[1], (uint64_t)state[2], (uint64_t)state[3]};
    float *normal = malloc((size_t)(count + 7) * sizeof *normal), *row = spectrum;
    if (!normal) return NO_MEMORY;
    for (int64_t r = 0; r < rows; r++, row += count + gap) {
        float *first = normal + drawn % 4; /* of the row, after what the row before has had of the word */
        for (int64_t i = drawn % 4 ? 4 : 0; i < drawn % 4 + count; i += 4) {
            uint64_t bits = next_of(random);
            normal[i] = quantile[bits & 0xFFFF];
            normal[i + 1] = quantile[bits >> 16 & 0xFFFF];
            normal[i + 2] = quantile[bits >> 32 & 0xFFFF];
            normal[i + 3] = quantile[bits >> 48];
        }
        for (int64_t i = 0; i < above; i++) row[i] = (adds ? row[i] : -0.0f) + first[i] * weight[i];
        for (int64_t i = above; i < above + gap && !adds; i++) row[i] = 0.0f;
        for (int64_t i = above; i < count; i++) row[gap + i] = (adds ? row[gap + i] : -0.0f) + first[i] * weight[i];
        drawn += count;
        for (int64_t i = 0, last = (first - normal + count) / 4 * 4; drawn % 4 && i < 4; i++) normal[i] = normal[last + i];
    }
    free(normal);
    return rows;
}
