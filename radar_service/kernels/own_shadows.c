/* Shadows that a body casts on itself: all but the rays, for scattering/physical_optics/own_shadows.py. Lengths are in metres, vectors are rows; `lean` (3, 3) turns vectors of the upright body into its own frame. */

#include "geometry.h"

static const double MARGIN = 1.0, TOLERANCE = 2e-3, RELATIVE_TOLERANCE = 2e-6, OUTSIDE = 2.1;
static const int64_t NO_TRIANGLE = -1;

/* The rays that tell whether points (M, 3) of the upright body are visible, M = count.
 *
 * at_x, at_y, height: the antenna in the upright body's frame, and above the sea; water: height of the sea in that frame;
 * centre (3), radius: the sphere about the curved body. Results:
 * end, line (M, 3): the points in the body's own curved frame, and the way to each from where its line of sight begins.
 * origin (M, 3): where the rays seem to come from.
 * begin, direction (M, 3): of the rays, about the sphere's centre.
 * reflection (M, 3), beyond (M): where the sea reflects them, and how far before the points in plan; written by sea alone. */
/* Arrays: points, end, line, origin, begin, direction, reflection (count, 3); centre (3); lean (3, 3); beyond (count) */
KERNEL int64_t own_shadow_rays(int64_t count, int64_t by_sea, const double *points, double at_x, double at_y, double height,
                        double water, double earth_radius, const double *centre, double radius, const double *lean, double *end,
                        double *line, double *origin, float *begin, float *direction, double *reflection, double *beyond) {
    for (int64_t i = 0; i < count; i++) {
        const double *point = points + 3 * i;
        double from[3] = {at_x, at_y, height + water - drop(at_x, at_y, earth_radius)}, share = 0.0;
        if (by_sea) {
            double x = point[0] - at_x, y = point[1] - at_y, distance = sqrt(x * x + y * y);
            share = reflection_distance(distance, point[2] - water, height, earth_radius) / larger(distance, MARGIN);
            double *sea = reflection + 3 * i;
            from[0] = sea[0] = at_x + share * x;
            from[1] = sea[1] = at_y + share * y;
            sea[2] = water;
            from[2] = water - drop(from[0], from[1], earth_radius);
            beyond[i] = distance * (1.0 - share);
        }
        double curved[3] = {point[0], point[1], point[2] - drop(point[0], point[1], earth_radius)}, way[3];
        double *to = end + 3 * i, *along = line + 3 * i;
        subtract(curved, from, way);
        row_times(curved, lean, to);
        row_times(way, lean, along);
        double length = larger(sqrt(dot(along, along)), TOLERANCE), rest = larger(1.0 - share, 1e-6);
        double part = smaller((OUTSIDE * radius + TOLERANCE) / length, 1.0);
        for (int axis = 0; axis < 3; axis++) {
            begin[3 * i + axis] = (float)(to[axis] - along[axis] * part - centre[axis]);
            direction[3 * i + axis] = (float)along[axis];
            origin[3 * i + axis] = to[axis] - along[axis] / rest;
        }
    }
    return count;
}

/* The triangle that occludes each point (M), NO_TRIANGLE where none does.
 *
 * hit, triangle (M): what the rays meet, and what the points lie on; end, line (M, 3): as above; normal (F, 3), offset (F): of the
 * triangles' planes. */
/* Arrays: hit (count) from -1 < F; triangle, occluding (count); end, line (count, 3); normal (F, 3); offset (F) */
KERNEL int64_t own_shadow_hits(int64_t count, const int64_t *hit, const int64_t *triangle, const double *end, const double *line,
                        const double *normal, const double *offset, int64_t *occluding) {
    for (int64_t i = 0; i < count; i++) {
        occluding[i] = NO_TRIANGLE;
        if (hit[i] < 0 || hit[i] == triangle[i]) continue;
        const double *plane = normal + 3 * hit[i], *way = line + 3 * i;
        double along = dot(plane, way), length = larger(sqrt(dot(way, way)), TOLERANCE);
        double before = along != 0.0 ? -(offset[hit[i]] - dot(plane, end + 3 * i)) / along : -INFINITY;
        if (before > TOLERANCE / length + RELATIVE_TOLERANCE) occluding[i] = hit[i];
    }
    return count;
}

/* Where a way from a point in the shadow of a triangle leaves it, a share of the way, inf where it never does: `_way_out`. */
static double way_out(const double *corners[3], const double *begin, const double *origin, const double *way) {
    double from[3][3], offset[3], result = INFINITY;
    for (int corner = 0; corner < 3; corner++) subtract(corners[corner], origin, from[corner]);
    subtract(begin, origin, offset);
    for (int corner = 0; corner < 3; corner++) {
        double plane[3];
        cross(from[corner], from[(corner + 1) % 3], plane);
        double change = dot(plane, way);
        if (change * dot(plane, from[(corner + 2) % 3]) < 0.0)
            result = smaller(result, larger(-dot(plane, offset) / change, 0.0));
    }
    return result;
}

/* One step from triangle to triangle toward the edges of shadows, along ways (M): returns how many of the `count` ways are not
 * done yet.
 *
 * left (count): which ways these are, the first ones changed to those that go on. occluding (count), end, origin (count, 3): of
 * the points where they are. way, curved_way, hidden (M, 3): of the upright body, curved and in the body's own frame, and where
 * they begin; triangle (M): on which. onward (M): how far beyond an edge the next ray ends, a share. vertices (V, 3), faces (F, 3).
 * share, edge, result (M): where each way is, the last edge, and where it ends; changed. points (count, 3), on (count): of the
 * ways that go on, the next points and the triangles they lie on. */
/* Arrays: count < M + 1; left (M) < M; occluding (count) from -2 < F; end, origin, points (count, 3); on (count);
 * way, curved_way, hidden (M, 3); triangle, onward, share, edge, result (M); vertices (vertex_count, 3); faces (F, 3) */
KERNEL int64_t shadow_edge_step(int64_t count, int64_t vertex_count, double growth, int64_t *left, const int64_t *occluding, const double *end,
                         const double *origin, const double *way, const double *curved_way, const double *hidden,
                         const int64_t *triangle, const double *onward, const double *vertices, const int64_t *faces,
                         double *share, double *edge, double *result, double *points, int64_t *on) {
    int64_t going = 0;
    for (int64_t i = 0; i < count; i++) {
        int64_t which = left[i];
        if (occluding[i] == NO_TRIANGLE) result[which] = edge[which];
        if (occluding[i] < 0) continue;
        const double *corners[3];
        for (int corner = 0; corner < 3; corner++) {
            int64_t vertex = faces[3 * occluding[i] + corner];
            if (vertex < 0 || vertex >= vertex_count) return REFUSED;
            corners[corner] = vertices + 3 * vertex;
        }
        double further = way_out(corners, end + 3 * i, origin + 3 * i, curved_way + 3 * which);
        edge[which] = smaller(share[which] + further, 1.0);
        share[which] = smaller(edge[which] + growth * onward[which], 1.0);
        for (int axis = 0; axis < 3; axis++)
            points[3 * going + axis] = hidden[3 * which + axis] + share[which] * way[3 * which + axis];
        on[going] = triangle[which];
        left[going++] = which;
    }
    return going;
}
