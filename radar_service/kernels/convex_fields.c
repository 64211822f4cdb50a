/* Fields of a small convex body at many instants, on the nodes of one lattice: what `OpticalBody.echoes` does step by step in numpy,
 * where nothing of the body occludes it: scattering/physical_optics/convex_bodies.py. */

#include <stdlib.h>
#include <string.h>

#include "called.h"
#include "shadows.h"

static const double DIVERGING = 0.99, NO_FIELD = 1e-9, AT_LEVEL = 1e-6; /* of optical_body.py and triangle_cuts.py */
/* PIECES: of memory that one instant takes, no more than 90. */
enum { LEGS = 2, PATHS = 3, CORNERS = 8, PIECES = 128 };
static const int OUT[PATHS] = {0, 0, 1}, BACK[PATHS] = {0, 1, 1};

/* Memory for one instant: taken piece by piece, and again from its start for the next instant. */
typedef struct {
    void *blocks[PIECES];
    size_t room[PIECES];
    int next;
} Memory;

/* So many bytes; NULL where there are none. */
static void *taken(Memory *memory, int64_t count, size_t size) {
    size_t bytes = ((size_t)count + 1) * size;
    int which = memory->next++;
    if (which >= PIECES) return NULL;
    if (memory->room[which] < bytes) {
        free(memory->blocks[which]);
        memory->blocks[which] = malloc(2 * bytes);
        memory->room[which] = memory->blocks[which] ? 2 * bytes : 0;
    }
    return memory->blocks[which];
}

static void freed(Memory *memory) {
    for (int which = 0; which < PIECES; which++) free(memory->blocks[which]);
}

/* The body, as it is at all instants: as of `convex_fields`. */
typedef struct {
    int64_t coarse, fine, points;
    const double *corners;
    const int64_t *triangle, *facet;
    double longest;
    const double *face_point, *face_normal;
    const int8_t *outside;
    int64_t faces;
    const int64_t *fine_corner, *first;
    const double *fine_points, *box;
} Body;

typedef struct {
    int64_t legs, level;
    double wavenumber, earth_radius, dropped;
} Waves;

typedef struct {
    const double *position, *antenna;
    double cosine, sine;
} Pose;

/* The shadows on the body along one leg, and where they may end. */
typedef struct {
    int64_t triangles, edges;
    double *plane, *offset, *edge_plane, *edge_offset;
} Shadows;

/* Triangles (M) of the surface: side and share (M, LEGS) as of `Surface`. */
typedef struct {
    int64_t count;
    double *corners, *share;
    int64_t *triangle, *facet;
} Surface;

static void on_map(const double *point, const Pose *pose, double *result) {
    result[0] = point[0] * pose->cosine + point[1] * pose->sine + pose->position[0];
    result[1] = point[1] * pose->cosine - point[0] * pose->sine + pose->position[1];
    result[2] = point[2] + pose->position[2];
}

/* Puts the parts of a triangle that rise above the sea into `parts` (2, 3, 3); returns how many there are: `above_water`. */
static int64_t above_water(const double *corners, double *parts) {
    double height[3];
    int below = 0, turn = 0;
    for (int c = 0; c < 3; c++) {
        height[c] = fabs(corners[3 * c + 2]) < AT_LEVEL ? 0.0 : corners[3 * c + 2];
        below += height[c] < 0.0;
    }
    if (below == 3) return 0;
    memcpy(parts, corners, 9 * sizeof *parts);
    if (!below) return 1;
    for (int c = 0; c < 3; c++)
        if ((height[c] < 0.0) == (below == 1)) turn = c;
    const double *a = corners + 3 * turn, *b = corners + 3 * ((turn + 1) % 3), *c = corners + 3 * ((turn + 2) % 3);
    double along_b = height[turn] / (height[turn] - height[(turn + 1) % 3]);
    double along_c = height[turn] / (height[turn] - height[(turn + 2) % 3]), ab[3], ac[3];
    for (int axis = 0; axis < 3; axis++) {
        ab[axis] = a[axis] + along_b * (b[axis] - a[axis]);
        ac[axis] = a[axis] + along_c * (c[axis] - a[axis]);
    }
    const double *one[6] = {a, ab, ac, NULL, NULL, NULL}, *two[6] = {ab, b, c, ab, c, ac};
    for (int64_t corner = 0; corner < (below == 2 ? 3 : 6); corner++)
        memcpy(parts + 3 * corner, (below == 2 ? one : two)[corner], 3 * sizeof *parts);
    return below == 2 ? 1 : 2;
}

/* Which of triangles (T, 3, 3) on the map may stand before the body, above the sea, are put into `before` (2 T, 3, 3); returns how
 * many. */
static int64_t standing_before(int64_t count, const double *triangles, const double *box, const Waves *waves, const Pose *pose,
                               double *before) {
    static const double matrix[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, position[3] = {0.0, 0.0, 0.0};
    double own[LEGS * WINDOW_SIZES];
    int64_t total = 0;
    for (int leg = 0; leg < waves->legs; leg++) {
        Window window = window_of(box, CORNERS, pose->antenna, waves->earth_radius, leg);
        memcpy(own + WINDOW_SIZES * leg, &window, sizeof window);
    }
    for (int64_t t = 0; t < count; t++) {
        uint8_t stands;
        stand_before(1, 3, waves->legs, triangles + 9 * t, matrix, position, pose->antenna, waves->earth_radius, 0.0, own, &stands);
        if (stands) total += above_water(triangles + 9 * t, before + 9 * total);
    }
    return total;
}

/* Whether a shadow may lie on the hull of the box at virtual positions: `CastShadows.on`. */
static int lies_on(const double *box, const double *plane, const double *offset) {
    const double bent = 0.01; /* m, BENT of cast_shadows.py */
    for (int k = 0; k < 4; k++) {
        double most = -INFINITY;
        for (int c = 0; c < CORNERS; c++) most = larger(most, dot(plane + 3 * k, box + 3 * c));
        if (!(most > offset[k] - bent)) return 0;
    }
    return 1;
}

/* The shadows of triangles (T, 3, 3) on the map along a leg: `Onlooker.shadows`. Returns how many there are, or NO_MEMORY. */
static int64_t shadows_along(int leg, int64_t count, const double *triangles, const double *box, const Waves *waves,
                             const Pose *pose, Memory *memory, Shadows *shadows) {
    int64_t every = (leg + 1) * count, total = 0;
    double *virtual = taken(memory, 9 * every, sizeof(double)), *kept = taken(memory, 9 * every, sizeof(double));
    double *distance = taken(memory, every, sizeof(double)), hull[3 * CORNERS];
    shadows->plane = taken(memory, 12 * every, sizeof(double));
    shadows->offset = taken(memory, 4 * every, sizeof(double));
    shadows->edge_plane = taken(memory, 48 * every, sizeof(double));
    shadows->edge_offset = taken(memory, 16 * every, sizeof(double));
    if (!virtual || !kept || !distance || !shadows->plane || !shadows->offset || !shadows->edge_plane || !shadows->edge_offset)
        return NO_MEMORY;
    for (int by_sea = 0; by_sea <= leg; by_sea++)
        for (int64_t i = 0; i < 3 * count; i++)
            virtual_of(triangles + 3 * i, pose->antenna, waves->earth_radius, by_sea, virtual + 9 * count * by_sea + 3 * i);
    for (int c = 0; c < CORNERS; c++) virtual_of(box + 3 * c, pose->antenna, waves->earth_radius, leg, hull + 3 * c);
    int64_t casting = shadow_planes(every, virtual, kept, shadows->plane, shadows->offset, distance);
    for (int64_t i = 0; i < casting; i++) {
        if (!lies_on(hull, shadows->plane + 12 * i, shadows->offset + 4 * i)) continue;
        memmove(kept + 9 * total, kept + 9 * i, 9 * sizeof(double));
        memmove(shadows->plane + 12 * total, shadows->plane + 12 * i, 12 * sizeof(double));
        memmove(shadows->offset + 4 * total++, shadows->offset + 4 * i, 4 * sizeof(double));
    }
    shadows->triangles = total;
    if (!total) return 0;
    shadows->edges = silhouettes(total, kept, shadows->edge_plane, shadows->edge_offset);
    if (shadows->edges < 0) return NO_MEMORY;
    for (int64_t i = 0; i < total; i++, shadows->edges++) /* a triangle's own plane cuts within those through its edges */
        for (int k = 0; k < 4; k++) {
            int from = (k + 3) % 4;
            memcpy(shadows->edge_plane + 12 * shadows->edges + 3 * k, shadows->plane + 12 * i + 3 * from, 3 * sizeof(double));
            shadows->edge_offset[4 * shadows->edges + k] = shadows->offset[4 * i + from];
        }
    return total;
}

/* Which side of each face each leg lights, (F, LEGS): `_lit_sides`. Returns NO_MEMORY or 0. */
static int64_t lit_sides(const Body *body, const Waves *waves, const Pose *pose, Memory *memory, int8_t *side) {
    int64_t count = body->faces;
    double *rays = taken(memory, 7 * count, sizeof(double));
    uint8_t *arrives = taken(memory, count, sizeof(uint8_t));
    if (!rays || !arrives) return NO_MEMORY;
    double *east = rays + count, *north = rays + 2 * count, *rise = rays + 3 * count, *flat = rays + 4 * count;
    double *tilt = rays + 6 * count;
    for (int leg = 0; leg < waves->legs; leg++) {
        leg_rays(&(PointRays){count, leg, body->face_point, pose->position, pose->cosine, pose->sine, pose->antenna,
                              waves->earth_radius, rays, east, north, rise, flat, rays + 5 * count, tilt, arrives});
        for (int64_t f = 0; f < count; f++) {
            const double *normal = body->face_normal + 3 * f;
            double direction[3] = {east[f] * flat[f], north[f] * flat[f], rise[f]};
            double facing = dot(normal, direction) + tilt[f] * normal[2];
            int lit = (facing < 0.0) - (facing > 0.0);
            side[LEGS * f + leg] = (int8_t)(arrives[f] && lit * body->outside[f] > 0 ? lit : 0);
        }
    }
    return 0;
}

/* Cuts a surface at the shadows along a leg: `_past_others`. Returns NO_MEMORY or 0. */
static int64_t past_others(Surface *surface, int leg, const Shadows *shadows, const Waves *waves, const Pose *pose,
                           Memory *memory) {
    int64_t reached = 0, kept = 0, count = surface->count;
    if (!shadows->triangles || !count) return 0;
    int64_t *which = taken(memory, count, sizeof(int64_t));
    double *corners = taken(memory, 9 * count, sizeof(double)), *virtual = taken(memory, 9 * count, sizeof(double));
    uint8_t *divided = taken(memory, count, sizeof(uint8_t));
    if (!which || !corners || !virtual || !divided) return NO_MEMORY;
    for (int64_t i = 0; i < count; i++) {
        divided[i] = 0;
        if (!(surface->share[LEGS * i + leg] > 0.0)) continue;
        memcpy(corners + 9 * reached, surface->corners + 9 * i, 9 * sizeof(double));
        for (int c = 0; c < 3; c++) {
            double place[3];
            on_map(surface->corners + 9 * i + 3 * c, pose, place);
            virtual_of(place, pose->antenna, waves->earth_radius, leg, virtual + 9 * reached + 3 * c);
        }
        which[reached++] = i;
    }
    int64_t room = 2 * reached + 64, parts = 0;
    int keep = memory->next;
    double *cut = NULL;
    int64_t *origin = NULL;
    uint8_t *bright = NULL;
    for (int again = 0; again < 2; again++) {
        memory->next = keep;
        cut = taken(memory, 9 * room, sizeof(double));
        origin = taken(memory, room, sizeof(int64_t));
        bright = taken(memory, room, sizeof(uint8_t));
        if (!cut || !origin || !bright) return NO_MEMORY;
        parts = cast_cuts(reached, shadows->edges, shadows->triangles, room, corners, virtual, shadows->edge_plane,
                          shadows->edge_offset, shadows->plane, shadows->offset, cut, origin, bright);
        if (parts < 0) return NO_MEMORY;
        if (parts <= room) break;
        room = parts;
    }
    if (!parts) return 0;
    Surface next;
    next.corners = taken(memory, 9 * (count + parts), sizeof(double));
    next.share = taken(memory, LEGS * (count + parts), sizeof(double));
    next.triangle = taken(memory, count + parts, sizeof(int64_t));
    next.facet = taken(memory, count + parts, sizeof(int64_t));
    if (!next.corners || !next.share || !next.triangle || !next.facet) return NO_MEMORY;
    for (int64_t p = 0; p < parts; p++) divided[which[origin[p]]] = 1;
    for (int64_t i = 0; i < count + parts; i++) {
        int64_t from = i < count ? i : which[origin[i - count]];
        if (i < count && divided[i]) continue;
        memcpy(next.corners + 9 * kept, i < count ? surface->corners + 9 * i : cut + 9 * (i - count), 9 * sizeof(double));
        memcpy(next.share + LEGS * kept, surface->share + LEGS * from, LEGS * sizeof(double));
        if (i >= count && !bright[i - count]) next.share[LEGS * kept + leg] = 0.0;
        next.triangle[kept] = surface->triangle[from];
        next.facet[kept++] = i < count ? surface->facet[i] : -1;
    }
    next.count = kept;
    *surface = next;
    return 0;
}

/* Fine facets (M) of a surface: corner (3, M) in points (V, 3), origin (M) in the surface: `BodyFacets.cut`. */
typedef struct {
    int64_t count, points;
    int64_t *corner, *origin;
    double *place;
} Fine;

static int64_t fine_facets(const Body *body, const Surface *surface, Memory *memory, Fine *fine) {
    int64_t whole = 0, parts = 0, cuts = 0, room = 0;
    for (int64_t i = 0; i < surface->count; i++) {
        int64_t facet = surface->facet[i];
        if (facet >= 0) whole += body->first[facet + 1] - body->first[facet];
        else parts++;
    }
    double *corners = taken(memory, 9 * parts, sizeof(double)), *longest = taken(memory, parts, sizeof(double)), *cut = NULL;
    int64_t *part = taken(memory, parts, sizeof(int64_t)), *used = taken(memory, body->points, sizeof(int64_t)), *origin = NULL;
    if (!corners || !longest || !part || !used) return NO_MEMORY;
    parts = 0;
    for (int64_t i = 0; i < surface->count; i++) {
        if (surface->facet[i] >= 0) continue;
        memcpy(corners + 9 * parts, surface->corners + 9 * i, 9 * sizeof(double));
        longest[parts] = body->longest;
        part[parts++] = i;
    }
    int keep = memory->next;
    for (int again = 0; again < 2; again++) {
        memory->next = keep;
        room = again ? cuts : 4 * parts + 16;
        cut = taken(memory, 9 * room, sizeof(double));
        origin = taken(memory, room, sizeof(int64_t));
        if (!cut || !origin) return NO_MEMORY;
        cuts = cut_triangles(parts, room, corners, longest, cut, origin);
        if (cuts < 0) return cuts;
        if (cuts <= room) break;
    }
    fine->corner = taken(memory, 3 * (whole + cuts), sizeof(int64_t));
    fine->origin = taken(memory, whole + cuts, sizeof(int64_t));
    fine->place = taken(memory, 3 * (body->points + 3 * cuts), sizeof(double));
    int64_t *number = taken(memory, 3 * cuts, sizeof(int64_t)), at = 0, count = whole + cuts;
    if (!fine->corner || !fine->origin || !fine->place || !number) return NO_MEMORY;
    for (int64_t i = 0; i < body->points; i++) used[i] = -1;
    fine->count = count;
    fine->points = 0;
    for (int64_t i = 0; i < surface->count; i++) {
        int64_t facet = surface->facet[i];
        if (facet < 0) continue;
        for (int64_t k = body->first[facet]; k < body->first[facet + 1]; k++, at++) {
            fine->origin[at] = i;
            for (int c = 0; c < 3; c++) {
                int64_t point = body->fine_corner[c * body->fine + k];
                if (used[point] < 0) {
                    memcpy(fine->place + 3 * fine->points, body->fine_points + 3 * point, 3 * sizeof(double));
                    used[point] = fine->points++;
                }
                fine->corner[c * count + at] = used[point];
            }
        }
    }
    int64_t more = cuts ? welded(cuts, cut, number, fine->place + 3 * fine->points) : 0;
    if (more < 0) return NO_MEMORY;
    for (int64_t k = 0; k < cuts; k++) {
        fine->origin[whole + k] = part[origin[k]];
        for (int c = 0; c < 3; c++) fine->corner[c * count + whole + k] = number[c * cuts + k] + fine->points;
    }
    fine->points += more;
    return 0;
}

/* What facets need of one leg: rays at their centroids (7, M), bends (3, M), phases, phasors and lengths (V) at their points. */
typedef struct {
    double *rays, *bend, *phase, *length;
    Complex *at;
} LegFields;

static int64_t leg_fields(int leg, const Fine *fine, const double *edges, const double *centre, const Waves *waves,
                          const Pose *pose, Memory *memory, LegFields *of) {
    int64_t count = fine->count, points = fine->points;
    uint8_t *arrives = taken(memory, count, sizeof(uint8_t));
    of->rays = taken(memory, 7 * count, sizeof(double));
    of->bend = taken(memory, 3 * count, sizeof(double));
    of->phase = taken(memory, points, sizeof(double));
    of->length = taken(memory, points, sizeof(double));
    of->at = taken(memory, points, sizeof(Complex));
    if (!arrives || !of->rays || !of->bend || !of->phase || !of->length || !of->at) return NO_MEMORY;
    double *rays = of->rays;
    leg_rays(&(PointRays){count, leg, centre, pose->position, pose->cosine, pose->sine, pose->antenna, waves->earth_radius, rays,
                          rays + count, rays + 2 * count, rays + 3 * count, rays + 4 * count, rays + 5 * count, rays + 6 * count,
                          arrives});
    sags(count, 3, edges, rays + count, rays + 2 * count, rays + 3 * count, rays + 4 * count, rays, rays + 5 * count, of->bend);
    for (int64_t i = 0; i < 3 * count; i++) of->bend[i] *= -waves->wavenumber / 4.0;
    leg_lengths(points, leg, fine->place, pose->position, pose->cosine, pose->sine, pose->antenna, waves->earth_radius, of->length);
    for (int64_t i = 0; i < points; i++) {
        of->phase[i] = -waves->wavenumber * of->length[i];
        of->at[i] = phasor(of->phase[i]);
    }
    return 0;
}

/* Lattices that hold the whole body: the first cell and how many nodes along each axis, sizes of cells and a node [m]. */
typedef struct {
    const int64_t *first, *extent;
    const double *steps, *base;
    int from_zero;
} Grid;

/* Which nodes points (V, 3) have shares in, and these (8, V): as of `Lattice`, by numbers in the grid. */
static int shares(const Grid *grid, int64_t count, const double *points, int64_t *corner, double *share) {
    for (int64_t i = 0; i < count; i++) {
        int64_t at = 0;
        double inside[3];
        for (int axis = 0; axis < 3; axis++) {
            double place = (points[3 * i + axis] - grid->base[axis]) / grid->steps[axis], below = floor(place);
            if (grid->from_zero && axis == 2) below = larger(below, 0.0);
            inside[axis] = place - below;
            double within = below - (double)grid->first[axis];
            if (!(within >= 0.0 && within <= (double)(grid->extent[axis] - 2))) return REFUSED;
            at = at * grid->extent[axis] + (int64_t)within;
        }
        double aside[4] = {(1.0 - inside[0]) * (1.0 - inside[1]), (1.0 - inside[0]) * inside[1],
                           inside[0] * (1.0 - inside[1]), inside[0] * inside[1]};
        for (int n = 0; n < 4; n++) {
            int64_t low = at + grid->extent[1] * grid->extent[2] * (n / 2) + grid->extent[2] * (n % 2);
            corner[8 * i + 2 * n] = low;
            corner[8 * i + 2 * n + 1] = low + 1;
            share[8 * i + 2 * n + 1] = aside[n] * inside[2];
            share[8 * i + 2 * n] = aside[n] - share[8 * i + 2 * n + 1];
        }
    }
    return 0;
}

static int by_size(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* Puts the faintest of amplitudes (N) to 0, whose powers add up to `dropped` of the strongest's: `strongest`. power (N): to work in. */
static void drop_faintest(int64_t count, const int64_t *which, Complex *amplitude, double dropped, double *power) {
    double limit = 0.0, sum = 0.0, highest = -1.0;
    int64_t below = 0;
    for (int64_t n = 0; n < count; n++) {
        Complex at = amplitude[which[n]];
        limit = larger(limit, dropped * (at.re * at.re + at.im * at.im));
    }
    for (int64_t n = 0; n < count; n++) {
        Complex at = amplitude[which[n]];
        double own = at.re * at.re + at.im * at.im;
        if (own <= limit) power[below++] = own;
    }
    qsort(power, (size_t)below, sizeof *power, by_size);
    for (int64_t n = 0; n < below && (sum += power[n]) <= limit; n++) highest = power[n];
    for (int64_t n = 0; n < count; n++) {
        Complex *at = amplitude + which[n];
        if (at->re * at->re + at->im * at->im <= highest) *at = complex_of(0.0, 0.0);
    }
}

/* Sums the fields of all paths at points on the nodes of the grid (paths, G), as of `OpticalBody._summed`. */
static int64_t summed(const Grid *grid, const Fine *fine, const Complex *const *fields, const Waves *waves, const Pose *pose,
                      Memory *memory, Complex *amplitude) {
    int64_t size = grid->extent[0] * grid->extent[1] * grid->extent[2], used = 0;
    int paths = waves->legs > 1 ? PATHS : 1;
    int64_t *corner = taken(memory, 8 * fine->points, sizeof(int64_t)), *number = taken(memory, size, sizeof(int64_t));
    int64_t *grid_of = taken(memory, size, sizeof(int64_t));
    double *share = taken(memory, 8 * fine->points, sizeof(double)), *nodes = taken(memory, 3 * size, sizeof(double));
    double *length = taken(memory, LEGS * size, sizeof(double)), *weight = taken(memory, size + fine->points, sizeof(double));
    if (!corner || !number || !grid_of || !share || !nodes || !length || !weight) return NO_MEMORY;
    if (shares(grid, fine->points, fine->place, corner, share)) return REFUSED;
    for (int64_t g = 0; g < size; g++) number[g] = -1;
    for (int64_t i = 0; i < 8 * fine->points; i++) number[corner[i]] = 0;
    for (int64_t g = 0; g < size; g++) {
        if (number[g] < 0) continue;
        int64_t index[3] = {g / (grid->extent[1] * grid->extent[2]), g / grid->extent[2] % grid->extent[1], g % grid->extent[2]};
        for (int axis = 0; axis < 3; axis++)
            nodes[3 * used + axis] = (double)(index[axis] + grid->first[axis]) * grid->steps[axis] + grid->base[axis];
        grid_of[used] = g;
        number[g] = used++;
    }
    for (int leg = 0; leg < waves->legs; leg++)
        leg_lengths(used, leg, nodes, pose->position, pose->cosine, pose->sine, pose->antenna, waves->earth_radius,
                    length + leg * size);
    double *at_points = weight + size, faintest = 1.0;
    if (waves->legs > 1) {
        leg_weights(used, nodes, pose->position, pose->cosine, pose->sine, pose->antenna, waves->earth_radius, weight);
        leg_weights(fine->points, fine->place, pose->position, pose->cosine, pose->sine, pose->antenna, waves->earth_radius,
                    at_points);
        for (int64_t n = 0; n < used; n++) faintest = smaller(faintest, weight[n]);
    }
    for (int path = 0; path < paths; path++) {
        Complex *sums = amplitude + path * size;
        for (int64_t i = 0; i < fine->points; i++) {
            double ratio = 1.0, between = 0.0;
            if (path && faintest <= DIVERGING) {
                for (int c = 0; c < 8; c++) {
                    double there = weight[number[corner[8 * i + c]]];
                    between += share[8 * i + c] * (path == 2 ? there * there : there);
                }
                double own = path == 2 ? at_points[i] * at_points[i] : at_points[i];
                ratio = fabs(between) > NO_FIELD ? own / between : 0.0;
            }
            Complex field = scaled(fields[path][i], ratio);
            for (int c = 0; c < 8; c++) {
                Complex *sum = sums + corner[8 * i + c];
                *sum = plus(*sum, scaled(field, share[8 * i + c]));
            }
        }
        for (int64_t n = 0; n < used; n++) {
            double way = length[OUT[path] * size + n] + length[BACK[path] * size + n];
            sums[grid_of[n]] = times(sums[grid_of[n]], phasor(waves->wavenumber * way));
        }
        drop_faintest(used, grid_of, sums, waves->dropped, nodes);
    }
    return 0;
}

/* The fields of one instant. Returns 0, 1 where too many triangles cast shadows, or NO_MEMORY. */
static int64_t instant_fields(const Body *body, const Waves *waves, const Pose *pose, const Grid *grid, int64_t casting,
                              const double *triangles, int64_t most, Memory *memory, Complex *amplitude) {
    Shadows shadows[LEGS] = {{0}};
    Surface surface;
    Fine fine;
    LegFields of[LEGS];
    const Complex *fields[PATHS];
    double box[3 * CORNERS];
    for (int c = 0; c < CORNERS; c++) on_map(body->box + 3 * c, pose, box + 3 * c);
    memory->next = 0;
    int8_t *face_side = taken(memory, LEGS * body->faces, sizeof(int8_t));
    double *before = taken(memory, 18 * casting, sizeof(double));
    surface.corners = taken(memory, 9 * body->coarse, sizeof(double));
    surface.share = taken(memory, LEGS * body->coarse, sizeof(double));
    surface.triangle = taken(memory, body->coarse, sizeof(int64_t));
    surface.facet = taken(memory, body->coarse, sizeof(int64_t));
    if (!face_side || !before || !surface.corners || !surface.share || !surface.triangle || !surface.facet) return NO_MEMORY;
    if (lit_sides(body, waves, pose, memory, face_side)) return NO_MEMORY;
    surface.count = 0;
    for (int64_t i = 0; i < body->coarse; i++) {
        const int8_t *side = face_side + LEGS * body->triangle[i];
        if (!side[0] && (waves->legs < 2 || !side[1])) continue;
        memcpy(surface.corners + 9 * surface.count, body->corners + 9 * i, 9 * sizeof(double));
        for (int leg = 0; leg < LEGS; leg++)
            surface.share[LEGS * surface.count + leg] = leg < waves->legs && side[leg] ? 1.0 : 0.0;
        surface.triangle[surface.count] = body->triangle[i];
        surface.facet[surface.count++] = body->facet[i];
    }
    int64_t standing = standing_before(casting, triangles, box, waves, pose, before);
    for (int leg = 0; leg < waves->legs && standing; leg++) {
        int start = memory->next;
        int64_t count = shadows_along(leg, standing, before, box, waves, pose, memory, shadows + leg);
        if (count < 0) return NO_MEMORY;
        if (count > most) return 1;
        if (!count) memory->next = start;
    }
    for (int leg = 0; leg < waves->legs; leg++)
        if (past_others(&surface, leg, shadows + leg, waves, pose, memory)) return NO_MEMORY;
    int64_t kept = 0;
    for (int64_t i = 0; i < surface.count; i++) {
        if (!(surface.share[LEGS * i] > 0.0 || surface.share[LEGS * i + 1] > 0.0)) continue;
        memmove(surface.corners + 9 * kept, surface.corners + 9 * i, 9 * sizeof(double));
        memmove(surface.share + LEGS * kept, surface.share + LEGS * i, LEGS * sizeof(double));
        surface.triangle[kept] = surface.triangle[i];
        surface.facet[kept++] = surface.facet[i];
    }
    surface.count = kept;
    if (!kept) return 0;
    int64_t failed = fine_facets(body, &surface, memory, &fine);
    if (failed) return failed;
    int64_t count = fine.count;
    double *edges = taken(memory, 9 * count, sizeof(double)), *centre = taken(memory, 3 * count, sizeof(double));
    double *area = taken(memory, count, sizeof(double)), *normal = taken(memory, 3 * count, sizeof(double));
    double *share = taken(memory, LEGS * count, sizeof(double));
    int8_t *side = taken(memory, LEGS * count, sizeof(int8_t));
    if (!edges || !centre || !area || !normal || !share || !side) return NO_MEMORY;
    facet_shapes(count, fine.place, fine.corner, edges, centre, area);
    for (int64_t k = 0; k < count; k++) {
        int64_t triangle = surface.triangle[fine.origin[k]];
        for (int axis = 0; axis < 3; axis++) normal[axis * count + k] = body->face_normal[3 * triangle + axis];
        for (int leg = 0; leg < LEGS; leg++) {
            side[LEGS * k + leg] = face_side[LEGS * triangle + leg];
            share[LEGS * k + leg] = surface.share[LEGS * fine.origin[k] + leg];
        }
    }
    for (int leg = 0; leg < waves->legs; leg++)
        if (leg_fields(leg, &fine, edges, centre, waves, pose, memory, of + leg)) return NO_MEMORY;
    int paths = waves->legs > 1 ? PATHS : 1;
    Complex *every = taken(memory, paths * fine.points, sizeof(Complex));
    if (!every) return NO_MEMORY;
    memset(every, 0, (size_t)(paths * fine.points) * sizeof(Complex));
    for (int path = 0; path < paths; path++) {
        const LegFields *out = of + OUT[path], *back = of + BACK[path];
        fields[path] = every + path * fine.points;
        facet_fields(count, LEGS, OUT[path], BACK[path], waves->level, fine.corner, normal, area, side, share, out->rays + count,
                     out->rays + 2 * count, out->rays + 3 * count, out->rays + 4 * count, out->rays, out->bend, out->phase,
                     out->at, out->length, back->rays + count, back->rays + 2 * count, back->rays + 3 * count,
                     back->rays + 4 * count, back->rays, back->bend, back->phase, back->at, back->length,
                     every + path * fine.points);
    }
    return summed(grid, &fine, fields, waves, pose, memory, amplitude);
}

/* Fields of a convex body at instants (S), S = count, on the nodes of a grid (G), without the factor of the current: amplitude
 * (S, paths, G), 0 before the call. state (S): 0, or 1 where more than `most` triangles cast shadows and nothing is computed.
 *
 * legs: 1, or 2 with the one by the sea, then there are 3 paths. level: whether the polarization is "h". dropped: as of
 * `strongest`. Of the body, in its frame:
 * coarse facets (M) above the water, corners (M, 3, 3), the face of each (M), the facet that each is as a whole, -1 for a part (M),
 * and the longest edge of their parts [m]; of faces (F) a point, the normal (F, 3), and the side that is outside (F), 0 of those that
 * nothing lights; fine facets, corner (3, K) in points (V, 3), the first of each coarse one; box (8, 3) around what is dry. position
 * (S, 3), cosine, sine (S) of the heading, antenna (S, 3). Of others (O): begin (O + 1) of each among triangles (T, 3, 3) in its own
 * frame; turn (S, O, 3, 3) and place (S, O, 3) from there to the map. first, extent (3), steps, base (3), from_zero: of the grid. */
/* Arrays: legs from 1 < 3; corners (coarse, 3, 3); triangle (coarse) < faces; facet (coarse) from -1 < whole; face_point, face_normal (faces, 3);
 * outside (faces); fine_corner (3, fine) < points; fine_points (points, 3); first_fine (whole + 1) < fine + 1; box (8, 3);
 * position, antenna (count, 3); cosine, sine, state (count); begin (others + 1) < T + 1; others_corners (T, 3, 3);
 * turn (count, others, 3, 3); place (count, others, 3); first, extent, steps, base (3); amplitude (count, 2 * legs - 1, nodes) */
KERNEL int64_t convex_fields(int64_t count, int64_t legs, int64_t level, int64_t coarse, int64_t faces, int64_t whole, int64_t fine,
                             int64_t points, int64_t others, int64_t most, int64_t from_zero, int64_t nodes, double wavenumber,
                             double earth_radius, double dropped, double longest, const double *corners,
                             const int64_t *triangle, const int64_t *facet, const double *face_point, const double *face_normal, const int8_t *outside,
                             const int64_t *fine_corner, const double *fine_points, const int64_t *first_fine, const double *box,
                             const double *position, const double *cosine, const double *sine, const double *antenna,
                             const int64_t *begin, const double *others_corners, const double *turn, const double *place,
                             const int64_t *first, const int64_t *extent, const double *steps, const double *base,
                             Complex *amplitude, int64_t *state) {
    Body body = {coarse, fine, points, corners, triangle, facet, longest, face_point, face_normal, outside, faces,
                 fine_corner, first_fine, fine_points, box};
    Waves waves = {legs, level, wavenumber, earth_radius, dropped};
    Grid grid = {first, extent, steps, base, from_zero != 0};
    Memory memory = {{NULL}, {0}, 0};
    int64_t size = (legs > 1 ? PATHS : 1) * nodes, casting = begin[others], failed = begin[0];
    double cells = 1.0;
    for (int axis = 0; axis < 3; axis++) cells *= larger((double)extent[axis], 0.0);
    for (int64_t o = 0; o < others; o++) failed |= begin[o] > begin[o + 1];
    for (int64_t facet = 0; facet < whole; facet++) failed |= first_fine[facet] > first_fine[facet + 1];
    if (failed || cells != (double)nodes) return REFUSED;
    double *triangles = malloc(((size_t)casting + 1) * 9 * sizeof *triangles);
    for (int64_t s = 0; s < count && !failed; s++) {
        Pose pose = {position + 3 * s, antenna + 3 * s, cosine[s], sine[s]};
        if (!triangles) {
            failed = NO_MEMORY;
            break;
        }
        for (int64_t o = 0; o < others; o++)
            for (int64_t c = 3 * begin[o]; c < 3 * begin[o + 1]; c++)
                for (int axis = 0; axis < 3; axis++)
                    triangles[3 * c + axis] = dot(turn + 9 * (others * s + o) + 3 * axis, others_corners + 3 * c) +
                                              place[3 * (others * s + o) + axis];
        state[s] = instant_fields(&body, &waves, &pose, &grid, casting, triangles, most, &memory, amplitude + size * s);
        failed = state[s] < 0 ? state[s] : 0;
    }
    free(triangles);
    freed(&memory);
    return failed ? failed : count;
}
