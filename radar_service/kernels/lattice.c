/* Sums on the nodes of a lattice: scattering/physical_optics/scattering_centres.py. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "phasors.h"

static const int64_t FARTHEST = 1 << 30; /* cells from the base */
static const double LARGEST = 1e9;        /* cells: 8 GB */

/* The cell of a coordinate along one axis, and where inside it that lies, 0 to 1. */
static int64_t cell(const double *point, int axis, int from_zero, const double *steps, const double *base, double *inside) {
    double place = (point[axis] - base[axis]) / steps[axis], below = floor(place);
    if (from_zero && axis == 2) below = larger(below, 0.0);
    *inside = place - below;
    return fabs(below) <= (double)FARTHEST ? (int64_t)below : INT64_MAX;
}

/* The nodes of a lattice about points (M, 3), M = count > 0, that a point has a share in, by x, then y, then z: `_lattice`.
 *
 * from_zero: whether no cell is below `base` in height. steps, base (3): sizes of cells and a node [m]. Returns how many there
 * are; the first `room` of them go to nodes (room, 3). corner, share (8, M): as of `Lattice`. */
/* Arrays: points (count, 3); steps, base (3); nodes (room, 3); corner, share (8, count) */
KERNEL int64_t lattice_nodes(int64_t count, int64_t from_zero, int64_t room, const double *points, const double *steps,
                             const double *base, double *nodes, int64_t *corner, double *share) {
    int64_t first[3] = {INT64_MAX, INT64_MAX, INT64_MAX}, last[3] = {INT64_MIN, INT64_MIN, INT64_MIN}, extent[3], total = 0;
    double inside[3], size = 1.0;
    for (int64_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) {
            int64_t at = corner[axis * count + i] = cell(points + 3 * i, axis, from_zero != 0, steps, base, share + axis * count + i);
            if (at < -FARTHEST || at > FARTHEST) return REFUSED;
            if (at < first[axis]) first[axis] = at;
            if (at > last[axis]) last[axis] = at;
        }
    for (int axis = 0; axis < 3 && count; axis++) size *= (double)(extent[axis] = last[axis] - first[axis] + 2);
    if (!count) return 0;
    if (size > LARGEST) return NO_MEMORY;
    int64_t *number = calloc((size_t)size, sizeof *number);
    if (!number) return NO_MEMORY;
    for (int64_t i = 0; i < count; i++) {
        int64_t at = 0;
        for (int axis = 0; axis < 3; axis++) {
            at = at * extent[axis] + corner[axis * count + i] - first[axis];
            inside[axis] = share[axis * count + i];
        }
        double aside[4] = {(1.0 - inside[0]) * (1.0 - inside[1]), (1.0 - inside[0]) * inside[1],
                           inside[0] * (1.0 - inside[1]), inside[0] * inside[1]};
        for (int n = 0; n < 4; n++) {
            int64_t low = at + extent[1] * extent[2] * (n / 2) + extent[2] * (n % 2), place = 2 * n * count + i;
            corner[place] = low;
            corner[place + count] = low + 1;
            number[low] = number[low + 1] = 1;
            share[place + count] = aside[n] * inside[2];
            share[place] = aside[n] - share[place + count];
        }
    }
    for (int64_t at = 0; at < (int64_t)size; at++) {
        if (!number[at]) continue;
        if (total < room) {
            int64_t rest = at, index[3];
            for (int axis = 2; axis >= 0; axis--) {
                index[axis] = rest % extent[axis];
                rest /= extent[axis];
            }
            for (int axis = 0; axis < 3; axis++)
                nodes[3 * total + axis] = (double)(index[axis] + first[axis]) * steps[axis] + base[axis];
        }
        number[at] = total++;
    }
    for (int64_t i = 0; i < 8 * count; i++) corner[i] = number[corner[i]];
    free(number);
    return total;
}

/* Values (M), M = count, at points, of those at the nodes by their shares; corner, share (8, M): as of `Lattice`. */
/* Arrays: corner (8, count) < N; share (8, count); values (N); result (count) */
KERNEL int64_t lattice_between(int64_t count, const int64_t *corner, const double *share, const double *values, double *result) {
    for (int64_t i = 0; i < count; i++) result[i] = 0.0;
    for (int64_t c = 0; c < 8; c++)
        for (int64_t i = 0; i < count; i++) result[i] += share[c * count + i] * values[corner[c * count + i]];
    return count;
}

/* Adds to total (rows, nodes) the shares of amplitudes (M), M = count, each in its row. corner, share (8, M): as of `Lattice`. */
/* Arrays: rows from 1; row (count) < rows; corner (8, count) < nodes; share (8, count);
 * amplitude (count); total (rows, nodes) */
KERNEL int64_t lattice_sums(int64_t count, int64_t rows, const int64_t *row, const int64_t *corner, const double *share,
                            const Complex *amplitude, int64_t nodes, Complex *total) {
    for (int64_t i = 0; i < count; i++) {
        Complex *of_row = total + row[i] * nodes;
        for (int64_t at = i; at < 8 * count; at += count)
            of_row[corner[at]] = plus(of_row[corner[at]], scaled(amplitude[i], share[at]));
    }
    return rows;
}

/* exp(j phase) of phases (M) [rad], M = count. */
/* Arrays: phase, result (count) */
KERNEL int64_t phasors(int64_t count, const double *phase, Complex *result) {
    phasors_of(count, phase, result);
    return count;
}
