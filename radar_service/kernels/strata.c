/* Points on meshes, and one drawn from each of some compact groups of them: scattering/surface_sampling.py. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"

#define DIMENSIONS 6 /* of features: position and normal */
#define DIGIT 256    /* values of a digit of a key */
#define DIGITS 4
#define LANES 8 /* that numpy sums side by side, and of how many values at most */
#define BLOCK 128
#define LIMIT 2e9 /* of a whole number in a key: a body of 2 km over its rms radius, in steps */

static const double NORMAL_WEIGHT = 1.5; /* these three of scattering/surface_sampling.py */
static const double FEATURE_STEPS = 1e6;
static const double ALIKE = 0.8;

/* Points on a mesh: triangle (N) and position (N, 3), N = count, where steps (N), rising, lie in the cumulated expectation (F),
 * F = faces, and at uv (2, N) within the triangles. vertices (V, 3) [m], corner (F, 3). */
/* Arrays: faces from 1; vertices (points, 3); corner (faces, 3); cumulated (faces); steps, triangle (count); uv (2, count); position (count, 3) */
KERNEL int64_t surface_points(int64_t count, int64_t faces, int64_t points, const double *vertices, const int64_t *corner, const double *cumulated,
                              const double *steps, const double *uv, double *position, int64_t *triangle) {
    int64_t at = 0;
    for (int64_t i = 0; i < count; i++) {
        while (at < faces - 1 && cumulated[at] <= steps[i]) at++;
        for (int c = 0; c < 3; c++)
            if (corner[3 * at + c] < 0 || corner[3 * at + c] >= points) return REFUSED;
        const double *a = vertices + 3 * corner[3 * at], *b = vertices + 3 * corner[3 * at + 1];
        const double *c = vertices + 3 * corner[3 * at + 2];
        double u = uv[i], v = uv[count + i];
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        for (int axis = 0; axis < 3; axis++)
            position[3 * i + axis] = a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]);
        triangle[i] = at;
    }
    return count;
}

/* The sum of values (N), N = count, in numpy's order: whether heights are equal, and their extent 0, depends on its rounding. */
static double sum_of(int64_t count, const double *values) {
    if (count > BLOCK) {
        int64_t half = count / 2 - count / 2 % LANES;
        return sum_of(half, values) + sum_of(count - half, values + half);
    }
    double total = 0.0, lane[LANES] = {0.0};
    int64_t i = 0;
    if (count >= LANES) {
        for (; i + LANES <= count; i += LANES)
            for (int k = 0; k < LANES; k++) lane[k] += values[i + k];
        total = ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
    }
    for (; i < count; i++) total += values[i];
    return total;
}

/* As `rint` of what is below 2^51, and without a call. */
static inline double whole(double value) { return value + 6755399441055744.0 - 6755399441055744.0; }

/* Positions over their rms distance from the middle and weighted normals, rounded: (N, DIMENSIONS), N = count. */
static void features_of(int64_t count, const double *position, const double *direction, double *feature) {
    double middle[3] = {0.0, 0.0, 0.0};
    for (int64_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) middle[axis] += position[3 * i + axis];
    for (int axis = 0; axis < 3; axis++) middle[axis] /= (double)count;
    for (int64_t i = 0; i < count; i++) {
        double offset[3];
        subtract(position + 3 * i, middle, offset);
        feature[i] = dot(offset, offset);
    }
    double size = larger(sqrt(sum_of(count, feature) / (double)count), 1e-9);
    for (int64_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) {
            double offset = position[3 * i + axis] - middle[axis];
            feature[DIMENSIONS * i + axis] = whole(offset / size * FEATURE_STEPS) / FEATURE_STEPS;
            feature[DIMENSIONS * i + 3 + axis] = whole(NORMAL_WEIGHT * direction[3 * i + axis] * FEATURE_STEPS) / FEATURE_STEPS;
        }
}

/* The dimension in which a group of points (M), M = count, varies most, the first one of equal ones. */
static int longest_dimension(int64_t count, const int64_t *group, const double *feature) {
    double middle[DIMENSIONS] = {0.0}, square[DIMENSIONS] = {0.0};
    int longest = 0;
    for (int64_t i = 0; i < count; i++)
        for (int d = 0; d < DIMENSIONS; d++) middle[d] += feature[DIMENSIONS * group[i] + d];
    for (int d = 0; d < DIMENSIONS; d++) middle[d] /= (double)count;
    for (int64_t i = 0; i < count; i++)
        for (int d = 0; d < DIMENSIONS; d++) {
            double offset = feature[DIMENSIONS * group[i] + d] - middle[d];
            square[d] += offset * offset;
        }
    for (int d = 1; d < DIMENSIONS; d++)
        if (square[d] / (double)count > square[longest] / (double)count) longest = d;
    return longest;
}

/* Points and the keys by which they are sorted. */
typedef struct {
    int64_t *point;
    uint32_t *key;
} Keyed;

/* Sorts a group of points (M), M = count, by a dimension of their features; equal ones keep their order. */
static void sort_group(int64_t count, int64_t *group, const double *feature, int dimension, Keyed from, Keyed to) {
    uint32_t begin[DIGITS][DIGIT] = {{0}};
    for (int64_t i = 0; i < count; i++) {
        double value = whole(feature[DIMENSIONS * group[i] + dimension] * FEATURE_STEPS);
        from.point[i] = group[i];
        from.key[i] = (uint32_t)((int64_t)smaller(larger(value, -LIMIT), LIMIT) + (int64_t)LIMIT);
        for (int digit = 0; digit < DIGITS; digit++) begin[digit][from.key[i] >> (8 * digit) & 255]++;
    }
    for (int digit = 0; digit < DIGITS; digit++) {
        if (begin[digit][from.key[0] >> (8 * digit) & 255] == (uint32_t)count) continue; /* all have the same */
        uint32_t total = 0;
        for (int value = 0; value < DIGIT; value++) {
            uint32_t own = begin[digit][value];
            begin[digit][value] = total;
            total += own;
        }
        for (int64_t i = 0; i < count; i++) {
            uint32_t at = begin[digit][from.key[i] >> (8 * digit) & 255]++;
            to.point[at] = from.point[i];
            to.key[at] = from.key[i];
        }
        Keyed other = from;
        from = to;
        to = other;
    }
    memcpy(group, from.point, (size_t)count * sizeof *group);
}

/* Mean height and vertical extent of what a stratum of points (M), M = count, stands for about one of them; scratch: (2 M). */
static void patch_heights(int64_t count, const int64_t *group, int64_t one, const double *position, const double *direction,
                          const double *area, double sea, double *scratch, double *middle, double *span) {
    double *share = scratch, *value = scratch + count, total;
    int afloat = 0;
    for (int64_t i = 0; i < count; i++) {
        int alike = dot(direction + 3 * group[i], direction + 3 * one) > ALIKE;
        share[i] = alike ? area[group[i]] : 0.0;
        afloat |= alike && position[3 * group[i] + 2] > sea;
    }
    for (int64_t i = 0; i < count && afloat; i++) share[i] = position[3 * group[i] + 2] > sea ? share[i] : 0.0;
    total = sum_of(count, share);
    for (int64_t i = 0; i < count; i++) {
        share[i] /= total;
        value[i] = share[i] * position[3 * group[i] + 2];
    }
    *middle = sum_of(count, value);
    for (int64_t i = 0; i < count; i++) {
        double off = position[3 * group[i] + 2] - *middle;
        value[i] = share[i] * (off * off);
    }
    *span = sqrt(12.0 * sum_of(count, value));
}

/* Groups points (N), N = count, into parts 2^halvings strata of equal size, cut where each group is longest, and draws point `pick`
 * (S) of each. position, direction (N, 3): of points and of normals; area (N). Results (S): the points chosen, the area that each
 * stands for, middle height over `sea` and vertical extent. */
/* Arrays: groups from 1; halvings < 40; position, direction (count, 3); area (count); pick (groups) < count // groups;
 * chosen, carried, middle, span (groups) */
KERNEL int64_t strata(int64_t count, int64_t parts, int64_t halvings, int64_t groups, const double *position, const double *direction,
                      const double *area, double sea, const int64_t *pick, int64_t *chosen, double *carried, double *middle,
                      double *span) {
    if (parts < 1 || parts > groups || parts << halvings != groups || count < groups) return REFUSED;
    int64_t *group = calloc((size_t)count + 1, 3 * sizeof(int64_t) + 2 * sizeof(uint32_t) + DIMENSIONS * sizeof(double));
    if (!group) return NO_MEMORY;
    double *feature = (double *)(group + 3 * count);
    uint32_t *keys = (uint32_t *)(feature + DIMENSIONS * count);
    Keyed from = {group + count, keys}, to = {group + 2 * count, keys + count};
    features_of(count, position, direction, feature);
    for (int64_t i = 0; i < count; i++) group[i] = i;
    for (int64_t level = 0, made = 1; level <= halvings; made *= level++ ? 2 : parts) {
        int64_t size = count / made;
        for (int64_t g = 0; g < made; g++) {
            int64_t *own = group + g * size;
            sort_group(size, own, feature, longest_dimension(size, own, feature), from, to);
        }
    }
    int64_t size = count / groups;
    for (int64_t g = 0; g < groups; g++) {
        const int64_t *own = group + g * size;
        chosen[g] = own[pick[g]];
        for (int64_t i = 0; i < size; i++) feature[i] = area[own[i]];
        carried[g] = sum_of(size, feature);
        patch_heights(size, own, chosen[g], position, direction, area, sea, feature, middle + g, span + g);
    }
    free(group);
    return groups;
}
