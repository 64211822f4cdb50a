/* Beam weights of moving echoes: `BeamTable.weights` of echo/echoes.py, in single precision. */

#include "geometry.h"

/* Weights (E, K), E = count, K = azimuths, of a table of gains (N), N = entries, with the change of range loss.
 *
 * per_radian: entries a radian. boresight (K): since the middle; azimuth_change (E, K): of echoes; offset (E): of echoes before
 * the middle boresight [rad]. migration (E, K): change of range [m]; inverse (E): 1 / range [1/m]. */
/* Arrays: entries from 1; boresight (azimuths); azimuth_change, migration, weight (count, azimuths); offset, inverse (count); table (entries) */
KERNEL int64_t beam_weights(int64_t count, int64_t azimuths, int64_t entries, double per_radian, const float *boresight,
                            const float *azimuth_change, const float *offset, const float *migration, const float *inverse,
                            const float *table, float *weight) {
    if (!(per_radian >= 0.0)) return REFUSED;
    float scale = (float)per_radian, top = (float)(entries - 1);
    for (int64_t i = 0; i < count; i++) {
        const float *change = azimuth_change + i * azimuths, *moved = migration + i * azimuths;
        float *result = weight + i * azimuths;
        for (int64_t k = 0; k < azimuths; k++) {
            float place = fabsf(boresight[k] - change[k] + offset[i]) * scale + 0.5f;
            result[k] = table[(int64_t)(place < top ? place : top)];
        }
        for (int64_t k = 0; k < azimuths; k++) {
            float relative = moved[k] * inverse[i] + 1.0f;
            result[k] /= relative * relative;
        }
    }
    return count;
}
