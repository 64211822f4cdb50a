/* Ray tubes cut where they hit different planes: `cut_at_edges` and `crossings` of tests/reference/tube_witness.py. */

#ifndef TUBE_CUTS_H
#define TUBE_CUTS_H

#include "tubes.h"

/* A tube that a straight line may divide, for `cut_at_edges`. */
typedef struct {
    int64_t which, tip, beyond;
    int turn[3];
    double first, second;
} Cut;

/* Where the edge between planes crosses an edge of a tube, a share of it, as rays `struck` bracket it: of `_crossings`. */
static double crossing(const Trace *trace, const Tube *tube, const Cut *cut, int end, const double *begin, const double *way,
                       const int64_t struck[SECTIONS - 1]) {
    int64_t every[SECTIONS + 1];
    every[0] = tube->hit[1 + cut->turn[0]];
    every[SECTIONS] = tube->hit[1 + cut->turn[1 + end]];
    int passed = 0;
    for (int section = 0; section < SECTIONS - 1; section++) every[1 + section] = struck[section];
    while (passed < SECTIONS - 1 && plane_of(trace, tube, struck[passed]) == cut->tip) passed++;
    double middle = (passed + 0.5) / SECTIONS, best = INFINITY, nearest = INFINITY;
    for (int side = 0; side < 2; side++) {
        int64_t triangle = every[passed + side];
        if (triangle < 0) continue;
        for (int i = 0; i < 3; i++) {
            const double *vertex = trace->vertices + 3 * trace->faces[3 * triangle + i];
            const double *next = trace->vertices + 3 * trace->faces[3 * triangle + (i + 1) % 3];
            double edge[3], across[3], offset[3];
            subtract(next, vertex, edge);
            cross(edge, tube->direction, across);
            subtract(vertex, begin, offset);
            double slope = dot(way, across);
            if (!(fabs(slope) > 1e-12)) continue;
            double place = dot(offset, across) / slope;
            if (fabs(place - middle) < nearest) {
                nearest = fabs(place - middle);
                best = place;
            }
        }
    }
    return nearest < 0.6 / SECTIONS ? best : middle;
}

/* `line_through` of tests/reference/tube_witness.py: shares of two edges of the whole triangle, from those of the smaller one. */
static void line_through(double *first, double *second) {
    double third = INSET / 3.0, x = third + (1.0 - INSET) * *first, y = third + (1.0 - INSET) * *second;
    double along = x * y - third * third;
    *first = smaller(larger(along / larger(y - third, 1e-9), 1e-9), 1.0);
    *second = smaller(larger(along / larger(x - third, 1e-9), 1e-9), 1.0);
}

/* Whether one corner of a tube differs, so that a line may divide it: of `cut_at_edges`. */
static int is_odd(const Trace *trace, const Tube *tube, Cut *cut) {
    int64_t at[3], centre = plane_of(trace, tube, tube->hit[0]);
    for (int corner = 0; corner < 3; corner++) at[corner] = plane_of(trace, tube, tube->hit[1 + corner]);
    int alone = at[1] == at[2] ? 0 : at[0] == at[2] ? 1 : 2;
    for (int corner = 0; corner < 3; corner++) cut->turn[corner] = (alone + corner) % 3;
    cut->tip = at[alone];
    cut->beyond = at[cut->turn[1]];
    return cut->beyond == at[cut->turn[2]] && cut->tip != cut->beyond && (centre == cut->tip || centre == cut->beyond);
}

/* Finds the lines of all cuts: rays along two edges of each tube, SECTIONS - 1 on each. */
static int find_lines(Trace *trace, const Tubes *list, Cut *cuts, int64_t count) {
    double begin[3], end[3], way[3], from[3], off[3];
    int failed = clear_rays(trace, 2 * (SECTIONS - 1) * count);
    for (int pass = 0; pass < 2; pass++) {
        for (int64_t i = 0; !failed && i < count; i++) {
            const Tube *tube = &list->tubes[cuts[i].which];
            double share[2];
            lift(trace, tube, off);
            between(tube->corners[cuts[i].turn[0]], tube->centre, INSET, begin);
            for (int edge = 0; edge < 2; edge++) {
                between(tube->corners[cuts[i].turn[1 + edge]], tube->centre, INSET, end);
                subtract(end, begin, way);
                for (int section = 1; !pass && section < SECTIONS; section++) {
                    for (int axis = 0; axis < 3; axis++) from[axis] = begin[axis] + (double)section / SECTIONS * way[axis];
                    add_ray(trace, from, off, tube->direction);
                }
                const int64_t *struck = trace->hit + (2 * i + edge) * (SECTIONS - 1);
                if (pass) share[edge] = crossing(trace, tube, &cuts[i], edge, begin, way, struck);
            }
            if (!pass) continue;
            line_through(&share[0], &share[1]);
            cuts[i].first = share[0];
            cuts[i].second = share[1];
        }
        if (!failed && !pass) failed = trace_rays(trace);
    }
    return failed;
}

/* The corners of a cut tube by its turn, and where the line meets the edges from the first one. */
static void ends_of(const Tube *tube, const Cut *cut, const double *corners[3], double *ab, double *ac) {
    for (int corner = 0; corner < 3; corner++) corners[corner] = tube->corners[cut->turn[corner]];
    between(corners[0], corners[1], cut->first, ab);
    between(corners[0], corners[2], cut->second, ac);
}

/* Keeps the cuts whose lines rays on both sides of them agree with; returns how many, or what failed. */
static int64_t explained(Trace *trace, const Tubes *list, Cut *cuts, int64_t count) {
    static const double PLACES[2] = {0.25, 0.75};
    double ab[3], ac[3], line[3], middle[3], from[3], off[3];
    const double *corners[3];
    int failed = clear_rays(trace, 4 * count);
    for (int64_t i = 0; !failed && i < count; i++) {
        const Tube *tube = &list->tubes[cuts[i].which];
        ends_of(tube, &cuts[i], corners, ab, ac);
        lift(trace, tube, off);
        for (int axis = 0; axis < 3; axis++) middle[axis] = (corners[1][axis] + corners[2][axis]) / 2.0;
        for (int side = 0; side < 2; side++)
            for (int place = 0; place < 2; place++) {
                between(ab, ac, PLACES[place], line);
                between(line, side ? middle : corners[0], ASIDE, from);
                add_ray(trace, from, off, tube->direction);
            }
    }
    if (!failed) failed = trace_rays(trace);
    if (failed) return failed;
    int64_t kept = 0;
    for (int64_t i = 0; i < count; i++) {
        int agrees = 1;
        for (int ray = 0; ray < 4; ray++)
            agrees &= plane_of(trace, &list->tubes[cuts[i].which], trace->hit[4 * i + ray]) == (ray < 2 ? cuts[i].tip : cuts[i].beyond);
        if (agrees) cuts[kept++] = cuts[i];
    }
    return kept;
}

/* Adds to `done` the parts that land of the flagged tubes that a line divides, and clears these tubes' flags in `mixed` and `kept`:
 * `cut_at_edges`; final: whether a tube that is not cut now is not divided either. */
static int cut_at_edges(Trace *trace, const Tubes *list, unsigned char *mixed, unsigned char *kept, int final, Tubes *done) {
    Cut *cuts = malloc(((size_t)list->count + 1) * sizeof *cuts);
    if (!cuts) return NO_MEMORY;
    int64_t count = 0;
    for (int64_t i = 0; i < list->count; i++) {
        cuts[count].which = i;
        if (mixed[i] && is_odd(trace, &list->tubes[i], &cuts[count])) count++;
    }
    int failed = find_lines(trace, list, cuts, count);
    if (!failed && !final) count = explained(trace, list, cuts, count);
    if (!failed && count < 0) failed = (int)count;
    for (int part = 0; !failed && part < 3; part++)
        for (int64_t i = 0; !failed && i < count; i++) {
            const Tube *tube = &list->tubes[cuts[i].which];
            const double *corners[3];
            double ab[3], ac[3];
            if ((part ? cuts[i].beyond : cuts[i].tip) < 0) continue;
            ends_of(tube, &cuts[i], corners, ab, ac);
            Tube *result = added(done);
            if (!result)
                failed = NO_MEMORY;
            else {
                move(trace, tube, part ? ab : corners[0], part == 0 ? ab : corners[part], part == 1 ? corners[2] : ac, result);
                result->triangle = tube->hit[1 + cuts[i].turn[part ? 1 : 0]];
            }
        }
    for (int64_t i = 0; !failed && i < count; i++) mixed[cuts[i].which] = kept[cuts[i].which] = 0;
    free(cuts);
    return failed;
}

#endif
