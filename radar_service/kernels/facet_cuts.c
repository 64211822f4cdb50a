/* Triangles cut until they are small enough, and points that several of them share: scattering/physical_optics/facets.py and
 * body_facets.py. Triangles are (M, 3, 3), by corner and axis [m]. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"

static const double FINEST = 32768.0; /* times shorter than a triangle's edge: a thousand million parts */
enum { DEEPEST = 128 }; /* halvings in a row: each shortens the longest edge by 0.87 or more in the end */

/* The longest edge of a triangle, from corner i to i + 1, the first one of equal ones; `length`: its length. */
static int longest_edge(double corners[3][3], double *length) {
    int result = 0;
    *length = -1.0;
    for (int i = 0; i < 3; i++) {
        double way[3];
        subtract(corners[(i + 1) % 3], corners[i], way);
        double own = sqrt(dot(way, way));
        if (own > *length) {
            *length = own;
            result = i;
        }
    }
    return result;
}

/* Halves triangles (F, 3, 3), F = count, across their longest edge until none exceeds `longest` (F). Returns how many parts there
 * are; the first `room` of them, and the triangle that each comes from, rising, go to parts (room, 3, 3) and origin (room). */
/* Arrays: corners (count, 3, 3); longest (count); parts (room, 3, 3); origin (room) */
KERNEL int64_t cut_triangles(int64_t count, int64_t room, const double *corners, const double *longest, double *parts,
                             int64_t *origin) {
    double stack[DEEPEST + 2][3][3];
    int64_t total = 0;
    for (int64_t i = 0; i < count; i++) {
        int depth = 1;
        memcpy(stack[0], corners + 9 * i, sizeof stack[0]);
        while (depth) {
            double(*top)[3] = stack[depth - 1], (*next)[3] = stack[depth], length, middle[3], turned[3][3];
            int edge = longest_edge(top, &length);
            if (depth == 1 && !(length <= FINEST * longest[i])) return REFUSED;
            if (length <= longest[i] || depth > DEEPEST) {
                if (total < room) {
                    memcpy(parts + 9 * total, top, sizeof stack[0]);
                    origin[total] = i;
                }
                total++;
                depth--;
                continue;
            }
            for (int corner = 0; corner < 3; corner++) memcpy(turned[corner], top[(edge + corner) % 3], sizeof turned[0]);
            for (int axis = 0; axis < 3; axis++) middle[axis] = (turned[0][axis] + turned[1][axis]) / 2.0;
            memcpy(next[0], turned[0], sizeof middle);
            memcpy(next[1], middle, sizeof middle);
            memcpy(next[2], turned[2], sizeof middle);
            memcpy(top[0], middle, sizeof middle);
            memcpy(top[1], turned[1], sizeof middle);
            memcpy(top[2], turned[2], sizeof middle);
            depth++;
        }
    }
    return total;
}

static uint64_t mixed_bits(const double *point) {
    uint64_t result = 0, bits[3];
    memcpy(bits, point, sizeof bits);
    for (int axis = 0; axis < 3; axis++) {
        result ^= bits[axis];
        result ^= result >> 32;
        result *= UINT64_C(0x9E3779B97F4A7C15); /* odd, its bits look drawn */
        result ^= result >> 29;
    }
    return result;
}

/* Points that corners of triangles (M, 3, 3), M = count, share, each once: points (up to 3 M, 3) in the order in which they occur,
 * and the number of each corner (3, M). Corners are the same where all their bits are. Returns how many points there are. */
/* Arrays: corners (count, 3, 3); number (3, count); points (3 * count + 1, 3) */
KERNEL int64_t welded(int64_t count, const double *corners, int64_t *number, double *points) {
    uint64_t size = 16;
    int64_t used = 0;
    while (size < 6 * (uint64_t)count) size *= 2;
    int64_t *table = malloc(size * sizeof *table);
    if (!table) return NO_MEMORY;
    memset(table, -1, size * sizeof *table);
    for (int corner = 0; corner < 3; corner++)
        for (int64_t i = 0; i < count; i++) {
            double *point = points + 3 * used;
            for (int axis = 0; axis < 3; axis++) point[axis] = corners[9 * i + 3 * corner + axis] + 0.0; /* -0 becomes 0 */
            uint64_t slot = mixed_bits(point) & (size - 1);
            while (table[slot] >= 0 && memcmp(points + 3 * table[slot], point, 3 * sizeof *point)) slot = (slot + 1) & (size - 1);
            if (table[slot] < 0) table[slot] = used++;
            number[corner * count + i] = table[slot];
        }
    free(table);
    return used;
}

/* Which facets (M), M = count, have no corner in the water: dry (M), and which the waterline crosses: crossed (M). corner (3, M):
 * of each in points (V, 3) [m]; level: height below which points are wet [m]. Returns how many are dry; how many are crossed goes
 * to crossings (1). */
/* Arrays: points (V, 3); corner (3, count) < V; dry, crossed (count); crossings (1) */
KERNEL int64_t dry_facets(int64_t count, const double *points, const int64_t *corner, double level, int64_t *dry,
                          int64_t *crossed, int64_t *crossings) {
    int64_t total = 0, cut = 0;
    for (int64_t i = 0; i < count; i++) {
        int wet = 0;
        for (int c = 0; c < 3; c++) wet += points[3 * corner[c * count + i] + 2] < level;
        if (!wet) dry[total++] = i;
        else if (wet < 3) crossed[cut++] = i;
    }
    *crossings = cut;
    return total;
}

/* Numbers those below `size` that occur among indices (count): used (size), rising, of which as many count as are returned, and which
 * of them each index is (count). place (size): room to work in. */
/* Arrays: index (count) < size; number (count); place, used (size) */
KERNEL int64_t renumbered(int64_t count, int64_t size, const int64_t *index, int64_t *place, int64_t *used, int64_t *number) {
    int64_t total = 0;
    memset(place, 0, (size_t)size * sizeof *place);
    for (int64_t i = 0; i < count; i++) place[index[i]] = 1;
    for (int64_t i = 0; i < size; i++)
        if (place[i]) {
            used[total] = i;
            place[i] = total++;
        }
    for (int64_t i = 0; i < count; i++) number[i] = place[index[i]];
    return total;
}
