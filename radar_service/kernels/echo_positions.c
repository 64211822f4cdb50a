/* Where echoes are at some instants: `BlockGeometry.positions` of echo/block_geometry.py. Lengths are in metres. */

#include "geometry.h"

/* Echoes (E), E = count, and N = instants; bodies: B. which (E): of the M observed. place (M, 3): of each on the map; own (M, 3):
 * in its body's frame; body (M). moves (B): whether a body moves on the map. leans (B): the number of its matrix, -1 for an upright
 * one. pose (N, B, 3): positions; cosine, sine (N, B): of headings; lean (N, R, 3, 3), R = matrices: map_from_body. antenna (N, 3)
 * on the map. */
typedef struct {
    int64_t count, instants, observed, bodies, matrices;
    const int64_t *which;
    const double *place, *own;
    const int64_t *body;
    const uint8_t *moves;
    const int64_t *leans;
    const double *pose, *cosine, *sine, *lean, *antenna;
    double *result;
} Echoes;

/* Positions relative to the antenna of echoes at some instants: result (N, 3, E), by axis. */
/* Arrays: which (count); place, own (observed, 3); body (observed); moves, leans (bodies); pose (instants, bodies, 3);
 * cosine, sine (instants, bodies); lean (instants, matrices, 3, 3); antenna (instants, 3); result (instants, 3, count) */
KERNEL int64_t echo_positions(const Echoes *echoes) {
    int64_t count = echoes->count, bodies = echoes->bodies;
    for (int64_t n = 0; n < echoes->instants; n++) {
        double *x = echoes->result + 3 * n * count, *y = x + count, *z = y + count;
        const double *from = echoes->antenna + 3 * n;
        for (int64_t i = 0; i < count; i++) {
            int64_t echo = echoes->which[i], b;
            if (echo < 0 || echo >= echoes->observed) return REFUSED;
            b = echoes->body[echo];
            if (b < 0 || b >= bodies || echoes->leans[b] >= echoes->matrices) return REFUSED;
            const double *point = echoes->own + 3 * echo, *at = echoes->pose + 3 * (n * bodies + b);
            double moved[3];
            if (!echoes->moves[b]) {
                for (int axis = 0; axis < 3; axis++) moved[axis] = echoes->place[3 * echo + axis];
            } else if (echoes->leans[b] >= 0) {
                const double *row = echoes->lean + 9 * (n * echoes->matrices + echoes->leans[b]);
                for (int axis = 0; axis < 3; axis++, row += 3) /* in the order of numpy's einsum */
                    moved[axis] = point[0] * row[0] + point[2] * row[2] + point[1] * row[1] + at[axis];
            } else {
                double c = echoes->cosine[n * bodies + b], s = echoes->sine[n * bodies + b];
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
