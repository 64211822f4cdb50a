/* Triangles of a body cut where shadows of others end on them: scattering/physical_optics/cast_shadows.py. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"

static const double ON_PLANE = 1e-6; /* m, of cast_shadows.py */
/* AXES: corners in the body's frame, then at virtual positions. TOGETHER: neighbouring triangles that are tested at once first. */
enum { NO_MEMORY = -1, AXES = 6, TOGETHER = 16 };

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

/* Whether a point at a virtual position lies in the shadow of any triangle (T): planes (T, 4, 3) and offsets (T, 4). */
static int in_shadow(const double *point, int64_t triangles, const double *plane, const double *offset) {
    for (int64_t t = 0; t < triangles; t++) {
        int inside = 1;
        for (int k = 0; k < 4 && inside; k++) inside = dot(plane + 12 * t + 3 * k, point) >= offset[4 * t + k];
        if (inside) return 1;
    }
    return 0;
}

/* Which points (M, 3), M = count, at virtual positions lie in no shadow. */
KERNEL int64_t cast_lit(int64_t count, int64_t triangles, const double *virtual, const double *plane, const double *offset,
                        uint8_t *lit) {
    for (int64_t i = 0; i < count; i++) lit[i] = !in_shadow(virtual + 3 * i, triangles, plane, offset);
    return count;
}

/* Whether the first of four planes may cut what lies within `radius` of a centre, on the inner sides of the others. */
static int may_cut(const double *centre, double radius, const double *plane, const double *offset) {
    if (!(fabs(dot(plane, centre) - offset[0]) < radius)) return 0;
    for (int k = 1; k < 4; k++)
        if (!(dot(plane + 3 * k, centre) - offset[k] > -radius)) return 0;
    return 1;
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

/* The middle of triangles (N, 3, 3), and a radius about it that holds them. */
static double sphere(const double *virtual, int64_t count, double *centre) {
    double radius = 0.0, way[3];
    for (int axis = 0; axis < 3; axis++) {
        centre[axis] = 0.0;
        for (int64_t corner = 0; corner < 3 * count; corner++) centre[axis] += virtual[3 * corner + axis];
        centre[axis] /= 3.0 * (double)count;
    }
    for (int64_t corner = 0; corner < 3 * count; corner++) {
        subtract(virtual + 3 * corner, centre, way);
        radius = larger(radius, dot(way, way));
    }
    return sqrt(radius);
}

/* What of the shadows concerns some neighbouring triangles: edges (E) that may cut one, and shadows (T) in which a part may lie. */
typedef struct {
    int64_t edges, shadows;
    double *edge_plane, *edge_offset, *plane, *offset;
} Near;

/* Makes room for all edges and shadows; returns 0 without memory. */
static int reserve(Near *near, int64_t edges, int64_t shadows) {
    double *room = malloc(16 * (size_t)(edges + shadows + 1) * sizeof *room);
    near->edge_plane = room;
    if (!room) return 0;
    near->edge_offset = room + 12 * edges;
    near->plane = near->edge_offset + 4 * edges;
    near->offset = near->plane + 12 * shadows;
    return 1;
}

/* Puts those of all edges and shadows into `near` that may concern the first TOGETHER triangles at virtual positions (M, 3, 3). */
static void choose(Near *near, const double *virtual, int64_t count, int64_t edges, const double *edge_plane,
                   const double *edge_offset, int64_t shadows, const double *plane, const double *offset) {
    double centre[3], radius = sphere(virtual, count < TOGETHER ? count : TOGETHER, centre) + ON_PLANE;
    near->edges = near->shadows = 0;
    for (int64_t i = 0; i < edges; i++)
        if (may_cut(centre, radius, edge_plane + 12 * i, edge_offset + 4 * i)) {
            memcpy(near->edge_plane + 12 * near->edges, edge_plane + 12 * i, 12 * sizeof *plane);
            memcpy(near->edge_offset + 4 * near->edges++, edge_offset + 4 * i, 4 * sizeof *plane);
        }
    for (int64_t i = 0; i < shadows; i++) {
        int may = 1;
        for (int k = 0; k < 4 && may; k++) may = dot(plane + 12 * i + 3 * k, centre) - offset[4 * i + k] >= -radius;
        if (!may) continue;
        memcpy(near->plane + 12 * near->shadows, plane + 12 * i, 12 * sizeof *plane);
        memcpy(near->offset + 4 * near->shadows++, offset + 4 * i, 4 * sizeof *plane);
    }
}

/* Puts a triangle, and every part of it that edges cut off, into `all`; returns 0 without memory. */
static int cut_up(Pieces *all, const double *corners, const double *virtual, const Near *near) {
    double centre[3], radius = sphere(virtual, 1, centre), value[3];
    all->count = 0;
    Piece *whole = added(all);
    if (!whole) return 0;
    for (int corner = 0; corner < 3; corner++) {
        memcpy(whole->at[corner], corners + 3 * corner, sizeof centre);
        memcpy(whole->at[corner] + 3, virtual + 3 * corner, sizeof centre);
    }
    for (int64_t edge = 0; edge < near->edges; edge++) {
        const double *plane = near->edge_plane + 12 * edge, *offset = near->edge_offset + 4 * edge;
        if (!may_cut(centre, radius, plane, offset)) continue;
        for (int64_t piece = all->count - 1; piece >= 0; piece--)
            if (crosses(&all->pieces[piece], plane, offset, value) && !divided(all, piece, value)) return 0;
    }
    return 1;
}

/* Whether a triangle at virtual positions (3, 3) lies in the shadow of one other as a whole. */
static int in_one_shadow(const double *virtual, const Near *near) {
    for (int64_t t = 0; t < near->shadows; t++) {
        int inside = 1;
        for (int k = 0; k < 4 && inside; k++)
            for (int corner = 0; corner < 3 && inside; corner++)
                inside = dot(near->plane + 12 * t + 3 * k, virtual + 3 * corner) >= near->offset[4 * t + k];
        if (inside) return 1;
    }
    return 0;
}

/* Finds which pieces lie in no shadow; returns how many. */
static int64_t light(Pieces *all, const Near *near) {
    int64_t total = 0;
    for (int64_t i = 0; i < all->count; i++) {
        Piece *piece = &all->pieces[i];
        double middle[3];
        for (int axis = 0; axis < 3; axis++)
            middle[axis] = (piece->at[0][3 + axis] + piece->at[1][3 + axis] + piece->at[2][3 + axis]) / 3.0;
        piece->lit = !in_shadow(middle, near->shadows, near->plane, near->offset);
        total += piece->lit;
    }
    return total;
}

/* Which triangles (M, 3, 3), M = count, at virtual positions lie in the shadow of one triangle (T) as a whole: dark (M). Planes and
 * offsets as of `in_shadow`. Returns how many, NO_MEMORY without memory. */
KERNEL int64_t cast_dark(int64_t count, int64_t triangles, const double *virtual, const double *plane, const double *offset,
                         uint8_t *dark) {
    Near near;
    int64_t total = 0;
    if (!reserve(&near, 0, triangles)) return NO_MEMORY;
    for (int64_t i = 0; i < count; i++) {
        if (i % TOGETHER == 0) choose(&near, virtual + 9 * i, count - i, 0, NULL, NULL, triangles, plane, offset);
        dark[i] = (uint8_t)in_one_shadow(virtual + 9 * i, &near);
        total += dark[i];
    }
    free(near.edge_plane);
    return total;
}

/* Cuts those triangles (M, 3, 3), M = count, on which shadows lie. Returns how many parts there are; the first `room` of them go to
 * parts (room, 3, 3), the triangle that each comes from, rising, to origin (room), and whether it is in the light to bright (room).
 *
 * corners, virtual: in the body's frame and at virtual positions. edge_plane (E, 4, 3), edge_offset (E, 4), E = edges: where shadows
 * may end. plane (T, 4, 3), offset (T, 4), T = triangles: of the shadows. */
KERNEL int64_t cast_cuts(int64_t count, int64_t edges, int64_t triangles, int64_t room, const double *corners,
                         const double *virtual, const double *edge_plane, const double *edge_offset, const double *plane,
                         const double *offset, double *parts, int64_t *origin, uint8_t *bright) {
    Pieces all = {NULL, 0, 0};
    Near near;
    int64_t total = 0;
    int failed = !reserve(&near, edges, triangles);
    for (int64_t i = 0; i < count && !failed; i++) {
        if (i % TOGETHER == 0)
            choose(&near, virtual + 9 * i, count - i, edges, edge_plane, edge_offset, triangles, plane, offset);
        failed = !cut_up(&all, corners + 9 * i, virtual + 9 * i, &near);
        int64_t lit = light(&all, &near), pieces = lit == all.count ? 0 : lit ? all.count : 1;
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
    free(near.edge_plane);
    return failed ? NO_MEMORY : total;
}
