/* Tubes that were traced at another pose, where they end at this one: `KeptTubes.traced` of
 * scattering/physical_optics/illumination.py. Vectors stand by axis, (3, M); corners are (3, 3, M), by corner and axis [m]. */

#include "geometry.h"

static const double GRAZING = 0.01; /* of tube_tracing.py */

/* Corners (M = count) turned by a matrix (3, 3), and the middles (M, 3) between them. */
/* Arrays: corners, turned (3, 3, count); matrix (3, 3); centre (count, 3) */
KERNEL int64_t turned_corners(int64_t count, const double *corners, const double *matrix, double *turned, double *centre) {
    for (int64_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) {
            const double *row = matrix + 3 * axis;
            double sum = 0.0;
            for (int c = 0; c < 3; c++) {
                const double *at = corners + 3 * c * count + i;
                double value = row[0] * at[0] + row[1] * at[count] + row[2] * at[2 * count];
                turned[(3 * c + axis) * count + i] = value;
                sum += value;
            }
            centre[3 * i + axis] = sum / 3.0;
        }
    return count;
}

static void put(double *vectors, int64_t count, int64_t i, const double *vector) {
    for (int axis = 0; axis < 3; axis++) vectors[axis * count + i] = vector[axis];
}

/* The normal of a triangle on the side that a ray comes from. */
static void facing(const double *plane_normal, const double *direction, double *normal) {
    double sign = dot(plane_normal, direction) > 0.0 ? -1.0 : 1.0;
    for (int axis = 0; axis < 3; axis++) normal[axis] = sign * plane_normal[axis];
}

/* Projects corners onto a plane along a direction; returns how far its middle goes [m]. */
static double project(double corners[3][3], double *centre, const double *direction, const double *point, const double *normal) {
    double along = dot(normal, direction), height = dot(point, normal), middle = 0.0;
    if (fabs(along) < GRAZING) along = copysign(GRAZING, along);
    for (int c = 0; c < 3; c++) {
        double travel = (height - dot(corners[c], normal)) / along;
        for (int axis = 0; axis < 3; axis++) corners[c][axis] += travel * direction[axis];
        middle += travel;
    }
    middle /= 3.0;
    for (int axis = 0; axis < 3; axis++) centre[axis] += middle * direction[axis];
    return middle;
}

/* Tubes (M), M = count, from the first surface to the last one of their chains (S, M), S = surfaces.
 *
 * level: whether the polarization is "h". water: height of the sea [m]. point, plane_normal (F, 3): as of `Planes`. east to
 * first_length (M): of the rays at the first surface. begin (M, 3): their middles there. corners, share (M): changed. Results: of
 * `Launch` outward and polarized (3, M); of `RayTubes` the others. */
/* Arrays: surfaces from 1; chain (surfaces, count) from -1 < F; point, plane_normal (F, 3);
 * east, north, rise, flat, first_length, share, length, bounces, last (count); begin (count, 3); corners (3, 3, count);
 * outward, polarized, centre, normal, direction, field (3, count) */
KERNEL int64_t kept_tubes(int64_t count, int64_t surfaces, int64_t level, double water, const int64_t *chain, const double *point,
                          const double *plane_normal, const double *east, const double *north, const double *rise,
                          const double *flat, const double *first_length, const double *begin, double *corners, double *share,
                          double *outward, double *polarized, double *centre, double *normal, double *direction, double *field,
                          double *length, int64_t *bounces, int64_t *last) {
    for (int64_t i = 0; i < count; i++) {
        double e = east[i], n = north[i], r = rise[i], f = flat[i], at[3][3], middle[3], side[3], longer = 0.0;
        double way[3] = {e * f, n * f, r}, electric[3] = {level ? n : -e * r, level ? -e : -n * r, level ? 0.0 : f};
        put(outward, count, i, way);
        put(polarized, count, i, electric);
        for (int axis = 0; axis < 3; axis++) {
            middle[axis] = begin[3 * i + axis];
            for (int c = 0; c < 3; c++) at[c][axis] = corners[(3 * c + axis) * count + i];
        }
        int64_t triangle = chain[i], number = 1;
        if (triangle < 0) return REFUSED;
        facing(plane_normal + 3 * triangle, way, side);
        for (; number < surfaces && chain[number * count + i] >= 0; number++) {
            double along = dot(side, way), across = dot(side, electric);
            for (int axis = 0; axis < 3; axis++) {
                way[axis] -= 2.0 * along * side[axis];
                electric[axis] = 2.0 * across * side[axis] - electric[axis];
            }
            triangle = chain[number * count + i];
            facing(plane_normal + 3 * triangle, way, side);
            longer += project(at, middle, way, point + 3 * triangle, side);
        }
        put(centre, count, i, middle);
        put(normal, count, i, side);
        put(direction, count, i, way);
        put(field, count, i, electric);
        for (int c = 0; c < 3; c++) put(corners + 3 * c * count, count, i, at[c]);
        length[i] = first_length[i] + longer;
        bounces[i] = number;
        last[i] = triangle;
        if (!(begin[3 * i + 2] > water && middle[2] > water)) share[i] = 0.0;
    }
    return count;
}
