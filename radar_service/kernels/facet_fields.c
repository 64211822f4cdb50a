/* Fields of facets, for scattering/physical_optics/path_fields.py and illumination.py. */

#include "geometry.h"
#include "triangle_means.h"

/* exp(j phase) of phases (M) [rad], M = count. */
/* Arrays: phase, result (count) */
KERNEL int64_t phasors(int64_t count, const double *phase, Complex *result) {
    for (int64_t i = 0; i < count; i++) result[i] = phasor(phase[i]);
    return count;
}

/* The shapes of facets (M), M = count: corner (3, M) index of each corner in points (V, 3) [m]. Results: edges (3, 3, M), by axis
 * and opposite corner, centre (M, 3) [m], area (M) [m^2]. */
/* Arrays: points (V, 3); corner (3, count) < V; edges (3, 3, count); centre (count, 3); area (count) */
KERNEL int64_t facet_shapes(int64_t count, const double *points, const int64_t *corner, double *edges, double *centre,
                            double *area) {
    for (int64_t i = 0; i < count; i++) {
        const double *at[3];
        double edge[3][3], across[3];
        for (int c = 0; c < 3; c++) at[c] = points + 3 * corner[c * count + i];
        for (int c = 0; c < 3; c++) subtract(at[(c + 1) % 3], at[(c + 2) % 3], edge[c]);
        cross(edge[0], edge[1], across);
        area[i] = sqrt(dot(across, across)) / 2.0;
        for (int axis = 0; axis < 3; axis++) {
            centre[3 * i + axis] = (at[0][axis] + at[1][axis] + at[2][axis]) / 3.0;
            for (int c = 0; c < 3; c++) edges[(3 * axis + c) * count + i] = edge[c][axis];
        }
    }
    return count;
}

/* `LegRays.sags` of edges (3, N, M), M = count, N = vectors: result (N, M). */
/* Arrays: edge (3, vectors, count); east, north, rise, flat, length, curvature (count); result (vectors, count) */
KERNEL int64_t sags(int64_t count, int64_t vectors, const double *edge, const double *east, const double *north, const double *rise,
                    const double *flat, const double *length, const double *curvature, double *result) {
    int64_t axis = vectors * count;
    for (int64_t v = 0; v < vectors; v++)
        for (int64_t i = 0; i < count; i++) {
            const double *at = edge + v * count + i;
            double x = at[0], y = at[axis], z = at[2 * axis];
            double level = x * north[i] - y * east[i];
            double upright = z * flat[i] - (x * east[i] + y * north[i]) * rise[i];
            result[v * count + i] = -0.5 * (level * level / length[i] + upright * upright * curvature[i]);
        }
    return count;
}

/* (p . d)(n . E) - (p . E)(n . d) of a facet from a leg into another: `_current`. Rays: east, north, rise, flat. */
static inline double current(const double out[4], const double back[4], const double normal[3], int64_t level) {
    double beside = back[1] * out[0] - back[0] * out[1], alike = out[0] * back[0] + out[1] * back[1];
    double plane = normal[0] * out[0] + normal[1] * out[1], facing = plane * out[3] + normal[2] * out[2];
    if (level) return beside * out[3] * (normal[0] * out[1] - normal[1] * out[0]) - alike * facing;
    double along = back[3] * out[2] - back[2] * out[3] * alike, same = back[2] * out[2] * alike + back[3] * out[3];
    return along * (normal[2] * out[3] - plane * out[2]) - same * facing;
}

/* What facets (M), M = count, scatter from leg `out` into leg `back`, and the other way round where they differ, added to `total`
 * (V) at their points, without the factor of the current.
 *
 * legs: L; level: whether the polarization is "h". corner, normal (3, M), area (M) [m^2], side, share (M, L): as of `LitFacets`.
 * Of either leg: east, north, rise, flat, length (M) at the centroids; bend (3, M) [rad]; phase [rad], at (exp(j phase)), way [m]
 * (V) at the points. */
/* Arrays: out, back < legs; corner (3, count) < V; normal, bend, back_bend (3, count); area (count); side, share (count, legs);
 * east, north, rise, flat, length, back_east, back_north, back_rise, back_flat, back_length (count);
 * phase, at, way, back_phase, back_at, back_way, total (V) */
KERNEL int64_t facet_fields(int64_t count, int64_t legs, int64_t out, int64_t back, int64_t level, const int64_t *corner,
                            const double *normal, const double *area, const int8_t *side, const double *share, const double *east,
                            const double *north, const double *rise, const double *flat, const double *length,
                            const double *bend, const double *phase, const Complex *at, const double *way,
                            const double *back_east, const double *back_north, const double *back_rise,
                            const double *back_flat, const double *back_length, const double *back_bend,
                            const double *back_phase, const Complex *back_at, const double *back_way, Complex *total) {
    for (int64_t i = 0; i < count; i++) {
        double visible = share[i * legs + out] * (back != out ? share[i * legs + back] : 1.0);
        if (!(visible > 0.0) || side[i * legs + out] != side[i * legs + back]) continue;
        double ray[4] = {east[i], north[i], rise[i], flat[i]};
        double ray_back[4] = {back_east[i], back_north[i], back_rise[i], back_flat[i]};
        double facing[3] = {normal[i], normal[count + i], normal[2 * count + i]};
        double strength = current(ray, ray_back, facing, level);
        if (back != out) strength += current(ray_back, ray, facing, level);
        strength *= area[i] * visible * side[i * legs + out];
        double unordered[3], phases[3], bends[3];
        int64_t points[3];
        Complex at_corner[3], means[3];
        for (int c = 0; c < 3; c++) {
            int64_t point = corner[c * count + i];
            unordered[c] = phase[point] + back_phase[point];
        }
        int first = first_corner(unordered);
        for (int c = 0; c < 3; c++) {
            int from = (first + c) % 3;
            points[c] = corner[from * count + i];
            phases[c] = unordered[from];
            bends[c] = bend[from * count + i] + back_bend[from * count + i];
            at_corner[c] = times(at[points[c]], back_at[points[c]]);
        }
        ordered_means(phases, at_corner, bends, means);
        for (int c = 0; c < 3; c++) {
            double spreading = (way[points[c]] / length[i] - 1.0) + (back_way[points[c]] / back_length[i] - 1.0);
            total[points[c]] = plus(total[points[c]], scaled(means[c], (1.0 - 0.5 * spreading) * strength));
        }
    }
    return count;
}
