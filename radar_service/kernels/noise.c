/* Receiver noise: receive/noise.py. */

#include <stdlib.h>

#include "geometry.h"

/* Normal numbers by the 16-bit words of random ones, `quantile` of each, times `weight`: one row after the other, `above` columns
 * from the first on and `below` up to the last, `gap` of 0 between; or adds them to the rows. */
/* Arrays: words (total); quantile (65536); weight (above + below); spectrum (rows, above + gap + below) */
KERNEL int64_t weighted_normals(int64_t rows, int64_t above, int64_t gap, int64_t below, int64_t adds, int64_t total,
                                const int64_t *words, const float *quantile, const float *weight, float *spectrum) {
    int64_t count = above + below, drawn = 0;
    if (rows * count > 4 * total) return REFUSED;
    float *normal = malloc((size_t)(count + 7) * sizeof *normal), *row = spectrum;
    if (!normal) return NO_MEMORY;
    for (int64_t r = 0; r < rows; r++, row += count + gap) {
        const int64_t *word = words + drawn / 4;
        float *first = normal + drawn % 4; /* of the row, after what the row before has had of the word */
        for (int64_t i = 0; i < drawn % 4 + count; i += 4) {
            uint64_t bits = (uint64_t)*word++;
            normal[i] = quantile[bits & 0xFFFF];
            normal[i + 1] = quantile[bits >> 16 & 0xFFFF];
            normal[i + 2] = quantile[bits >> 32 & 0xFFFF];
            normal[i + 3] = quantile[bits >> 48];
        }
        for (int64_t i = 0; i < above; i++) row[i] = (adds ? row[i] : -0.0f) + first[i] * weight[i];
        for (int64_t i = above; i < above + gap && !adds; i++) row[i] = 0.0f;
        for (int64_t i = above; i < count; i++) row[gap + i] = (adds ? row[gap + i] : -0.0f) + first[i] * weight[i];
        drawn += count;
    }
    free(normal);
    return rows;
}
