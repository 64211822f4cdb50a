/* Sums on the nodes of a lattice: scattering/physical_optics/scattering_centres.py. */

#include "geometry.h"
#include "phasors.h"

/* Adds to `total` (N) the shares of amplitudes (W), W = count, of the points from `begin` on. corner, share (8, M): as of
 * `Lattice`, M = points. */
KERNEL int64_t lattice_sums(int64_t count, int64_t begin, int64_t points, const int64_t *corner, const double *share,
                            const Complex *amplitude, Complex *total) {
    for (int64_t i = 0; i < count; i++)
        for (int64_t c = 0; c < 8; c++) {
            int64_t at = c * points + begin + i;
            total[corner[at]] = plus(total[corner[at]], scaled(amplitude[i], share[at]));
        }
    return count;
}
