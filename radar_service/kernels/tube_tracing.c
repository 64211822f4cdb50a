/* Where ray tubes hit a body after reflection: what tests/reference/tube_witness.py does in numpy, with its
 * halvings and cuts. Rays are traced by a function of Python's. Vectors of arrays stand by axis, (3, M); those of triangles are rows. */

#include "tube_cuts.h"
#include "tubes.h"

/* What rays from the centres hit, and of the largest tubes those from near the corners: `samples` of tests/reference/tube_witness.py. */
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
/* Arrays: halvings < 31; corners (3, 3, count); centre, normal, direction, field, begin (3, count); length, bounces (count);
 * launched (count) < starts; triangle (count) < triangles; out, out_field (3, starts); least, longest (starts); vertices (V, 3);
 * faces (triangles, 3) < V; rank (triangles + 1); smallest, plane (triangles); point, plane_normal (triangles, 3);
 * centre_of_body (3); rotation (3, 3); result (1) */
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
    done.count = landed;
    Tubes *kept = failed ? NULL : malloc(sizeof *kept);
    if (kept)
        *kept = done;
    else
        free(done.tubes);
    *result = (int64_t)(intptr_t)kept;
    return failed ? failed : kept ? landed : NO_MEMORY;
}

/* Copies the tubes (N), N = count, at an address and frees it. parent (N): of the tubes that were reflected; triangle (N), corners
 * (3, 3, N), centre, normal, direction, begin (3, N), length (N): as of `RayTubes`. */
/* Arrays: parent, triangle, length (count); corners (3, 3, count); centre, normal, direction, begin (3, count) */
KERNEL int64_t take_tubes(int64_t count, int64_t address, int64_t *parent, int64_t *triangle, double *corners, double *centre,
                          double *normal, double *direction, double *begin, double *length) {
    Tubes *list = (Tubes *)(intptr_t)address;
    if (!list || list->count != count) return REFUSED;
    Tube *tubes = list->tubes;
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
    free(list);
    return count;
}
