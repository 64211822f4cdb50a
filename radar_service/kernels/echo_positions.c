/* Where echoes are at some instants: `BlockGeometry.positions` of echo/block_geometry.py. Lengths are in metres. */

#include "geometry.h"

/* Positions relative to the antenna of echoes (E), E = count, at N = instants: result (N, 3, E), by axis.
 *
 * bodies: B. which (E): of the M observed. place (M, 3): of each on the map; own (M, 3): in its body's frame; body (M).
 * moves (B): whether a body moves on the map. leans (B): the number of its matrix, -1 for an upright one. pose (N, B, 3): positions;
 * cosine, sine (N, B): of headings; lean (N, R, 3, 3), R = matrices: map_from_body. antenna (N, 3) on the map. */
KERNEL int64_t echo_positions(int64_t count, int64_t instants, int64_t bodies, int64_t matrices, const int64_t *which,
                              const double *place, const double *own, const int64_t *body, const uint8_t *moves,
                              const int64_t *leans, const double *pose, const double *cosine, const double *sine,
                              const double *lean, const double *antenna, double *result) {
    for (int64_t n = 0; n < instants; n++) {
        double *x = result + 3 * n * count, *y = x + count, *z = y + count;
        const double *from = antenna + 3 * n;
        for (int64_t i = 0; i < count; i++) {
            int64_t echo = which[i], b = body[echo];
            const double *point = own + 3 * echo, *at = pose + 3 * (n * bodies + b);
            double moved[3];
            if (!moves[b]) {
                for (int axis = 0; axis < 3; axis++) moved[axis] = place[3 * echo + axis];
            } else if (leans[b] >= 0) {
                const double *row = lean + 9 * (n * matrices + leans[b]);
                for (int axis = 0; axis < 3; axis++, row += 3) /* in the order of numpy's einsum */
                    moved[axis] = point[0] * row[0] + point[2] * row[2] + point[1] * row[1] + at[axis];
            } else {
                double c = cosine[n * bodies + b], s = sine[n * bodies + b];
                moved[0] = c * point[0] + s * point[1] + at[0];
                moved[1] = c * point[1] - s * point[0] + at[1];
                moved[2] = point[2] + at[2];
            }
            x[i] = moved[0] - from[0];
            y[i] = moved[1] - from[1];
            z[i] = moved[2] - from[2];
        }
    }
    return count;
}
