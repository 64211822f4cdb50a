/* What ray tubes scatter into a leg that they all reach: `received_fields` of scattering/physical_optics/path_fields.py. Vectors
 * stand by axis, (3, M). */

#include "geometry.h"
#include "triangle_means.h"

static inline void column(const double *vectors, int64_t count, int64_t i, double *result) {
    for (int axis = 0; axis < 3; axis++) result[axis] = vectors[axis * count + i];
}

/* How much longer a way is to a point at an offset [m]. */
static inline double spherical(const double *offset, const double *direction, double length) {
    double along = dot(offset, direction);
    return along + (dot(offset, offset) - along * along) / (2.0 * length);
}

/* The mean of the phasors of a tube and of its ray back over its footprint, 1 at its centre: as of `tube_fields` in tests/reference/kernel_witnesses.py.
 * frame: direction, then of the ray back direction, level, upright. */
static inline Complex mean_phasor(double corners[3][3], const double *centre, double frame[4][3], double length,
                                  double back_length, double curvature, double wavenumber) {
    double phases[3], bends[3], offset[3][3];
    for (int c = 0; c < 3; c++) subtract(corners[c], centre, offset[c]);
    for (int c = 0; c < 3; c++) {
        double edge[3];
        subtract(offset[(c + 1) % 3], offset[(c + 2) % 3], edge);
        for (int whole = 0; whole < 2; whole++) {
            const double *vector = whole ? edge : offset[c];
            double along = dot(vector, frame[0]), level = dot(vector, frame[2]), upright = dot(vector, frame[3]);
            double bent = (dot(vector, vector) - along * along) / length + level * level / back_length +
                          upright * upright * curvature;
            if (whole)
                bends[c] = wavenumber / 8.0 * bent;
            else
                phases[c] = -wavenumber * (along + dot(vector, frame[1]) + bent / 2.0);
        }
    }
    double ordered[3], ordered_bends[3];
    Complex at_corner[3], means[3];
    int first = first_corner(phases);
    for (int c = 0; c < 3; c++) {
        int from = (first + c) % 3;
        ordered[c] = phases[from];
        ordered_bends[c] = bends[from];
        at_corner[c] = phasor(phases[from]);
    }
    ordered_means(ordered, at_corner, ordered_bends, means);
    return plus(plus(means[0], means[1]), means[2]);
}

/* Fields of tubes (M), M = count, of S that start: `level`: whether the polarization is "h"; wavenumber [rad/m]. corners (3, 3, M),
 * centre, direction, field, normal, begin (3, M), length, first_length (M), launched (M): as of `RayTubes`; out (3, S), share (S):
 * as of `Launch`. east to curvature (M): of the rays back. Results: amplitude (M) over the factor of the current, position (M, 3). */
/* Arrays: corners (3, 3, count); centre, direction, field, normal, begin (3, count); length, first_length (count);
 * launched (count) < starts; out (3, starts); share (starts); east, north, rise, flat, back_length, curvature, amplitude (count);
 * position (count, 3) */
KERNEL int64_t tube_fields(int64_t count, int64_t starts, int64_t level, double wavenumber, const double *corners,
                           const double *centre, const double *direction, const double *field, const double *normal,
                           const double *begin, const double *length, const double *first_length, const int64_t *launched,
                           const double *out, const double *share, const double *east, const double *north, const double *rise,
                           const double *flat, const double *back_length, const double *curvature, Complex *amplitude,
                           double *position) {
    for (int64_t i = 0; i < count; i++) {
        double corner[3][3], middle[3], frame[4][3], electric[3], facing[3], start[3], launch[3], u[3], v[3], across[3];
        for (int c = 0; c < 3; c++) column(corners + 3 * c * count, count, i, corner[c]);
        column(centre, count, i, middle);
        column(direction, count, i, frame[0]);
        column(field, count, i, electric);
        column(normal, count, i, facing);
        column(begin, count, i, start);
        column(out, starts, launched[i], launch);
        double e = east[i], n = north[i], r = rise[i], f = flat[i];
        double back[3][3] = {{e * f, n * f, r}, {n, -e, 0.0}, {-e * r, -n * r, f}};
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++) frame[1 + c][axis] = back[c][axis];
        Complex mean = mean_phasor(corner, middle, frame, length[i], back_length[i], curvature[i], wavenumber);
        subtract(corner[1], corner[0], u);
        subtract(corner[2], corner[0], v);
        cross(u, v, across);
        const double *received = back[level ? 1 : 2];
        double current = dot(received, frame[0]) * dot(facing, electric) - dot(received, electric) * dot(facing, frame[0]);
        double surface = sqrt(dot(across, across)) / 2.0 * share[launched[i]] * current;
        amplitude[i] = scaled(times(mean, phasor(-wavenumber * (length[i] + back_length[i]))), surface);
        /* `_behind`: the point that stands for the path */
        double half[3], opposite[3], gradient[3];
        for (int axis = 0; axis < 3; axis++) {
            half[axis] = (middle[axis] - start[axis]) / 2.0;
            opposite[axis] = -half[axis];
            gradient[axis] = (launch[axis] + back[0][axis]) / 2.0;
        }
        double there = spherical(half, launch, first_length[i]), back_there = spherical(opposite, back[0], back_length[i]);
        double missing = (length[i] - first_length[i] - there - back_there) / 2.0 / larger(dot(gradient, gradient), 1e-3);
        for (int axis = 0; axis < 3; axis++) position[3 * i + axis] = start[axis] + half[axis] + gradient[axis] * missing;
    }
    return count;
}
