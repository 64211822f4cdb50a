/* Kernels of aspects that other kernels call. */

#ifndef CALLED_H
#define CALLED_H

#include "geometry.h"
#include "phasors.h"

/* Points (M, 3), M = count, in a body's frame, the leg to it as of `leg_lengths`, and the results (M), as of `LegRays`. */
typedef struct {
    int64_t count, by_sea;
    const double *points, *position;
    double cosine, sine;
    const double *antenna;
    double earth_radius, *length, *east, *north, *rise, *flat, *curvature, *tilt;
    uint8_t *arrives;
} PointRays;

KERNEL int64_t leg_rays(const PointRays *rays);

KERNEL int64_t leg_weights(int64_t count, const double *points, const double *position, double cosine, double sine,
                           const double *antenna, double earth_radius, double *weight);

KERNEL int64_t leg_lengths(int64_t count, int64_t by_sea, const double *points, const double *position, double cosine, double sine,
                           const double *antenna, double earth_radius, double *length);

KERNEL int64_t facet_shapes(int64_t count, const double *points, const int64_t *corner, double *edges, double *centre,
                            double *area);

KERNEL int64_t sags(int64_t count, int64_t vectors, const double *edge, const double *east, const double *north, const double *rise,
                    const double *flat, const double *length, const double *curvature, double *result);

KERNEL int64_t facet_fields(int64_t count, int64_t legs, int64_t out, int64_t back, int64_t level, const int64_t *corner,
                            const double *normal, const double *area, const int8_t *side, const double *share, const double *east,
                            const double *north, const double *rise, const double *flat, const double *length,
                            const double *bend, const double *phase, const Complex *at, const double *way,
                            const double *back_east, const double *back_north, const double *back_rise,
                            const double *back_flat, const double *back_length, const double *back_bend,
                            const double *back_phase, const Complex *back_at, const double *back_way, Complex *total);

KERNEL int64_t cut_triangles(int64_t count, int64_t room, const double *corners, const double *longest, double *parts,
                             int64_t *origin);

KERNEL int64_t welded(int64_t count, const double *corners, int64_t *number, double *points);

#endif
