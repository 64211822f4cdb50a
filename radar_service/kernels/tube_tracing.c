/* Where ray tubes hit a body after reflection: `_reflected` of scattering/physical_optics/tube_tracing.py as a whole, with its
 * halvings and cuts. Rays are traced by a function of Python's. Vectors of arrays stand by axis, (3, M); those of triangles are rows. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"

/* Of the same names in Python. */
static const double OFFSET = 1e-3, OFFSET_RELATIVE = 1e-6, STEEP = 0.1, INSET = 0.02, ASIDE = 0.05, GRAZING = 0.01;
static const double TINY_AREA = 1e-30, ALIKE = 1e-6;
enum { CARRIED_HALVINGS = 1, SECTIONS = 4, SAMPLED = 4 };
enum { NO_MEMORY = -1, NO_RAYS = -2 };

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

/* A tube that a straight line may divide, for `cut_at_edges`. */
typedef struct {
    int64_t which, tip, beyond;
    int turn[3];
    double first, second;
} Cut;

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
    return trace->rays(trace->ray_count, trace->begin, trace->direction, trace->hit) ? NO_RAYS : 0;
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
    return trace->last ? counts(trace, tube, hit) : hit >= 0;
}

/* The plane that a ray of a tube hits, -1 where it does not land. */
static int64_t plane_of(const Trace *trace, const Tube *tube, int64_t hit) {
    return hit >= 0 && lands(trace, tube, hit) ? trace->plane[hit] : -1;
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
            ranked[number].rank = rint(log(larger(area(&list->tubes[i]), TINY_AREA)) / ALIKE);
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

/* ---- steps ---- */

/* What rays from the centres hit, and of the largest tubes those from near the corners: `_hits_of_samples`. */
static int sample(Trace *trace, Tubes *list, int64_t most) {
    unsigned char *large = malloc((size_t)list->count + 1);
    if (!large) return NO_MEMORY;
    memset(large, 1, (size_t)list->count);
    int failed = keep_largest(list, large, most);
    if (!failed) failed = clear_rays(trace, 4 * list->count);
    for (int64_t i = 0; !failed && i < list->count; i++) {
        const Tube *tube = &list->tubes[i];
        double off[3], from[3];
        lift(trace, tube, off);
        add_ray(trace, tube->centre, off, tube->direction);
        for (int corner = 0; large[i] && corner < 3; corner++) {
            between(tube->corners[corner], tube->centre, INSET, from);
            add_ray(trace, from, off, tube->direction);
        }
    }
    if (!failed) failed = trace_rays(trace);
    const int64_t *hit = trace->hit;
    for (int64_t i = 0; !failed && i < list->count; i++) {
        for (int sample = 0; sample < 4; sample++) list->tubes[i].hit[sample] = hit[large[i] ? sample : 0];
        hit += large[i] ? 4 : 1;
    }
    free(large);
    return failed;
}

/* Both halves of the tubes flagged, and what their rays hit: `_divided`. */
static int divide(Trace *trace, const Tubes *list, const unsigned char *flags, Tubes *halves) {
    halves->count = 0;
    int failed = clear_rays(trace, 3 * list->count);
    for (int half = 0; half < 2; half++)
        for (int64_t i = 0; !failed && i < list->count; i++) {
            if (!flags[i]) continue;
            const Tube *tube = &list->tubes[i];
            double edges[3], middle[3], aside[3], off[3];
            squared_edges(tube, edges);
            double limit = (1.0 - ALIKE) * larger(larger(edges[0], edges[1]), larger(edges[2], 0.0));
            int edge = edges[0] >= limit ? 0 : edges[1] >= limit ? 1 : 2;
            int first = edge, second = (edge + 1) % 3, third = (edge + 2) % 3;
            const double *a = tube->corners[first], *b = tube->corners[second], *c = tube->corners[third];
            for (int axis = 0; axis < 3; axis++) middle[axis] = (a[axis] + b[axis]) / 2.0;
            Tube *part = added(halves);
            if (!part) return NO_MEMORY;
            move(trace, tube, half ? middle : a, half ? b : middle, c, part);
            lift(trace, tube, off);
            between(middle, tube->centre, INSET, aside);
            if (!half) add_ray(trace, aside, off, tube->direction);
            add_ray(trace, part->centre, off, part->direction);
            int64_t at[4] = {0, tube->hit[1 + first], tube->hit[1 + second], tube->hit[1 + third]};
            part->hit[1] = half ? -1 : at[1];
            part->hit[2] = half ? at[2] : -1;
            part->hit[3] = at[3];
        }
    if (!failed) failed = trace_rays(trace);
    int64_t whole = halves->count / 2; /* rays: at the middle and at the first half's centre, by turns, then at the second's */
    for (int64_t i = 0; !failed && i < whole; i++) {
        Tube *first = &halves->tubes[i], *second = &halves->tubes[whole + i];
        first->hit[2] = second->hit[1] = trace->hit[2 * i];
        first->hit[0] = trace->hit[2 * i + 1];
        second->hit[0] = trace->hit[2 * whole + i];
    }
    return failed;
}

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

/* `line_through` of facets.py: shares of two edges of the whole triangle, from those of the smaller one. */
static void line_through(double *first, double *second) {
    double third = INSET / 3.0, x = third + (1.0 - INSET) * *first, y = third + (1.0 - INSET) * *second;
    double along = x * y - third * third;
    *first = smaller(larger(along / larger(y - third, 1e-9), 1e-9), 1.0);
    *second = smaller(larger(along / larger(x - third, 1e-9), 1e-9), 1.0);
}

/* Whether one corner of a tube differs, so that a line may divide it: of `_cut_at_edges`. */
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
 * `_cut_at_edges`; final: whether a tube that is not cut now is not divided either. */
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

/* Which tubes are mixed, so that they are cut or divided, and which land. */
static void compare(const Trace *trace, const Tubes *list, int64_t level, const double *smallest, unsigned char *mixed,
                    unsigned char *kept) {
    int carried = trace->last || level < CARRIED_HALVINGS;
    for (int64_t i = 0; i < list->count; i++) {
        const Tube *tube = &list->tubes[i];
        int64_t compared[4];
        double edges[3];
        for (int sample = 0; sample < 4; sample++) {
            int counted = carried || counts(trace, tube, tube->hit[sample]);
            compared[sample] = counted ? plane_of(trace, tube, tube->hit[sample]) : -1;
        }
        squared_edges(tube, edges);
        double longest = larger(larger(edges[0], edges[1]), edges[2]);
        double least = smallest[tube->triangle], most = trace->longest[trace->launched[tube->parent]];
        int differs = compared[1] != compared[0] || compared[2] != compared[0] || compared[3] != compared[0];
        mixed[i] = (differs && longest > least * least) || (counts(trace, tube, tube->hit[0]) && longest > most * most);
        kept[i] = (unsigned char)lands(trace, tube, tube->hit[0]);
    }
}

/* One round over the tubes that are left: parts that are done go to `done`, halves of the others to `halves`. */
static int one_level(Trace *trace, const Tubes *list, int64_t level, const double *smallest, int64_t *left, Tubes *done,
                     Tubes *halves) {
    unsigned char *mixed = malloc(2 * (size_t)list->count + 2), *kept = mixed ? mixed + list->count + 1 : NULL;
    if (!mixed) return NO_MEMORY;
    compare(trace, list, level, smallest, mixed, kept);
    int64_t count = 0;
    for (int64_t i = 0; i < list->count; i++) count += mixed[i];
    if (level == trace->halvings) *left = 0;
    int failed = level >= trace->cut_level ? cut_at_edges(trace, list, mixed, kept, *left < count, done) : 0;
    if (!failed) failed = keep_largest(list, mixed, *left);
    for (int64_t i = 0; !failed && i < list->count; i++) {
        *left -= mixed[i];
        if (mixed[i] || !kept[i]) continue;
        Tube *result = added(done);
        if (!result)
            failed = NO_MEMORY;
        else {
            *result = list->tubes[i];
            result->triangle = result->hit[0];
        }
    }
    if (!failed) failed = divide(trace, list, mixed, halves);
    free(mixed);
    return failed;
}

/* Projects a tube onto the plane where it lands; returns whether it lies before it and does not graze it: `_projected`. */
static int project(Tube *tube, const double *point, const double *normal) {
    double facing = dot(normal, tube->direction), sign = facing > 0.0 ? -1.0 : 1.0, travel[3];
    facing = fabs(facing);
    for (int corner = 0; corner < 3; corner++) {
        double height = sign * dot(tube->corners[corner], normal) - sign * dot(point, normal);
        travel[corner] = height / larger(facing, GRAZING);
        for (int axis = 0; axis < 3; axis++) tube->corners[corner][axis] += travel[corner] * tube->direction[axis];
    }
    double middle = (travel[0] + travel[1] + travel[2]) / 3.0;
    for (int axis = 0; axis < 3; axis++) {
        tube->centre[axis] += middle * tube->direction[axis];
        tube->normal[axis] = sign * normal[axis];
    }
    tube->length += middle;
    return middle > 0.0 && facing > GRAZING;
}

static int all_levels(Trace *trace, Tubes *list, const double *smallest, int64_t most, Tubes *done) {
    Tubes halves = {NULL, 0, 0};
    int64_t left = most;
    int failed = sample(trace, list, SAMPLED * most);
    for (int64_t level = 0; !failed && level <= trace->halvings && list->count; level++) {
        failed = one_level(trace, list, level, smallest, &left, done, &halves);
        Tubes other = *list;
        *list = halves;
        halves = other;
    }
    free(halves.tubes);
    return failed;
}

/* Tubes (M), M = count, after reflection, where they hit the body next; those that land nowhere are left out.
 *
 * triangles: F; starts: S; last: whether this is the last surface; most: how many are divided; halvings, cut_level:
 * MAX_HALVINGS and CUT_LEVEL. corners (3, 3, M), centre, normal,
 * direction, field, begin (3, M), length (M), launched, triangle, bounces (M): as of `RayTubes`, direction and field reflected.
 * out, out_field (3, S), least, longest (S): as of `Launch`. vertices (V, 3), faces (F, 3), rank (F + 1), the last one of nothing,
 * smallest (F): as of `Ends`; plane (F), point, plane_normal (F, 3): as of `Planes`. centre_of_body (3), radius, rotation (3, 3):
 * of the scene of rays. Returns how many tubes there are, or what failed; `result` holds their address for `take_tubes`. */
KERNEL int64_t reflect_tubes(int64_t count, int64_t triangles, int64_t starts, int64_t last, int64_t most, int64_t halvings,
                             int64_t cut_level, const double *corners, const double *centre, const double *normal, const double *direction, const double *field,
                             const double *begin, const double *length, const int64_t *launched, const int64_t *triangle,
                             const int64_t *bounces, const double *out, const double *out_field, const int64_t *least,
                             const double *longest, const double *vertices, const int64_t *faces, const int64_t *rank,
                             const double *smallest, const int64_t *plane, const double *point, const double *plane_normal,
                             const double *centre_of_body, double radius, const double *rotation, RayCall rays, int64_t *result) {
    Trace trace = {count, triangles, starts, last, halvings, cut_level, normal, field, out, out_field, longest, launched, bounces, least, plane, rank,
                   faces, vertices, centre_of_body, rotation, radius, rays, NULL, NULL, NULL, 0, 0};
    Tubes list = {NULL, 0, 0}, done = {NULL, 0, 0};
    int failed = reserve(&list, count) || reserve(&done, 2 * count) ? NO_MEMORY : 0;
    for (int64_t i = 0; !failed && i < count; i++) {
        Tube *tube = &list.tubes[list.count++];
        memset(tube, 0, sizeof *tube);
        tube->parent = i;
        tube->triangle = triangle[i];
        tube->length = length[i];
        for (int corner = 0; corner < 3; corner++) column(corners + 3 * corner * count, count, i, tube->corners[corner]);
        column(centre, count, i, tube->centre);
        column(direction, count, i, tube->direction);
        column(begin, count, i, tube->begin);
    }
    if (!failed) failed = all_levels(&trace, &list, smallest, most, &done);
    int64_t landed = 0;
    for (int64_t i = 0; !failed && i < done.count; i++) {
        int64_t at = done.tubes[i].triangle;
        if (project(&done.tubes[i], point + 3 * at, plane_normal + 3 * at)) done.tubes[landed++] = done.tubes[i];
    }
    free(list.tubes);
    free(trace.begin);
    free(trace.direction);
    free(trace.hit);
    if (failed) free(done.tubes);
    *result = failed ? 0 : (int64_t)(intptr_t)done.tubes;
    return failed ? failed : landed;
}

/* Copies the tubes (N), N = count, at an address and frees it. parent (N): of the tubes that were reflected; triangle (N), corners
 * (3, 3, N), centre, normal, direction, begin (3, N), length (N): as of `RayTubes`. */
KERNEL int64_t take_tubes(int64_t count, int64_t address, int64_t *parent, int64_t *triangle, double *corners, double *centre,
                          double *normal, double *direction, double *begin, double *length) {
    Tube *tubes = (Tube *)(intptr_t)address;
    for (int64_t i = 0; i < count; i++) {
        parent[i] = tubes[i].parent;
        triangle[i] = tubes[i].triangle;
        length[i] = tubes[i].length;
        for (int axis = 0; axis < 3; axis++) {
            centre[axis * count + i] = tubes[i].centre[axis];
            normal[axis * count + i] = tubes[i].normal[axis];
            direction[axis * count + i] = tubes[i].direction[axis];
            begin[axis * count + i] = tubes[i].begin[axis];
            for (int corner = 0; corner < 3; corner++) corners[(3 * corner + axis) * count + i] = tubes[i].corners[corner][axis];
        }
    }
    free(tubes);
    return count;
}
