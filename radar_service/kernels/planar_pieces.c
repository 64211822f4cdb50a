/* Convex planar pieces of a mesh: scattering/physical_optics/planar_pieces.py. Coplanar triangles that share edges are joined; the
 * outline of each patch, holes and all, is cut into triangles by ears (Meisters 1975), and these are joined where what they make is
 * convex (Hertel and Mehlhorn 1983). So pieces do not depend on how the mesh cuts its planes. Where that fails, a patch is left as
 * its triangles. All steps of a patch are counted, so none takes longer than WORK of them. */

#include "outlines.h"

/* Facets in the order in which they start patches: the largest first, of equal ones as they face. */
typedef struct {
    int64_t size, key[4];
    int32_t triangle;
} Seed;

static int by_rank(const void *first, const void *second) {
    const Seed *a = first, *b = second;
    if (a->size != b->size) return a->size > b->size ? -1 : 1;
    for (int i = 0; i < 4; i++)
        if (a->key[i] != b->key[i]) return a->key[i] < b->key[i] ? -1 : 1;
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

/* Whether all of a facet lies in a plane, nearly. */
static int lies_in(const Triangles *t, int32_t facet, Plane plane) {
    for (int32_t triangle = facet; triangle >= 0; triangle = t->beside[triangle]) {
        if (vdot(normal_of(t, triangle), plane.normal) < 1.0 - OFF_NORMAL * OFF_NORMAL / 2.0) return 0;
        for (int i = 0; i < 3; i++)
            if (fabs(height_over(plane, vertex(t, t->corner[3 * triangle + i]))) > OFF_PLANE) return 0;
    }
    return 1;
}

static int64_t add_facet(Triangles *t, int32_t facet, int32_t number, int32_t *members, int64_t count) {
    for (int32_t triangle = facet; triangle >= 0; triangle = t->beside[triangle]) {
        t->patch[triangle] = number;
        members[count++] = triangle;
    }
    return count;
}

/* Grows the patch of a facet by those that share an edge, lie in its plane and have the same side; returns how many triangles it
 * has. */
static int64_t grow_patch(Triangles *t, const int8_t *side, int32_t seed, int32_t number, int32_t *members) {
    Plane plane = {normal_of(t, seed), 0.0};
    plane.offset = vdot(plane.normal, vertex(t, t->corner[3 * seed]));
    int64_t count = add_facet(t, seed, number, members, 0);
    for (int64_t done = 0; done < count; done++) {
        int32_t triangle = members[done];
        for (int32_t e = 3 * triangle; e < 3 * triangle + 3; e++) {
            int32_t from = half_edge_from(t, e), to = half_edge_to(t, e), other = t->first[edge_place(t, from, to)];
            for (int shared = 0; other >= 0 && shared < SHARED; other = t->after[other]) {
                if (!same_edge(t, other, from, to)) continue;
                shared++;
                if (t->patch[other / 3] >= 0 || side[t->source[other / 3]] != side[t->source[seed]]) continue;
                int32_t facet = facet_of(t, other / 3);
                if (lies_in(t, facet, plane)) count = add_facet(t, facet, number, members, count);
            }
        }
    }
    return count;
}

/* What is made of a mesh. */
typedef struct {
    int64_t corner_room, piece_room, corners, pieces;
    double *corner;
    int64_t *first, *patch;
    double *normal;
    int8_t *side;
} Pieces;

/* Adds a piece with its normal; a flat one is left out. */
static void add_piece(Pieces *result, const Triangles *t, const int32_t *vertices, int n, int64_t patch, int8_t side) {
    Vec sum = vec(0.0, 0.0, 0.0);
    for (int k = 1; k + 1 < n; k++)
        sum = vadd(sum, vcross(vsub(vertex(t, vertices[k]), vertex(t, vertices[0])), vsub(vertex(t, vertices[k + 1]), vertex(t, vertices[0]))));
    double size = size_of(sum);
    if (!(size > 2.0 * LEAST) || result->pieces >= result->piece_room || result->corners + n > result->corner_room) return;
    for (int k = 0; k < n; k++) memcpy(result->corner + 3 * result->corners++, t->vertices + 3 * (int64_t)vertices[k], 3 * sizeof(double));
    double *normal = result->normal + 3 * result->pieces;
    normal[0] = sum.x / size;
    normal[1] = sum.y / size;
    normal[2] = sum.z / size;
    result->patch[result->pieces] = patch;
    result->side[result->pieces++] = side;
    result->first[result->pieces] = result->corners;
}

/* The pieces of a mesh: vertices (V, 3) [m], faces (F, 3), side (F) which side of each triangle is outside, 0 where both are.
 * Results: corner (3 F, 3) [m] counterclockwise about the triangles' winding, first (F + 1) of each piece and the end of the last,
 * normal (F, 3), patch (F) its number, side (F). Returns how many pieces there are, -1 without memory. */
/* Arrays: at (vertices, 3); face (faces, 3) < vertices; side (faces); corner (3 * faces, 3); first (faces + 1); normal (faces, 3);
 * patch, piece_side (faces) */
KERNEL int64_t planar_pieces(int64_t vertices, int64_t faces, const double *at, const int64_t *face, const int8_t *side,
                             double *corner, int64_t *first, double *normal, int64_t *patch, int8_t *piece_side) {
    Triangles t;
    Bench bench;
    memset(&bench, 0, sizeof bench);
    if (vertices > INT32_MAX / 4 || faces > INT32_MAX / 8) return NO_MEMORY;
    int sound = gather_triangles(&t, vertices, faces, at, face);
    Seed *seeds = malloc((size_t)(faces + 1) * sizeof *seeds);
    int32_t *members = malloc((size_t)(faces + 1) * sizeof *members);
    bench.out = malloc((size_t)(vertices + 1) * sizeof *bench.out);
    sound &= seeds && members && bench.out;
    Pieces result = {3 * faces, faces, 0, 0, corner, first, patch, normal, piece_side};
    int64_t facets = 0;
    if (sound) {
        first[0] = 0;
        find_facets(&t, side);
        for (int32_t i = 0; i < t.count; i++) {
            if (t.facet[i] != i) continue;
            Vec n = normal_of(&t, i);
            double whole = 0.0, offset = vdot(n, vertex(&t, t.corner[3 * i]));
            for (int32_t triangle = i; triangle >= 0; triangle = t.beside[triangle]) whole += t.area[triangle];
            Seed seed = {(int64_t)floor(log(whole) * 1e5 + 0.5), {(int64_t)floor(n.x * 1e5 + 0.5), (int64_t)floor(n.y * 1e5 + 0.5),
                         (int64_t)floor(n.z * 1e5 + 0.5), (int64_t)floor(offset * 1e4 + 0.5)}, i};
            seeds[facets++] = seed;
        }
        qsort(seeds, (size_t)facets, sizeof *seeds, by_rank);
    }
    int32_t number = 0;
    for (int64_t s = 0; sound && s < facets; s++) {
        if (t.patch[seeds[s].triangle] >= 0) continue;
        int64_t count = grow_patch(&t, side, seeds[s].triangle, number, members);
        int64_t made = count > 1 ? cut_patch(&t, members, count, &bench) : 0;
        int8_t outside = side[t.source[seeds[s].triangle]];
        if (made < 0) sound = 0;
        if (!made)
            for (int64_t m = 0; m < count; m++) add_piece(&result, &t, t.corner + 3 * members[m], 3, number, outside);
        for (int64_t p = 0; p < made; p++)
            if (bench.sizes[p]) add_piece(&result, &t, bench.pieces + p * PIECE_CORNERS, bench.sizes[p], number, outside);
        number++;
    }
    free_bench(&bench);
    free(seeds);
    free(members);
    free_triangles(&t);
    return sound ? result.pieces : NO_MEMORY;
}
