/* The planes that bound shadows, and the silhouettes at which these end: scattering/physical_optics/cast_shadows.py,
 * silhouettes.py. */

#include <stdlib.h>
#include <string.h>

#include "shadows.h"

static const double NEAR = 2e-3, NEAR_SHARE = 2e-6, EDGE_ON = 1e-9, ON_PLANE = 1e-6, SAME_POINT = 1e-5; /* of both */

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

typedef struct {
    int64_t at[3], corner;
} Corner; /* in steps of SAME_POINT, and which corner it is */

typedef struct {
    int64_t low, high, third;
} Edge; /* numbers of its ends, and which corner lies opposite to it */

static int by_place(const void *left, const void *right) {
    const Corner *a = left, *b = right;
    for (int axis = 0; axis < 3; axis++)
        if (a->at[axis] != b->at[axis]) return a->at[axis] < b->at[axis] ? -1 : 1;
    return (a->corner > b->corner) - (a->corner < b->corner);
}

static int by_ends(const void *left, const void *right) {
    const Edge *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return (a->third > b->third) - (a->third < b->third);
}

/* Makes a vector of length 1, or 0 where it is shorter than 1e-9; returns whether it has a length. */
static int unit(double *vector) {
    double length = sqrt(dot(vector, vector));
    for (int axis = 0; axis < 3; axis++) vector[axis] = length > 1e-9 ? vector[axis] / length : 0.0;
    return length > 1e-9;
}

/* Planes (4, 3) and offsets (4) of an edge from a to b with a normal: as of `silhouettes`. */
static void bounds(const double *a, const double *b, const double *normal, double *plane, double *offset) {
    memcpy(plane, normal, 3 * sizeof *plane);
    cross(normal, a, plane + 3);
    cross(b, normal, plane + 6);
    for (int axis = 0; axis < 3; axis++) plane[9 + axis] = a[axis] + b[axis];
    for (int k = 1; k < 4; k++) unit(plane + 3 * k);
    for (int k = 0; k < 3; k++) offset[k] = 0.0;
    offset[3] = smaller(dot(a, plane + 9), dot(b, plane + 9));
}

/* `silhouettes` of triangles (T, 3, 3), T = count: planes (3 T, 4, 3) and offsets (3 T, 4). Returns how many there are. */
/* Arrays: corners (count, 3, 3); plane (3 * count, 4, 3); offset (3 * count, 4) */
KERNEL int64_t silhouettes(int64_t count, const double *corners, double *plane, double *offset) {
    size_t every = 3 * (size_t)count + 1;
    Corner *places = malloc(every * sizeof *places);
    Edge *edges = malloc(every * sizeof *edges);
    int64_t *number = malloc(2 * every * sizeof *number), points = 0, total = 0;
    if (!places || !edges || !number) {
        free(places);
        free(edges);
        free(number);
        return NO_MEMORY;
    }
    int64_t *first = number + every; /* which of `places` a point is */
    for (int64_t i = 0; i < 3 * count; i++) {
        for (int axis = 0; axis < 3; axis++) places[i].at[axis] = (int64_t)rint(corners[3 * i + axis] / SAME_POINT);
        places[i].corner = i;
    }
    qsort(places, (size_t)(3 * count), sizeof *places, by_place);
    for (int64_t i = 0; i < 3 * count; i++) {
        if (!i || memcmp(places[i].at, places[i - 1].at, sizeof places[i].at)) first[points++] = i;
        number[places[i].corner] = points - 1;
    }
    for (int64_t i = 0; i < 3 * count; i++) {
        int64_t other = i % 3 == 2 ? i - 2 : i + 1, a = number[i], b = number[other];
        Edge edge = {a < b ? a : b, a < b ? b : a, i % 3 ? i - 1 : i + 2};
        edges[i] = edge;
    }
    qsort(edges, (size_t)(3 * count), sizeof *edges, by_ends);
    for (int64_t begin = 0, end; begin < 3 * count; begin = end) {
        double ends[2][3], normal[3];
        int left = 0, right = 0;
        for (int axis = 0; axis < 3; axis++) {
            ends[0][axis] = (double)places[first[edges[begin].low]].at[axis] * SAME_POINT;
            ends[1][axis] = (double)places[first[edges[begin].high]].at[axis] * SAME_POINT;
        }
        cross(ends[0], ends[1], normal);
        int real = unit(normal);
        for (end = begin; end < 3 * count && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high; end++) {
            double side = dot(normal, corners + 3 * edges[end].third);
            left |= side > ON_PLANE;
            right |= side < -ON_PLANE;
        }
        if (!real || (left && right)) continue;
        bounds(ends[0], ends[1], normal, plane + 12 * total, offset + 4 * total);
        total++;
    }
    free(places);
    free(edges);
    free(number);
    return total;
}
