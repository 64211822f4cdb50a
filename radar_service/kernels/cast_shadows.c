/* Triangles of a body cut where shadows of others end on them: scattering/physical_optics/cast_shadows.py. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"

static const double ON_PLANE = 1e-6, GRAZING = 1e-9, ALONG = 1e-5; /* m, and rad,  */
static const double WIDER = 1e-8, NEEDLE = 1e-6; /* margin of extents, ; rad between sides without a sure corner */
/* AXES: corners in the body's frame, then at virtual positions. TOGETHER: neighbouring triangles that are tested at once first. */
enum { AXES = 6, TOGETHER = 16 };
enum { UNKNOWN, COVERED, BARE };

typedef struct {
    double at[3][AXES]; /* its corners */
    int lit;
} Piece;

typedef struct {
    Piece *pieces;
    int64_t count, room;
} Pieces;

/* A place for one more piece, NULL without memory. */
static Piece *added(Pieces *all) {
    if (all->count == all->room) {
        int64_t room = all->room ? 2 * all->room : 64;
        Piece *more = realloc(all->pieces, (size_t)room * sizeof *more);
        if (!more) return NULL;
        all->pieces = more;
        all->room = room;
    }
    return &all->pieces[all->count++];
}

/* What the antenna sees about a direction: unit vectors there, aside and up. */
typedef struct {
    double ahead[3], aside[3], up[3];
} View;

/* The lowest and the highest numbers aside and up, of what lies in a view, where there ahead is 1. */
typedef struct {
    double low[2], high[2];
} Extent;

static const Extent NOTHING = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}}, ALL = {{-INFINITY, -INFINITY}, {INFINITY, INFINITY}};

static int64_t fewer(int64_t a, int64_t b) { return a < b ? a : b; }

static void to_unit(double *vector) {
    double length = larger(sqrt(dot(vector, vector)), 1e-30);
    for (int axis = 0; axis < 3; axis++) vector[axis] /= length;
}

/* The view about the middle of points (N, 3). */
static View view_of(const double *points, int64_t count) {
    View view = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int64_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) view.ahead[axis] += points[3 * i + axis];
    to_unit(view.ahead);
    double steep = view.ahead[0] * view.ahead[0] + view.ahead[1] * view.ahead[1] < 1e-6, upright[3] = {steep, 0.0, 1.0 - steep};
    cross(view.ahead, upright, view.aside);
    to_unit(view.aside);
    cross(view.aside, view.ahead, view.up);
    return view;
}

/* Where a direction points in a view; 0 where it does not point ahead. */
static int place(const View *view, const double *direction, double *at) {
    double ahead = dot(view->ahead, direction);
    at[0] = dot(view->aside, direction) / ahead;
    at[1] = dot(view->up, direction) / ahead;
    return ahead > 0.0;
}

/* The extent of what lies between directions (N, 3). */
static Extent extent_of(const View *view, const double *directions, int64_t count) {
    Extent result = NOTHING;
    double at[2];
    for (int64_t i = 0; i < count; i++) {
        if (!place(view, directions + 3 * i, at)) return ALL;
        for (int axis = 0; axis < 2; axis++) {
            result.low[axis] = smaller(result.low[axis], at[axis]);
            result.high[axis] = larger(result.high[axis], at[axis]);
        }
    }
    return result;
}

static Extent widened(Extent extent) {
    for (int axis = 0; axis < 2; axis++) {
        extent.low[axis] -= WIDER;
        extent.high[axis] += WIDER;
    }
    return extent;
}

static int overlap(const Extent *a, const Extent *b) {
    return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] && b->low[1] <= a->high[1];
}

/* The extent of the shadow of a triangle with planes (4, 3): its corners lie where planes through its edges meet. */
static Extent shadow_extent(const View *view, const double *plane) {
    double corners[3][3];
    for (int k = 0; k < 3; k++) {
        cross(plane + 3 * ((k + 2) % 3), plane + 3 * k, corners[k]);
        double turn = dot(corners[k], plane + 3 * ((k + 1) % 3)) < 0.0 ? -1.0 : 1.0;
        if (!(dot(corners[k], corners[k]) > NEEDLE * NEEDLE)) return ALL;
        for (int axis = 0; axis < 3; axis++) corners[k][axis] *= turn;
    }
    return widened(extent_of(view, corners[0], 3));
}

/* The directions of the ends of a silhouette with planes (4, 3). */
static void ends_of(const double *plane, double ends[2][3]) {
    cross(plane + 3, plane, ends[0]);
    cross(plane, plane + 6, ends[1]);
}

/* All shadows (T) on a body, and edges (E) at which they may end: silhouettes, then a triangle's own plane each. */
typedef struct {
    View view;
    int64_t edges, triangles;
    const double *edge_plane, *edge_offset, *plane, *offset; /* as of `cast_cuts` */
    Extent *extent;                                          /* of the triangles, then of the edges */
    double (*spans)[2];                                      /* room for one a triangle */
    uint8_t *before, *edge; /* (T,): lies before all of the body; (E,): UNKNOWN, COVERED or BARE */
} Shadows;

/* What of the shadows concerns some neighbouring triangles: edges (E) that may cut one, and shadows (T) in which a part may lie. */
typedef struct {
    int64_t edges, shadows;
    Extent *edge_extent, *extent;
    double *edge_plane, *edge_offset, *plane, *offset;
} Near;

/* Which triangles lie before all of the body, whose corners (N, 3) have these virtual positions. */
static void find_before(Shadows *all, const double *virtual, int64_t count) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int64_t corner = 0; corner < count; corner++)
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = smaller(low[axis], virtual[3 * corner + axis]);
            high[axis] = larger(high[axis], virtual[3 * corner + axis]);
        }
    for (int64_t t = 0; t < all->triangles; t++) {
        const double *own = all->plane + 12 * t + 9;
        double least = 0.0;
        for (int axis = 0; axis < 3; axis++) least += smaller(own[axis] * low[axis], own[axis] * high[axis]);
        all->before[t] = least >= all->offset[4 * t + 3];
    }
}

static void release(const Shadows *all, const Near *near) {
    free(all->extent);
    free(all->spans);
    free(all->before);
    free(near->extent);
    free(near->plane);
}

/* Makes room, and finds where all shadows and edges lie as the antenna sees them; 0 without memory. `all` has its planes; points
 * (N, 3), N = count: of the body at virtual positions. */
static int look(Shadows *all, Near *near, const double *points, int64_t count) {
    size_t every = (size_t)(all->edges + all->triangles) + 1;
    all->extent = malloc(every * sizeof *all->extent);
    all->spans = malloc(every * sizeof *all->spans);
    all->before = calloc(every, sizeof *all->before);
    near->extent = malloc(every * sizeof *near->extent);
    near->plane = malloc(16 * every * sizeof *near->plane);
    if (!all->extent || !all->spans || !all->before || !near->extent || !near->plane) return 0;
    all->edge = all->before + all->triangles;
    near->edge_extent = near->extent + all->triangles;
    near->offset = near->plane + 12 * all->triangles;
    near->edge_plane = near->offset + 4 * all->triangles;
    near->edge_offset = near->edge_plane + 12 * all->edges;
    all->view = view_of(points, count);
    int64_t silhouettes = all->edges - all->triangles;
    for (int64_t t = 0; t < all->triangles; t++) all->extent[t] = shadow_extent(&all->view, all->plane + 12 * t);
    for (int64_t i = 0; i < all->edges; i++) {
        double ends[2][3];
        if (i < silhouettes) ends_of(all->edge_plane + 12 * i, ends);
        all->extent[all->triangles + i] =
            i < silhouettes ? widened(extent_of(&all->view, ends[0], 2)) : all->extent[i - silhouettes];
    }
    if (all->edges) find_before(all, points, count);
    return 1;
}

/* The part of the way from direction a to b that lies in the picture of a triangle with planes (4, 3); 0 where none does, or the
 * way lies along one of its sides. */
static int span_within(const double *a, const double *b, const double *plane, double *span) {
    span[0] = 0.0;
    span[1] = 1.0;
    for (int k = 0; k < 3; k++) {
        double from = dot(plane + 3 * k, a), to = dot(plane + 3 * k, b);
        if (fabs(from) < ALONG && fabs(to) < ALONG) return 0;
        from += GRAZING;
        to += GRAZING;
        if (from < 0.0 && to < 0.0) return 0;
        if (from < 0.0) span[0] = larger(span[0], from / (from - to));
        if (to < 0.0) span[1] = smaller(span[1], from / (from - to));
    }
    return span[0] < span[1];
}

/* Whether other shadows lie on both sides of a silhouette all along it, on all of the body. */
static int is_covered(const Shadows *all, int64_t edge) {
    double ends[2][3], reached = 0.0;
    int64_t spans = 0;
    ends_of(all->edge_plane + 12 * edge, ends);
    for (int64_t t = 0; t < all->triangles; t++)
        if (all->before[t] && overlap(&all->extent[t], &all->extent[all->triangles + edge]))
            spans += span_within(ends[0], ends[1], all->plane + 12 * t, all->spans[spans]);
    for (int farther = 1; farther && reached < 1.0;) {
        farther = 0;
        for (int64_t i = 0; i < spans; i++)
            if (all->spans[i][0] <= reached && all->spans[i][1] > reached) {
                reached = all->spans[i][1];
                farther = 1;
            }
    }
    return reached >= 1.0;
}

/* Whether light may end at an edge on the body. It meets no triangle that lies before all of it. */
static int is_bare(Shadows *all, int64_t edge) {
    int64_t silhouettes = all->edges - all->triangles;
    if (all->edge[edge] == UNKNOWN) {
        int covered = edge < silhouettes ? is_covered(all, edge) : all->before[edge - silhouettes];
        all->edge[edge] = covered ? COVERED : BARE;
    }
    return all->edge[edge] == BARE;
}

/* Puts those of all edges and shadows into `near` that may concern what lies between points (N, 3) at virtual positions. */
static void choose(Near *near, const double *points, int64_t count, Shadows *all) {
    Extent extent = extent_of(&all->view, points, count);
    near->edges = near->shadows = 0;
    for (int64_t t = 0; t < all->triangles; t++) {
        if (!overlap(&all->extent[t], &extent)) continue;
        near->extent[near->shadows] = all->extent[t];
        memcpy(near->plane + 12 * near->shadows, all->plane + 12 * t, 12 * sizeof *all->plane);
        memcpy(near->offset + 4 * near->shadows++, all->offset + 4 * t, 4 * sizeof *all->offset);
    }
    for (int64_t i = 0; i < all->edges; i++) {
        if (!overlap(&all->extent[all->triangles + i], &extent) || !is_bare(all, i)) continue;
        near->edge_extent[near->edges] = all->extent[all->triangles + i];
        memcpy(near->edge_plane + 12 * near->edges, all->edge_plane + 12 * i, 12 * sizeof *all->plane);
        memcpy(near->edge_offset + 4 * near->edges++, all->edge_offset + 4 * i, 4 * sizeof *all->offset);
    }
}

/* Whether a point at a virtual position lies in the shadow of any triangle. */
static int in_shadow(const View *view, const double *point, const Near *near) {
    Extent extent = extent_of(view, point, 1);
    for (int64_t t = 0; t < near->shadows; t++) {
        if (!overlap(&near->extent[t], &extent)) continue;
        int inside = 1;
        for (int k = 0; k < 4 && inside; k++) inside = dot(near->plane + 12 * t + 3 * k, point) >= near->offset[4 * t + k];
        if (inside) return 1;
    }
    return 0;
}

/* Which points (M, 3), M = count, at virtual positions lie in no shadow: planes (T, 4, 3) and offsets (T, 4), T = triangles. Returns
 * how many there are, NO_MEMORY without memory. */
/* Arrays: virtual (count, 3); plane (triangles, 4, 3); offset (triangles, 4); lit (count) */
KERNEL int64_t cast_lit(int64_t count, int64_t triangles, const double *virtual, const double *plane, const double *offset,
                        uint8_t *lit) {
    Shadows all = {.triangles = triangles, .plane = plane, .offset = offset};
    Near near = {0};
    int made = look(&all, &near, virtual, count);
    for (int64_t i = 0; i < count && made; i++) {
        if (i % TOGETHER == 0) choose(&near, virtual + 3 * i, fewer(TOGETHER, count - i), &all);
        lit[i] = !in_shadow(&all.view, virtual + 3 * i, &near);
    }
    release(&all, &near);
    return made ? count : NO_MEMORY;
}

/* Whether the first of four planes cuts a piece on the inner sides of the others; `value` (3): at its corners. */
static int crosses(const Piece *piece, const double *plane, const double *offset, double *value) {
    for (int k = 0; k < 4; k++) {
        double most = -INFINITY;
        for (int corner = 0; corner < 3; corner++) {
            double side = dot(plane + 3 * k, piece->at[corner] + 3) - offset[k];
            most = larger(most, side);
            if (!k) value[corner] = side;
        }
        if (!(most > ON_PLANE)) return 0;
    }
    return smaller(smaller(value[0], value[1]), value[2]) < -ON_PLANE;
}

/* Cuts piece `which` in three where `value` (3) changes its sign; those with a corner on the line in two, and a part without area.
 * Returns 0 without memory. */
static int divided(Pieces *all, int64_t which, double *value) {
    Piece *tip = added(all) ? added(all) : NULL;
    if (!tip) return 0;
    for (int corner = 0; corner < 3; corner++)
        if (fabs(value[corner]) < ON_PLANE) value[corner] = 0.0;
    int below = (value[0] < 0.0) + (value[1] < 0.0) + (value[2] < 0.0), single = 0;
    while ((value[single] < 0.0) != (below == 1)) single++;
    double whole[3][AXES], ab[AXES], ac[AXES], at[3];
    for (int corner = 0; corner < 3; corner++) {
        int from = (single + corner) % 3;
        memcpy(whole[corner], all->pieces[which].at[from], sizeof ab);
        at[corner] = value[from];
    }
    for (int axis = 0; axis < AXES; axis++) {
        ab[axis] = whole[0][axis] + at[0] / (at[0] - at[1]) * (whole[1][axis] - whole[0][axis]);
        ac[axis] = whole[0][axis] + at[0] / (at[0] - at[2]) * (whole[2][axis] - whole[0][axis]);
    }
    const double *parts[3][3] = {{whole[0], ab, ac}, {ab, whole[1], whole[2]}, {ab, whole[2], ac}};
    Piece *places[3] = {&all->pieces[which], tip - 1, tip};
    for (int part = 0; part < 3; part++)
        for (int corner = 0; corner < 3; corner++) memcpy(places[part]->at[corner], parts[part][corner], sizeof ab);
    return 1;
}

/* Puts a triangle, and every part of it that edges cut off, into `all`; returns 0 without memory. */
static int cut_up(Pieces *all, const double *corners, const double *virtual, const View *view, const Near *near) {
    Extent extent = extent_of(view, virtual, 3);
    double value[3];
    all->count = 0;
    Piece *whole = added(all);
    if (!whole) return 0;
    for (int corner = 0; corner < 3; corner++) {
        memcpy(whole->at[corner], corners + 3 * corner, sizeof value);
        memcpy(whole->at[corner] + 3, virtual + 3 * corner, sizeof value);
    }
    for (int64_t edge = 0; edge < near->edges; edge++) {
        const double *plane = near->edge_plane + 12 * edge, *offset = near->edge_offset + 4 * edge;
        if (!overlap(&near->edge_extent[edge], &extent)) continue;
        for (int64_t piece = all->count - 1; piece >= 0; piece--)
            if (crosses(&all->pieces[piece], plane, offset, value) && !divided(all, piece, value)) return 0;
    }
    return 1;
}

/* Whether a triangle at virtual positions (3, 3) lies in the shadow of one other as a whole. */
static int in_one_shadow(const View *view, const double *virtual, const Near *near) {
    Extent own = extent_of(view, virtual, 3);
    for (int64_t t = 0; t < near->shadows; t++) {
        const Extent *shadow = &near->extent[t];
        int inside = shadow->low[0] <= own.low[0] && own.high[0] <= shadow->high[0];
        inside &= shadow->low[1] <= own.low[1] && own.high[1] <= shadow->high[1];
        for (int k = 0; k < 4 && inside; k++)
            for (int corner = 0; corner < 3 && inside; corner++)
                inside = dot(near->plane + 12 * t + 3 * k, virtual + 3 * corner) >= near->offset[4 * t + k];
        if (inside) return 1;
    }
    return 0;
}

/* Finds which pieces lie in no shadow; returns how many. */
static int64_t light(Pieces *all, const View *view, const Near *near) {
    int64_t total = 0;
    for (int64_t i = 0; i < all->count; i++) {
        Piece *piece = &all->pieces[i];
        double middle[3];
        for (int axis = 0; axis < 3; axis++)
            middle[axis] = (piece->at[0][3 + axis] + piece->at[1][3 + axis] + piece->at[2][3 + axis]) / 3.0;
        piece->lit = !in_shadow(view, middle, near);
        total += piece->lit;
    }
    return total;
}

/* Which triangles (M, 3, 3), M = count, at virtual positions lie in the shadow of one triangle (T) as a whole: dark (M). Planes and
 * offsets as of `in_shadow`. Returns how many, NO_MEMORY without memory. */
/* Arrays: virtual (count, 3, 3); plane (triangles, 4, 3); offset (triangles, 4); dark (count) */
KERNEL int64_t cast_dark(int64_t count, int64_t triangles, const double *virtual, const double *plane, const double *offset,
                         uint8_t *dark) {
    Shadows all = {.triangles = triangles, .plane = plane, .offset = offset};
    Near near = {0};
    int64_t total = 0;
    int made = look(&all, &near, virtual, 3 * count);
    for (int64_t i = 0; i < count && made; i++) {
        if (i % TOGETHER == 0) choose(&near, virtual + 9 * i, 3 * fewer(TOGETHER, count - i), &all);
        dark[i] = (uint8_t)in_one_shadow(&all.view, virtual + 9 * i, &near);
        total += dark[i];
    }
    release(&all, &near);
    return made ? total : NO_MEMORY;
}

/* Cuts those triangles (M, 3, 3), M = count, on which shadows lie. Returns how many parts there are; the first `room` of them go to
 * parts (room, 3, 3), the triangle that each comes from, rising, to origin (room), and whether it is in the light to bright (room).
 *
 * corners, virtual: in the body's frame and at virtual positions. edge_plane (E, 4, 3), edge_offset (E, 4), E = edges: where shadows
 * may end, silhouettes and then the triangles' own planes. plane (T, 4, 3), offset (T, 4), T = triangles: of the shadows. */
/* Arrays: edges from triangles; corners, virtual (count, 3, 3); edge_plane (edges, 4, 3); edge_offset (edges, 4);
 * plane (triangles, 4, 3); offset (triangles, 4); parts (room, 3, 3); origin, bright (room) */
KERNEL int64_t cast_cuts(int64_t count, int64_t edges, int64_t triangles, int64_t room, const double *corners,
                         const double *virtual, const double *edge_plane, const double *edge_offset, const double *plane,
                         const double *offset, double *parts, int64_t *origin, uint8_t *bright) {
    Pieces all = {NULL, 0, 0};
    Shadows shadows = {.edges = edges, .triangles = triangles, .edge_plane = edge_plane, .edge_offset = edge_offset,
                       .plane = plane, .offset = offset};
    Near near = {0};
    int64_t total = 0;
    int failed = !look(&shadows, &near, virtual, 3 * count);
    for (int64_t i = 0; i < count && !failed; i++) {
        if (i % TOGETHER == 0) choose(&near, virtual + 9 * i, 3 * fewer(TOGETHER, count - i), &shadows);
        failed = !cut_up(&all, corners + 9 * i, virtual + 9 * i, &shadows.view, &near);
        int64_t lit = light(&all, &shadows.view, &near), pieces = lit == all.count ? 0 : lit ? all.count : 1;
        for (int64_t piece = 0; piece < pieces; piece++, total++) {
            if (total >= room) continue;
            for (int corner = 0; corner < 3; corner++)
                memcpy(parts + 9 * total + 3 * corner, lit ? all.pieces[piece].at[corner] : corners + 9 * i + 3 * corner,
                       3 * sizeof *parts);
            origin[total] = i;
            bright[total] = lit && all.pieces[piece].lit;
        }
    }
    free(all.pieces);
    release(&shadows, &near);
    return failed ? NO_MEMORY : total;
}
