/* Convex polygons in space, cut by planes: what planar_pieces.c makes and plane_echoes.c lights. */

#ifndef POLYGONS_H
#define POLYGONS_H

#include "geometry.h"
#include <stdlib.h>
#include <string.h>

enum {
    PIECE_CORNERS = 12, /* of a piece of a mesh, at most */
    MOST = 56,          /* of a region: a piece, the water, two planes and the 31 edges of a beam's window leave 47 at most */
};

static const double THIN = 1e-7;   /* m: what reaches no further across a plane is on neither side of it */
static const double SPECK = 1e-7;  /* m^2: of a region that is dropped */

typedef struct {
    double x, y, z;
} Vec;

static inline Vec vec(double x, double y, double z) {
    Vec result = {x, y, z};
    return result;
}

static inline Vec vsub(Vec a, Vec b) { return vec(a.x - b.x, a.y - b.y, a.z - b.z); }

static inline Vec vadd(Vec a, Vec b) { return vec(a.x + b.x, a.y + b.y, a.z + b.z); }

static inline Vec vscale(Vec a, double s) { return vec(a.x * s, a.y * s, a.z * s); }

static inline double vdot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline Vec vcross(Vec a, Vec b) { return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }

static inline double size_of(Vec a) { return sqrt(vdot(a, a)); }

static inline Vec unit_of(Vec a) { return vscale(a, 1.0 / size_of(a)); }

typedef struct {
    Vec normal;
    double offset; /* of points r in it: normal . r */
} Plane;

static inline double height_over(Plane plane, Vec point) { return vdot(plane.normal, point) - plane.offset; }

static inline Vec mirrored(Vec point, Plane plane) { return vsub(point, vscale(plane.normal, 2.0 * height_over(plane, point))); }

static inline Vec reflected(Vec direction, Vec normal) { return vsub(direction, vscale(normal, 2.0 * vdot(normal, direction))); }

typedef struct {
    int n;
    Vec at[MOST];
} Polygon;

static inline void copy_polygon(Polygon *to, const Polygon *from) {
    to->n = from->n;
    memcpy(to->at, from->at, (size_t)from->n * sizeof(Vec));
}

static inline Vec middle_of(const Polygon *p) {
    Vec sum = vec(0.0, 0.0, 0.0);
    for (int i = 0; i < p->n; i++) sum = vadd(sum, p->at[i]);
    return vscale(sum, 1.0 / p->n);
}

static inline double area_of(const Polygon *p) {
    Vec sum = vec(0.0, 0.0, 0.0);
    for (int i = 1; i + 1 < p->n; i++) sum = vadd(sum, vcross(vsub(p->at[i], p->at[0]), vsub(p->at[i + 1], p->at[0])));
    return 0.5 * size_of(sum);
}

enum { NOTHING = 0, PART = 1, ALL = 2 };

/* Which part of a polygon, of at most MOST - 1 corners, has positive heights (n) over a plane. Where it is a part, `above` and
 * `below` become both parts; either may be NULL. */
static inline int cut_polygon(const Polygon *p, const double *height, Polygon *above, Polygon *below) {
    int any_above = 0, any_below = 0, up = 0, down = 0, crossings = 0;
    for (int i = 0; i < p->n; i++) {
        any_above |= height[i] > THIN;
        any_below |= height[i] < -THIN;
    }
    if (!any_above) return NOTHING;
    if (!any_below) return ALL;
    for (int i = 0; i < p->n; i++) {
        int next = i + 1 == p->n ? 0 : i + 1;
        double here = height[i], there = height[next];
        if (above && here >= -THIN) above->at[up++] = p->at[i];
        if (below && here <= THIN) below->at[down++] = p->at[i];
        if (((here > THIN && there < -THIN) || (here < -THIN && there > THIN)) && crossings++ < 2) { /* more: it is not convex */
            Vec crossing = vadd(p->at[i], vscale(vsub(p->at[next], p->at[i]), here / (here - there)));
            if (above) above->at[up++] = crossing;
            if (below) below->at[down++] = crossing;
        }
    }
    if (above) above->n = up;
    if (below) below->n = down;
    return PART;
}

static inline void heights_over(Plane plane, const Polygon *p, double *height) {
    for (int i = 0; i < p->n; i++) height[i] = height_over(plane, p->at[i]);
}

/* Keeps of a polygon what lies before a plane; returns whether anything does. */
static inline int keep_before(Polygon *p, Plane plane) {
    double height[MOST];
    Polygon kept;
    if (p->n >= MOST) return p->n > 2; /* cannot be, as MOST says; then it is left whole */
    heights_over(plane, p, height);
    int part = cut_polygon(p, height, &kept, NULL);
    if (part == PART) copy_polygon(p, &kept);
    return part != NOTHING && p->n > 2;
}

/* Convex polygons, as many as memory holds. */
typedef struct {
    Polygon *at;
    int64_t n, room, work; /* work: cuts that were tried so far */
    int failed;
} Regions;

static inline Polygon *new_region(Regions *list) {
    if (list->n == list->room) {
        int64_t room = list->room ? 2 * list->room : 16;
        Polygon *larger_list = realloc(list->at, (size_t)room * sizeof(Polygon));
        if (!larger_list) {
            list->failed = 1;
            return NULL;
        }
        list->at = larger_list;
        list->room = room;
    }
    return list->at + list->n++;
}

static inline void add_region(Regions *list, const Polygon *p) {
    Polygon *region = new_region(list);
    if (region) copy_polygon(region, p);
}

static inline void copy_regions(Regions *to, const Regions *from) {
    to->n = 0;
    to->failed |= from->failed;
    for (int64_t i = 0; i < from->n; i++) add_region(to, from->at + i);
}

/* Cuts the last region off in two where its corners would not hold what `planes` more cuts may add. */
static inline void halve_if_large(Regions *list, int64_t which, int planes) {
    while (list->at[which].n > MOST - 1 - planes && list->at[which].n > 3) {
        Polygon other, *p = list->at + which;
        int half = p->n / 2;
        other.n = 0;
        for (int i = half; i < p->n; i++) other.at[other.n++] = p->at[i];
        other.at[other.n++] = p->at[0];
        p->n = half + 1;
        add_region(list, &other);
        if (list->failed) return;
    }
}

#endif
