/* The planes that bound shadows: scattering/physical_optics/cast_shadows.py. */

#include <string.h>

#include "shadows.h"

static const double NEAR = 2e-3, NEAR_SHARE = 2e-6, EDGE_ON = 1e-9; /* of the same names in Python */

static void divide(double *vector, double by) {
    for (int axis = 0; axis < 3; axis++) vector[axis] /= by;
}

/* The shadows of triangles (T, 3, 3), T = count, at virtual positions: `CastShadows`. Returns how many cast one: these go to kept
 * (T, 3, 3), plane (T, 4, 3), offset (T, 4), distance (T). */
/* Arrays: corners, kept (count, 3, 3); plane (count, 4, 3); offset (count, 4); distance (count) */
KERNEL int64_t shadow_planes(int64_t count, const double *corners, double *kept, double *plane, double *offset, double *distance) {
    int64_t total = 0;
    for (int64_t i = 0; i < count; i++) {
        const double *a = corners + 9 * i, *b = a + 3, *c = a + 6;
        double planes[4][3], ab[3], ac[3];
        subtract(b, a, ab);
        subtract(c, a, ac);
        cross(a, b, planes[0]);
        cross(b, c, planes[1]);
        cross(c, a, planes[2]);
        cross(ab, ac, planes[3]);
        for (int k = 0; k < 4; k++) divide(planes[k], larger(sqrt(dot(planes[k], planes[k])), 1e-30));
        double far = sqrt(dot(a, a)), away = dot(planes[3], a), side = dot(planes[0], c), turn = (side > 0.0) - (side < 0.0);
        if (!(fabs(away) > EDGE_ON * far) || side == 0.0) continue; /* corners in line: the normal is rounding */
        for (int k = 0; k < 4; k++)
            for (int axis = 0; axis < 3; axis++) planes[k][axis] *= k < 3 ? turn : away > 0.0 ? 1.0 : -1.0;
        memcpy(kept + 9 * total, a, 9 * sizeof *kept);
        memcpy(plane + 12 * total, planes, sizeof planes);
        for (int k = 0; k < 3; k++) offset[4 * total + k] = 0.0;
        offset[4 * total + 3] = fabs(away) * (1.0 + NEAR / larger(far, NEAR) + NEAR_SHARE);
        distance[total++] = smaller(smaller(far, sqrt(dot(b, b))), sqrt(dot(c, c)));
    }
    return total;
}
