/* Ray tubes while they are divided: their rays, what these hit, their shapes and parts. For tube_tracing.c; as ray_tubes.py and
 * tube_tracing.py of scattering/physical_optics have it. Lengths are in metres. */

#ifndef TUBES_H
#define TUBES_H

#include <stdlib.h>
#include <string.h>

#include "geometry.h"

/* Of the same names in Python. */
static const double OFFSET = 1e-3, OFFSET_RELATIVE = 1e-6, STEEP = 0.1, INSET = 0.02, ASIDE = 0.05, GRAZING = 0.01;
static const double TINY = 1e-30, ALIKE = 1e-6;
enum { CARRIED_HALVINGS = 1, SECTIONS = 4, SAMPLED = 4 };
enum { UNTRACED = -2 };

/* Which triangles (M) rays from (M, 3) in directions (M, 3) hit first, -1 for none; begins are relative to the body's centre.
 * Returns 0, or something else where it failed. */
typedef int64_t (*RayCall)(int64_t count, const float *begin, const float *direction, int64_t *hit);

/* A tube, or a part of one. `parent`: of the tubes (M) given; `hit`: triangles at the centre and near the corners. */
typedef struct {
    int64_t parent, triangle, hit[4];
    double corners[3][3], centre[3], normal[3], direction[3], begin[3], length;
} Tube;

typedef struct {
    Tube *tubes;
    int64_t count, room;
} Tubes;

/* What all steps use; see `reflect_tubes`. */
typedef struct {
    int64_t count, triangles, starts, last, halvings, cut_level;
    const double *normal, *field, *out, *out_field, *longest;
    const int64_t *launched, *bounces, *least, *plane, *rank, *faces;
    const double *vertices, *centre, *rotation;
    double radius;
    RayCall rays;
    float *begin, *direction;
    int64_t *hit, ray_room, ray_count;
} Trace;

/* Makes room for tubes. Returns 0, or NO_MEMORY. */
static int reserve(Tubes *list, int64_t room) {
    list->tubes = malloc(((size_t)room + 1) * sizeof *list->tubes);
    list->room = list->tubes ? room + 1 : 0;
    return list->tubes ? 0 : NO_MEMORY;
}

/* Room for one more tube, or NULL. */
static Tube *added(Tubes *list) {
    if (list->count == list->room) {
        int64_t room = 2 * list->room + 256;
        Tube *tubes = realloc(list->tubes, (size_t)room * sizeof *tubes);
        if (!tubes) return NULL;
        list->tubes = tubes;
        list->room = room;
    }
    return &list->tubes[list->count++];
}

static void column(const double *vectors, int64_t count, int64_t i, double *result) {
    for (int axis = 0; axis < 3; axis++) result[axis] = vectors[axis * count + i];
}

/* a + share (b - a) */
static void between(const double *a, const double *b, double share, double *result) {
    for (int axis = 0; axis < 3; axis++) result[axis] = a[axis] + share * (b[axis] - a[axis]);
}

/* ---- rays ---- */

/* Forgets all rays and makes room for some. */
static int clear_rays(Trace *trace, int64_t room) {
    trace->ray_count = 0;
    if (room <= trace->ray_room) return 0;
    free(trace->begin);
    free(trace->direction);
    free(trace->hit);
    trace->begin = malloc((size_t)room * 3 * sizeof *trace->begin);
    trace->direction = malloc((size_t)room * 3 * sizeof *trace->direction);
    trace->hit = malloc((size_t)room * sizeof *trace->hit);
    trace->ray_room = trace->begin && trace->direction && trace->hit ? room : 0;
    return trace->ray_room ? 0 : NO_MEMORY;
}

static void add_ray(Trace *trace, const double *from, const double *off, const double *along) {
    double begin[3], turned_begin[3], direction[3];
    for (int axis = 0; axis < 3; axis++) begin[axis] = from[axis] + off[axis];
    row_times(begin, trace->rotation, turned_begin);
    row_times(along, trace->rotation, direction);
    for (int axis = 0; axis < 3; axis++) {
        trace->begin[3 * trace->ray_count + axis] = (float)(turned_begin[axis] - trace->centre[axis]);
        trace->direction[3 * trace->ray_count + axis] = (float)direction[axis];
    }
    trace->ray_count++;
}

static int trace_rays(Trace *trace) {
    if (!trace->ray_count) return 0;
    int64_t *end = trace->hit + trace->ray_count - 1;
    *end = UNTRACED; /* Python may be interrupted before its first line: then nothing is written, nor returned */
    int failed = trace->rays(trace->ray_count, trace->begin, trace->direction, trace->hit) != 0;
    if (failed || *end == UNTRACED) return NO_RAYS;
    for (int64_t i = 0; i < trace->ray_count; i++)
        if (trace->hit[i] < -1 || trace->hit[i] >= trace->triangles) return REFUSED;
    return 0;
}

/* How far along the reflected ray it starts, off the surface: `lift`. */
static void lift(const Trace *trace, const Tube *tube, double *off) {
    double normal[3];
    column(trace->normal, trace->count, tube->parent, normal);
    double steep = larger(dot(normal, tube->direction), STEEP);
    for (int axis = 0; axis < 3; axis++)
        off[axis] = (OFFSET + OFFSET_RELATIVE * trace->radius) / steep * tube->direction[axis];
}

/* ---- what hits count ---- */

static int counts(const Trace *trace, const Tube *tube, int64_t hit) {
    return trace->rank[hit < 0 ? trace->triangles : hit] >= trace->least[trace->launched[tube->parent]];
}

static int lands(const Trace *trace, const Tube *tube, int64_t hit) {
    return hit >= 0 && (!trace->last || counts(trace, tube, hit));
}

/* The plane that a ray of a tube hits, -1 where it does not land. */
static int64_t plane_of(const Trace *trace, const Tube *tube, int64_t hit) {
    return lands(trace, tube, hit) ? trace->plane[hit] : -1;
}

/* ---- shapes ---- */

static double area(const Tube *tube) {
    double u[3], v[3], across[3];
    subtract(tube->corners[1], tube->corners[0], u);
    subtract(tube->corners[2], tube->corners[0], v);
    cross(u, v, across);
    return sqrt(dot(across, across)) / 2.0;
}

static void squared_edges(const Tube *tube, double *edges) {
    for (int i = 0; i < 3; i++) {
        double way[3];
        subtract(tube->corners[(i + 1) % 3], tube->corners[i], way);
        edges[i] = dot(way, way);
    }
}

typedef struct {
    double rank;
    int64_t index;
} Ranked;

static int by_rank(const void *one, const void *other) {
    const Ranked *a = one, *b = other;
    if (a->rank != b->rank) return a->rank > b->rank ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Clears the flags of all but the `most` largest of the tubes flagged: `largest`. */
static int keep_largest(const Tubes *list, unsigned char *flags, int64_t most) {
    int64_t flagged = 0, number = 0;
    for (int64_t i = 0; i < list->count; i++) flagged += flags[i];
    if (flagged <= most) return 0;
    Ranked *ranked = malloc((size_t)flagged * sizeof *ranked);
    if (!ranked) return NO_MEMORY;
    for (int64_t i = 0; i < list->count; i++)
        if (flags[i]) {
            ranked[number].rank = rint(log(larger(area(&list->tubes[i]), TINY)) / ALIKE);
            ranked[number++].index = i;
        }
    qsort(ranked, (size_t)flagged, sizeof *ranked, by_rank);
    for (int64_t i = most > 0 ? most : 0; i < flagged; i++) flags[ranked[i].index] = 0;
    free(ranked);
    return 0;
}

/* The same tube with other corners, and the wave at its own centre: `moved` of ray_tubes.py. */
static void move(const Trace *trace, const Tube *tube, const double *a, const double *b, const double *c, Tube *result) {
    double offset[3], across[3], field[3], beside[3], out[3], out_field[3], out_beside[3];
    int64_t parent = tube->parent, start = trace->launched[parent];
    *result = *tube;
    memcpy(result->corners[0], a, sizeof result->corners[0]);
    memcpy(result->corners[1], b, sizeof result->corners[1]);
    memcpy(result->corners[2], c, sizeof result->corners[2]);
    for (int axis = 0; axis < 3; axis++) result->centre[axis] = (a[axis] + b[axis] + c[axis]) / 3.0;
    subtract(result->centre, tube->centre, offset);
    double along = dot(offset, tube->direction);
    for (int axis = 0; axis < 3; axis++) {
        across[axis] = offset[axis] - along * tube->direction[axis];
        result->direction[axis] = tube->direction[axis] + across[axis] / tube->length;
    }
    double length = sqrt(dot(result->direction, result->direction));
    for (int axis = 0; axis < 3; axis++) result->direction[axis] /= length;
    result->length = tube->length + along + dot(across, across) / (2.0 * tube->length);
    column(trace->field, trace->count, parent, field);
    column(trace->out, trace->starts, start, out);
    column(trace->out_field, trace->starts, start, out_field);
    cross(tube->direction, field, beside);
    cross(out, out_field, out_beside);
    double first = dot(across, field) * (trace->bounces[parent] % 2 ? -1.0 : 1.0), second = dot(across, beside);
    for (int axis = 0; axis < 3; axis++)
        result->begin[axis] = tube->begin[axis] + (first * out_field[axis] + second * out_beside[axis]);
}

#endif
