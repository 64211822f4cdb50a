/* Lines of sight past many bodies: `PosedOccluders` of trace/posed_occluders.py and `points_behind` of trace/shadow_sectors.py.
 * Lengths are in metres. */

#include "geometry.h"

/* A point of the map in the curved frame of a body. */
static void in_frame(const double *point, const double *position, double cosine, double sine, const double *lean,
                     double earth_radius, double *result) {
    double local[3];
    subtract(point, position, local);
    local[2] -= drop(local[0], local[1], earth_radius);
    if (lean) {
        row_times(local, lean, result);
        return;
    }
    result[0] = cosine * local[0] - sine * local[1];
    result[1] = cosine * local[1] + sine * local[0];
    result[2] = local[2];
}

static inline double share(double part) { return smaller(larger(part, 0.0), 1.0); }

/* Lines of sight to points (P), P = count, in the frames of their bodies (P).
 *
 * origins: P, or 1 for all of them. passing: whether only those are kept that pass within a body's sphere before they end.
 * body (P). origin (origins, 3), point (P, 3): on the map. Of all bodies (B): position (B, 3), cosine and sine (B) of headings,
 * leans (B): the number of a matrix in lean (., 3, 3), map_from_body, -1 for an upright one; centre (B, 3) and radius (B) of
 * spheres, the latter with all tolerance. Of those kept (K), in front: which (K) of the points; first (K, 3): where a line begins;
 * begin (K, 3): where it reaches the sphere; line (K, 3): from first to the point; skipped (K): the share of it left out. */
typedef struct {
    int64_t count, origins, bodies, matrices, passing;
    double earth_radius;
    const int64_t *body;
    const double *origin, *point, *position, *cosine, *sine;
    const int64_t *leans;
    const double *lean, *centre, *radius;
    int64_t *which;
    double *first, *begin, *line, *skipped;
} Lines;

/* Lines of sight from where they come near those bodies. Returns how many there are. */
/* Arrays: body, which, skipped (count); origin (origins, 3); point, first, begin, line (count, 3); position, centre (bodies, 3);
 * cosine, sine, leans, radius (bodies); lean (matrices, 3, 3) */
KERNEL int64_t lines_of_sight(const Lines *lines) {
    if (lines->origins != 1 && lines->origins != lines->count) return REFUSED;
    int64_t kept = 0;
    for (int64_t p = 0; p < lines->count; p++) {
        int64_t b = lines->body[p];
        if (b < 0 || b >= lines->bodies || lines->leans[b] >= lines->matrices) return REFUSED;
        const double *matrix = lines->leans[b] < 0 ? 0 : lines->lean + 9 * lines->leans[b], *from = lines->origin + (lines->origins == 1 ? 0 : 3 * p);
        double *start = lines->first + 3 * kept, *way = lines->line + 3 * kept, *at = lines->begin + 3 * kept, end[3], toward[3];
        in_frame(from, lines->position + 3 * b, lines->cosine[b], lines->sine[b], matrix, lines->earth_radius, start);
        in_frame(lines->point + 3 * p, lines->position + 3 * b, lines->cosine[b], lines->sine[b], matrix, lines->earth_radius, end);
        subtract(end, start, way);
        subtract(lines->centre + 3 * b, start, toward);
        double length2 = larger(dot(way, way), 1e-12), progress = dot(way, toward) / length2;
        if (lines->passing) {
            double along = share(progress), miss[3];
            for (int axis = 0; axis < 3; axis++) miss[axis] = toward[axis] - way[axis] * along;
            if (dot(miss, miss) > lines->radius[b] * lines->radius[b]) continue;
        }
        double part = share(progress - lines->radius[b] / sqrt(length2));
        for (int axis = 0; axis < 3; axis++) at[axis] = start[axis] + way[axis] * part;
        lines->skipped[kept] = part;
        lines->which[kept++] = p;
    }
    return kept;
}

/* Pairs of a body and a point that it may occlude, by rising body. Returns how many.
 *
 * Sectors (S), S = count: body (S) of each, and its points first to last (S), exclusive, in rising azimuth. Of all bodies (B):
 * distance at which the sector begins, begin (B), and top slope, top (B). Of the points (E): order (E) by rising azimuth; distance
 * and slope (E) of the line of sight, in that order. bodies, points: with room for the points of all sectors. */
/* Arrays: body (count) < B; first, last (count) < E + 1; begin, top (B); order, distance, slope (E); bodies, points (room) */
KERNEL int64_t points_behind(int64_t count, int64_t room, const int64_t *body, const int64_t *first, const int64_t *last, const double *begin,
                             const double *top, const int64_t *order, const double *distance, const double *slope,
                             int64_t *bodies, int64_t *points) {
    int64_t kept = 0, most = 0;
    for (int64_t s = 0; s < count; s++) most += last[s] > first[s] ? last[s] - first[s] : 0;
    if (most > room) return REFUSED;
    for (int64_t s = 0; s < count; s++) {
        int64_t b = body[s];
        double nearest = begin[b], highest = top[b];
        for (int64_t i = first[s]; i < last[s]; i++) {
            bodies[kept] = b;
            points[kept] = order[i];
            kept += (distance[i] >= nearest) & (slope[i] <= highest);
        }
    }
    return kept;
}
