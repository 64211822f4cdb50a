/* What boresight passes of resting points over a piece of azimuths: `LandPassages` of echo/land.py. Lengths are in metres. */

#include "geometry.h"
#include "phasors.h"

static const double MAX_TURN = 0.5; /* of the antenna's own turn: bearings that change faster are too near for a crossing */
static const double SMALL = 0.125;  /* tangents whose series is exact: its next term is 3e-18, below 1e-4 that of two 2e-17 */

/* Points (P): position, normal (P, 3), one_sided (P), lift (P): height of their middles over them; runs of these (R), R = runs, from
 * first to last (R), exclusive. polynomial (5, C), C = columns, 4 or 13: coefficients of the antenna's position, what its way adds,
 * and its level where it sways, by (number - middle) / half. Azimuth numbers: from begin to before end; step: from one to the next
 * [rad]. Within `near` all points count, farther ones within an angle of boresight in the middle, by its cosine; within `beside`
 * they are passed in the middle. Of those that face the antenna there and are passed (K): which (K), crossing (K): azimuth numbers,
 * cosine (K) of the angle between normal and line of sight. */
typedef struct {
    int64_t runs, points, room, columns, steps;
    double middle, half, begin, end, step, width_cosine, near, beside, earth_radius;
    const int64_t *first, *last;
    const double *position;
    const float *normal;
    const uint8_t *one_sided;
    const float *lift;
    const double *polynomial;
    int64_t *which;
    double *crossing, *cosine;
} Passage;

/* The angle from `ahead` to a vector [rad]. */
static inline double angle_of(double aside, double ahead) {
    double t = aside / ahead, z = t * t;
    if (!(ahead > 0.0 && fabs(t) < SMALL)) return atan2(aside, ahead);
    if (z < 1e-8) return t * (1.0 - z * (1.0 / 3));
    double series = 1.0 / 13 - z * (1.0 / 15 - z * (1.0 / 17));
    return t * (1.0 - z * (1.0 / 3 - z * (1.0 / 5 - z * (1.0 / 7 - z * (1.0 / 9 - z * (1.0 / 11 - z * series))))));
}

/* Column c of the polynomial at u, and its derivative. */
static inline double at(const Passage *of, int64_t c, double u) {
    const double *p = of->polynomial + c;
    int64_t n = of->columns;
    return p[0] + u * (p[n] + u * (p[2 * n] + u * (p[3 * n] + u * p[4 * n])));
}

static inline double slope(const Passage *of, int64_t c, double u) {
    const double *p = of->polynomial + c;
    int64_t n = of->columns;
    return p[n] + u * (2.0 * p[2 * n] + u * (3.0 * p[3 * n] + u * 4.0 * p[4 * n]));
}

/* The azimuth number at which boresight points at a middle, by Newton's method from the middle of the piece. */
static inline double crossing_of(const Passage *of, const double *middle, Complex boresight) {
    double number = of->middle, per_half = 1.0 / of->half, per_step = 1.0 / of->step, turn = per_half * per_step;
    double low = of->middle - 2.0 * of->half, high = of->middle + 2.0 * of->half;
    for (int64_t step = 0; step < of->steps; step++) {
        double u = (number - of->middle) * per_half, east = middle[0] - at(of, 0, u), north = middle[1] - at(of, 1, u);
        double change = (slope(of, 1, u) * east - slope(of, 0, u) * north) * turn / larger(east * east + north * north, 1.0);
        if (of->columns > 4) {
            double offset[3] = {east, north, middle[2] - at(of, 2, u) - drop(east, north, of->earth_radius)}, seen[2];
            for (int row = 0; row < 2; row++)
                seen[row] = at(of, 4 + 3 * row, u) * offset[0] + at(of, 5 + 3 * row, u) * offset[1] + at(of, 6 + 3 * row, u) * offset[2];
            east = seen[0];
            north = seen[1];
        }
        if (step) boresight = phasor(number * of->step);
        double left = angle_of(east * boresight.re - north * boresight.im, north * boresight.re + east * boresight.im);
        number += left * per_step / (1.0 - smaller(larger(change, -MAX_TURN), MAX_TURN));
        number = smaller(larger(number, low), high);
    }
    return number;
}

/* Which points face the antenna, and boresight passes. Returns how many. */
/* Arrays: first, last (runs) < points + 1; position, normal (points, 3); one_sided, lift (points); polynomial (5, columns);
 * which, crossing, cosine (room) */
KERNEL int64_t passed_points(const Passage *of) {
    if (of->columns != 4 && of->columns != 13) return REFUSED;
    const double *antenna = of->polynomial;
    Complex boresight = phasor(of->middle * of->step);
    int64_t kept = 0;
    for (int64_t r = 0; r < of->runs; r++)
        for (int64_t p = of->first[r]; p < of->last[r]; p++) {
            const double *position = of->position + 3 * p;
            const float *normal = of->normal + 3 * p;
            double line[3], middle[3] = {position[0], position[1], position[2] + (double)of->lift[p]};
            subtract(antenna, position, line);
            double distance = sqrt(line[0] * line[0] + line[1] * line[1]);
            double ahead = -line[0] * boresight.im - line[1] * boresight.re;
            if (!(distance <= of->near || ahead >= distance * of->width_cosine)) continue;
            line[2] -= drop(line[0], line[1], of->earth_radius);
            double cosine = (line[0] * normal[0] + line[1] * normal[1] + line[2] * normal[2]) / larger(sqrt(dot(line, line)), 1e-9);
            cosine = of->one_sided[p] ? cosine : fabs(cosine);
            if (!(cosine > 0.0)) continue;
            double crossing = distance <= of->beside ? of->middle : crossing_of(of, middle, boresight);
            if (!(crossing >= of->begin && crossing < of->end)) continue;
            if (kept >= of->room) return REFUSED;
            of->which[kept] = p;
            of->crossing[kept] = crossing;
            of->cosine[kept++] = cosine;
        }
    return kept;
}
