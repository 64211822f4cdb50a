/* What kernels of shadows share: windows in the antenna's picture, of picture.py; what they call. */

#ifndef SHADOWS_H
#define SHADOWS_H

#include "geometry.h"

enum { WINDOW_SIZES = 6 }; /* numbers of a window */

static const double NEAREST = 1e-3; /* m, of picture.py */

typedef struct {
    double middle, half, low, high, nearest, farthest;
} Window;

/* The virtual height of a point at a distance along the earth: `Picture.height`. */
static inline double virtual_height(double distance, double height, double antenna_height, double earth_radius, int by_sea) {
    if (!by_sea) return height - antenna_height - distance * distance / (2.0 * earth_radius);
    distance = larger(distance, NEAREST);
    double reflection = reflection_distance(distance, larger(height, 0.0), antenna_height, earth_radius);
    reflection = larger(reflection, NEAREST * NEAREST);
    return -distance * (antenna_height / reflection + reflection / (2.0 * earth_radius));
}

Window window_of(const double *points, int64_t corners, const double *antenna, double earth_radius, int by_sea);

KERNEL int64_t stand_before(int64_t count, int64_t corners, int64_t legs, const double *points, const double *matrix,
                     const double *position, const double *antenna, double earth_radius, double moved, const double *own,
                     uint8_t *stand);

#endif
