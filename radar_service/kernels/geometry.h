/* What several kernels share: vectors, and the reflection at the sea of `propagation/multipath.py`. */

#ifndef GEOMETRY_H
#define GEOMETRY_H

#include <math.h>
#include <stdint.h>

#ifdef _WIN32
#define KERNEL __declspec(dllexport)
#else
#define KERNEL
#endif

/* What a kernel returns that stops: no memory, numbers that are not finite or out of range. */
enum { NO_MEMORY = -1, REFUSED = -3 };

static inline double larger(double a, double b) { return a > b ? a : b; }

static inline double smaller(double a, double b) { return a < b ? a : b; }

static inline double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross(const double *a, const double *b, double *result) {
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void subtract(const double *a, const double *b, double *result) {
    for (int axis = 0; axis < 3; axis++) result[axis] = a[axis] - b[axis];
}

/* A row vector times a matrix (3, 3), stored by rows. */
static inline void row_times(const double *vector, const double *matrix, double *result) {
    for (int axis = 0; axis < 3; axis++)
        result[axis] = vector[0] * matrix[axis] + vector[1] * matrix[3 + axis] + vector[2] * matrix[6 + axis];
}

/* By how much the earth curves away at (x, y) from an origin [m]. */
static inline double drop(double x, double y, double earth_radius) { return (x * x + y * y) / (2.0 * earth_radius); }

/* Distance from the antenna to the reflection point [m]: `reflection_distance` of propagation/multipath.py. */
static inline double reflection_distance(double d, double h, double antenna_height, double earth_radius) {
    if (isinf(earth_radius)) return d * antenna_height / (antenna_height + h);
    double p2 = 4.0 / 3.0 * (earth_radius * (antenna_height + h) + d * d / 4.0), p = sqrt(p2);
    double sine = 2.0 * earth_radius * d * (h - antenna_height) / (p2 * p);
    double x = d / 2.0 - p * sin(asin(smaller(larger(sine, -1.0), 1.0)) / 3.0);
    return smaller(larger(x, 0.0), d);
}

#endif
