/* Triangles of a mesh with their edges in a table: for planar_pieces.c. */

#ifndef MESH_EDGES_H
#define MESH_EDGES_H

#include "geometry.h"
#include "polygons.h"

static const double WELD = 0x1p-20;    /* m: vertices in one cell of this size are one */
static const double OFF_PLANE = 5e-4;  /* m, and */
static const double OFF_NORMAL = 2e-3; /* rad: by which triangles of a patch may be off its largest one */
static const double EXACT = 1e-6;      /* rad, of two triangles that a plane was cut into */
static const double STRAIGHT = 1e-5;   /* m: a corner of an outline that is less off the line of its neighbours is none */
static const double ALIKE = 1e-7;      /* m, and of a quality: what differs by less does by rounding, and the first counts */
static const double LEAST = 1e-12;     /* m^2: of a triangle that is dropped */
static const double SAME_AREA = 1e-5;  /* of it: what pieces of a patch may have more or less than its triangles */

enum { SHARED = 16, WORK = 50000000 }; /* triangles at one edge, above which it joins none; steps that a patch may take */

typedef struct {
    const double *vertices;
    int64_t count;   /* of triangles that are kept */
    int32_t *corner; /* (count, 3) welded vertices */
    int64_t *source; /* (count) triangle of the mesh */
    double *normal;  /* (count, 3) unit */
    double *area;    /* (count) twice */
    int32_t *after;  /* (3 count) the next half-edge between the same vertices, or -1 */
    int32_t *first;  /* hash table of half-edges */
    uint64_t mask;
    int32_t *patch; /* (count) */
    int32_t *facet; /* (count) first of those that lie in one plane exactly and are joined by edges */
    int32_t *beside; /* (count) the next of the same facet, or -1 */
} Triangles;

static inline uint64_t mixed(uint64_t x) { /* finalizer of splitmix64 (Steele, Lea, Flood 2014) */
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static uint64_t table_size(int64_t entries) {
    uint64_t size = 16;
    while (size < 2 * (uint64_t)entries) size *= 2;
    return size;
}

static inline Vec vertex(const Triangles *t, int32_t v) { return vec(t->vertices[3 * v], t->vertices[3 * v + 1], t->vertices[3 * v + 2]); }

static inline int64_t weld_cell(double coordinate) { /* whatever it is, also no number */
    return fabs(coordinate) < 1e12 ? (int64_t)floor(coordinate / WELD + 0.5) : INT64_MAX;
}

/* The first vertex (V) in the cell of each; 0 without memory. */
static int weld(int64_t count, const double *vertices, int32_t *representative) {
    uint64_t size = table_size(count);
    int32_t *table = malloc(size * sizeof *table);
    if (!table) return 0;
    for (uint64_t i = 0; i < size; i++) table[i] = -1;
    for (int64_t v = 0; v < count; v++) {
        int64_t key[3];
        for (int axis = 0; axis < 3; axis++) key[axis] = weld_cell(vertices[3 * v + axis]);
        uint64_t place = mixed((uint64_t)key[0] + mixed((uint64_t)key[1] + mixed((uint64_t)key[2])));
        for (place &= size - 1; table[place] >= 0; place = (place + 1) & (size - 1)) {
            const double *other = vertices + 3 * (int64_t)table[place];
            int same = 1;
            for (int axis = 0; axis < 3; axis++) same &= weld_cell(other[axis]) == key[axis];
            if (same) break;
        }
        if (table[place] < 0) table[place] = (int32_t)v;
        representative[v] = table[place];
    }
    free(table);
    return 1;
}

static inline int32_t half_edge_from(const Triangles *t, int32_t e) { return t->corner[e]; }

static inline int32_t half_edge_to(const Triangles *t, int32_t e) { return t->corner[e % 3 == 2 ? e - 2 : e + 1]; }

static inline uint64_t edge_place(const Triangles *t, int32_t a, int32_t b) {
    uint64_t low = (uint64_t)(a < b ? a : b), high = (uint64_t)(a < b ? b : a);
    return mixed(low << 32 | high) & t->mask;
}

static inline int same_edge(const Triangles *t, int32_t e, int32_t a, int32_t b) {
    int32_t from = half_edge_from(t, e), to = half_edge_to(t, e);
    return (from == a && to == b) || (from == b && to == a);
}

static inline Vec normal_of(const Triangles *t, int32_t triangle) {
    return vec(t->normal[3 * triangle], t->normal[3 * triangle + 1], t->normal[3 * triangle + 2]);
}

static void free_triangles(Triangles *t) {
    free(t->corner);
    free(t->source);
    free(t->normal);
    free(t->area);
    free(t->after);
    free(t->first);
    free(t->patch);
    free(t->facet);
    free(t->beside);
}

/* Whether a triangle with the same corners, the same way round, is among those at its first edge. */
static int is_repeated(const Triangles *t, int32_t triangle) {
    const int32_t *c = t->corner + 3 * triangle;
    int seen = 0;
    for (int32_t e = t->first[edge_place(t, c[0], c[1])]; e >= 0 && seen < SHARED; e = t->after[e]) {
        if (half_edge_from(t, e) != c[0] || half_edge_to(t, e) != c[1]) continue;
        int32_t third = t->corner[e - e % 3 + (e % 3 + 2) % 3];
        if (third == c[2]) return 1;
        seen++;
    }
    return 0;
}

/* The triangles that count, with their edges in a table; 0 without memory. */
static int gather_triangles(Triangles *t, int64_t vertices, int64_t faces, const double *at, const int64_t *face) {
    int32_t *representative = malloc((size_t)(vertices + 1) * sizeof *representative);
    uint64_t size = table_size(3 * faces / 2);
    memset(t, 0, sizeof *t);
    t->vertices = at;
    t->mask = size - 1;
    t->corner = malloc((size_t)(3 * faces + 1) * sizeof *t->corner);
    t->source = malloc((size_t)(faces + 1) * sizeof *t->source);
    t->normal = malloc((size_t)(3 * faces + 1) * sizeof *t->normal);
    t->area = malloc((size_t)(faces + 1) * sizeof *t->area);
    t->after = malloc((size_t)(3 * faces + 1) * sizeof *t->after);
    t->patch = malloc((size_t)(faces + 1) * sizeof *t->patch);
    t->facet = malloc((size_t)(faces + 1) * sizeof *t->facet);
    t->beside = malloc((size_t)(faces + 1) * sizeof *t->beside);
    t->first = malloc(size * sizeof *t->first);
    int sound = representative && t->corner && t->source && t->normal && t->area && t->after && t->patch && t->facet && t->beside && t->first &&
                weld(vertices, at, representative);
    for (uint64_t i = 0; sound && i < size; i++) t->first[i] = -1;
    for (int64_t f = 0; sound && f < faces; f++) {
        int32_t here = (int32_t)t->count, *c = t->corner + 3 * here;
        for (int i = 0; i < 3; i++) c[i] = representative[face[3 * f + i]];
        Vec across = vcross(vsub(vertex(t, c[1]), vertex(t, c[0])), vsub(vertex(t, c[2]), vertex(t, c[0])));
        double twice = size_of(across);
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0] || !(twice > 2.0 * LEAST) || is_repeated(t, here)) continue;
        for (int32_t e = 3 * here; e < 3 * here + 3; e++) {
            int32_t *head = t->first + edge_place(t, half_edge_from(t, e), half_edge_to(t, e));
            t->after[e] = *head;
            *head = e;
        }
        t->source[here] = f;
        t->area[here] = twice;
        t->patch[here] = -1;
        t->normal[3 * here] = across.x / twice;
        t->normal[3 * here + 1] = across.y / twice;
        t->normal[3 * here + 2] = across.z / twice;
        t->count++;
    }
    free(representative);
    return sound;
}

static int32_t facet_of(Triangles *t, int32_t triangle) {
    int32_t *facet = t->facet;
    while (facet[triangle] != triangle) triangle = facet[triangle] = facet[facet[triangle]];
    return triangle;
}

/* Finds facets, which are what the mesh's planes are whatever triangles they are cut into; `area` of the first triangle of each
 * becomes that of the whole. */
static void find_facets(Triangles *t, const int8_t *side) {
    for (int32_t i = 0; i < t->count; i++) t->facet[i] = i;
    for (int32_t e = 0; e < 3 * t->count; e++) {
        int32_t from = half_edge_from(t, e), to = half_edge_to(t, e), seen = 0;
        for (int32_t other = t->after[e]; other >= 0 && seen < SHARED; other = t->after[other]) {
            if (!same_edge(t, other, from, to)) continue;
            seen++;
            Vec across = vcross(normal_of(t, e / 3), normal_of(t, other / 3));
            int alike = vdot(normal_of(t, e / 3), normal_of(t, other / 3)) > 0.0 && vdot(across, across) < EXACT * EXACT;
            if (!alike || side[t->source[e / 3]] != side[t->source[other / 3]]) continue;
            int32_t one = facet_of(t, e / 3), two = facet_of(t, other / 3);
            t->facet[one > two ? one : two] = one < two ? one : two;
        }
    }
    for (int32_t i = (int32_t)t->count - 1; i >= 0; i--) t->beside[i] = -1;
    for (int32_t i = (int32_t)t->count - 1; i >= 0; i--) {
        int32_t first = facet_of(t, i);
        if (first == i) continue;
        t->beside[i] = t->beside[first];
        t->beside[first] = i;
    }
}

#endif
