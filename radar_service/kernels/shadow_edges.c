/* Facets cut along the edges of shadows: what `visible_parts` of scattering/physical_optics/shadow_edges.py does but for the search for the
 * edges. Triangles are (M, 3, 3), by corner and axis [m]. */

#include "geometry.h"

static const double INSET = 0.002, ALIKE = 1e-6; /* of the same names in Python */

/* The corner of a facet that alone is visible, or alone is not; -1 where all three are alike. */
static int alone(const uint8_t *flags) {
    int seen = flags[0] + flags[1] + flags[2];
    if (seen % 3 == 0) return -1;
    return flags[0] == (seen == 1) ? 0 : flags[1] == (seen == 1) ? 1 : 2;
}

/* The facets (K), K = count, of whose corners two differ from the third. corners (K, 3, 3); flags (K, S), S = samples: which samples
 * are visible, those at the corners first. Returns their number N; the first N rows are of them: which (K), tip (K): whether the
 * third corner is visible; begin, end (2 K, 3): of the two edges from there, a little inside. */
/* Arrays: samples from 3; corners (count, 3, 3); flags (count, samples); which, tip (count); begin, end (2 * count, 3) */
KERNEL int64_t shadow_tips(int64_t count, int64_t samples, const double *corners, const uint8_t *flags, int64_t *which,
                           uint8_t *tip, double *begin, double *end) {
    int64_t odd = 0;
    for (int64_t i = 0; i < count; i++) {
        int first = alone(flags + i * samples);
        if (first < 0) continue;
        const double *at[3];
        double inset[3][3];
        for (int corner = 0; corner < 3; corner++) at[corner] = corners + 9 * i + 3 * ((first + corner) % 3);
        for (int axis = 0; axis < 3; axis++) {
            double centre = (at[0][axis] + at[1][axis] + at[2][axis]) / 3.0;
            for (int corner = 0; corner < 3; corner++) inset[corner][axis] = at[corner][axis] + INSET * (centre - at[corner][axis]);
        }
        which[odd] = i;
        tip[odd] = flags[i * samples + first];
        for (int edge = 0; edge < 2; edge++)
            for (int axis = 0; axis < 3; axis++) {
                begin[3 * (2 * odd + edge) + axis] = inset[0][axis];
                end[3 * (2 * odd + edge) + axis] = inset[1 + edge][axis];
            }
        odd++;
    }
    return odd;
}

/* Whether all samples of a facet lie on the correct side of a line, those within a hundredth of it on either: `_explains`. */
static int explains(int64_t samples, const double *lattice, const uint8_t *flags, int first, uint8_t tip, const double *line) {
    for (int64_t s = 0; s < samples; s++) {
        double reach = lattice[3 * s + (first + 1) % 3] / larger(line[0], 1e-9) + lattice[3 * s + (first + 2) % 3] / larger(line[1], 1e-9);
        int near = fabs(reach - 1.0) * smaller(line[0], line[1]) < 0.01;
        if (!near && (reach < 1.0) != (flags[s] == tip)) return 0;
    }
    return 1;
}

/* `line_through` of tests/reference/tube_witness.py. */
static void line_through(const double *crossing, double *line) {
    double third = INSET / 3.0, x = third + (1.0 - INSET) * crossing[0], y = third + (1.0 - INSET) * crossing[1];
    double along = x * y - third * third;
    line[0] = smaller(larger(along / larger(y - third, 1e-9), 1e-9), 1.0);
    line[1] = smaller(larger(along / larger(x - third, 1e-9), 1e-9), 1.0);
}

static void put(double *parts, int64_t row, const double *a, const double *b, const double *c) {
    for (int axis = 0; axis < 3; axis++) {
        parts[9 * row + axis] = a[axis];
        parts[9 * row + 3 + axis] = b[axis];
        parts[9 * row + 6 + axis] = c[axis];
    }
}

/* Cuts facets (K), K = count, along lines, N = odd of them as `shadow_tips` found them. lattice (S, 3): barycentric coordinates of
 * the samples; crossing (N, 2): where the edge of the shadow crosses the two edges of the smaller triangle, shares of these. The
 * last three are changed.
 *
 * Returns how many facets E a line explains. The first 3 E rows of parts (3 N, 3, 3), origin and share (3 N) are theirs: the facet
 * that each part comes from, and whether it is visible. Of the others (R = K - E): halves (2 R, 3, 3) and rest (R), which they are. */
/* Arrays: samples from 3; corners (count, 3, 3); flags (count, samples); lattice (samples, 3); which (odd) < count; tip (odd);
 * crossing (odd, 2); parts (3 * odd, 3, 3); origin, share (3 * odd); halves (2 * count, 3, 3); rest (count) */
KERNEL int64_t shadow_cuts(int64_t count, int64_t samples, int64_t odd, const double *corners, const uint8_t *flags,
                           const double *lattice, int64_t *which, uint8_t *tip, double *crossing, double *parts,
                           int64_t *origin, double *share, double *halves, int64_t *rest) {
    int64_t explained = 0, left = 0;
    for (int64_t i = 0; i < odd; i++) {
        const uint8_t *of_facet = flags + which[i] * samples;
        double line[2];
        line_through(crossing + 2 * i, line);
        if (alone(of_facet) < 0) return REFUSED;
        if (!explains(samples, lattice, of_facet, alone(of_facet), tip[i], line)) continue;
        which[explained] = which[i];
        tip[explained] = tip[i];
        crossing[2 * explained] = line[0];
        crossing[2 * explained + 1] = line[1];
        explained++;
    }
    for (int64_t i = 0, next = 0; i < count; i++) {
        if (next < explained && which[next] == i)
            next++;
        else
            rest[left++] = i;
    }
    for (int64_t row = 0; row < explained; row++) {
        int64_t facet = which[row];
        int first = alone(flags + facet * samples);
        const double *at[3];
        double ends[2][3];
        for (int corner = 0; corner < 3; corner++) at[corner] = corners + 9 * facet + 3 * ((first + corner) % 3);
        for (int edge = 0; edge < 2; edge++)
            for (int axis = 0; axis < 3; axis++)
                ends[edge][axis] = at[0][axis] + crossing[2 * row + edge] * (at[1 + edge][axis] - at[0][axis]);
        put(parts, row, at[0], ends[0], ends[1]);
        put(parts, explained + row, ends[0], at[1], at[2]);
        put(parts, 2 * explained + row, ends[0], at[2], ends[1]);
        share[row] = tip[row];
        share[explained + row] = share[2 * explained + row] = !tip[row];
        origin[row] = origin[explained + row] = origin[2 * explained + row] = facet;
    }
    for (int64_t i = 0; i < left; i++) {
        const double *at = corners + 9 * rest[i];
        double edges[3], middle[3], way[3];
        for (int corner = 0; corner < 3; corner++) {
            subtract(at + 3 * ((corner + 1) % 3), at + 3 * corner, way);
            edges[corner] = dot(way, way);
        }
        double limit = (1.0 - ALIKE) * larger(larger(edges[0], edges[1]), larger(edges[2], 0.0));
        int edge = edges[0] >= limit ? 0 : edges[1] >= limit ? 1 : 2;
        const double *a = at + 3 * edge, *b = at + 3 * ((edge + 1) % 3), *c = at + 3 * ((edge + 2) % 3);
        for (int axis = 0; axis < 3; axis++) middle[axis] = (a[axis] + b[axis]) / 2.0;
        put(halves, i, a, middle, c);
        put(halves, left + i, middle, b, c);
    }
    return explained;
}
