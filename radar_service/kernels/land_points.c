/* What boresight passes of resting points over a piece of azimuths: `LandPassages` of echo/land.py. Lengths are in metres. */

#include "geometry.h"
#include "phasors.h"

static const double MAX_TURN = 0.5; /* of the antenna's own turn: bearings that change faster are too near for a crossing */
static const double SMALL = 0.125;  /* tangents whose series is exact: its next term is 3e-18 */
enum { LANES = 16 };                /* points whose crossings are sought side by side, as vectors hold them: in half the time */

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

/* The azimuth numbers at which boresight points at middles (3, LANES), by Newton's method from the middle of the piece. */
static inline void crossings_of(const Passage *of, double (*middle)[LANES], Complex boresight, double *number) {
    double per_half = 1.0 / of->half, per_step = 1.0 / of->step, turn = per_half * per_step;
    double low = of->middle - 2.0 * of->half, high = of->middle + 2.0 * of->half;
    double east[LANES], north[LANES], change[LANES], aside[LANES], ahead[LANES], left[LANES];
    for (int i = 0; i < LANES; i++) number[i] = of->middle;
    for (int64_t step = 0; step < of->steps; step++) {
        for (int i = 0; i < LANES; i++) {
            double u = (number[i] - of->middle) * per_half;
            east[i] = middle[0][i] - at(of, 0, u);
            north[i] = middle[1][i] - at(of, 1, u);
            change[i] = (slope(of, 1, u) * east[i] - slope(of, 0, u) * north[i]) * turn / larger(east[i] * east[i] + north[i] * north[i], 1.0);
        }
        for (int i = 0; i < LANES && of->columns > 4; i++) {
            double u = (number[i] - of->middle) * per_half, seen[2];
            double offset[3] = {east[i], north[i], middle[2][i] - at(of, 2, u) - drop(east[i], north[i], of->earth_radius)};
            for (int row = 0; row < 2; row++)
                seen[row] = at(of, 4 + 3 * row, u) * offset[0] + at(of, 5 + 3 * row, u) * offset[1] + at(of, 6 + 3 * row, u) * offset[2];
            east[i] = seen[0];
            north[i] = seen[1];
        }
        int small = 1;
        for (int i = 0; i < LANES; i++) {
            ahead[i] = north[i] * boresight.re + east[i] * boresight.im;
            aside[i] = east[i] * boresight.re - north[i] * boresight.im;
            double t = aside[i] / ahead[i], z = t * t, series = 1.0 / 13 - z * (1.0 / 15 - z * (1.0 / 17));
            left[i] = t * (1.0 - z * (1.0 / 3 - z * (1.0 / 5 - z * (1.0 / 7 - z * (1.0 / 9 - z * (1.0 / 11 - z * series))))));
            small &= (ahead[i] > 0.0) & (fabs(t) < SMALL);
        }
        for (int i = 0; i < LANES && !small; i++)
            if (!(ahead[i] > 0.0 && fabs(aside[i]) < SMALL * ahead[i])) left[i] = atan2(aside[i], ahead[i]);
        for (int i = 0; i < LANES; i++) {
            left[i] -= (number[i] - of->middle) * of->step;
            number[i] += left[i] * per_step / (1.0 - smaller(larger(change[i], -MAX_TURN), MAX_TURN));
            number[i] = smaller(larger(number[i], low), high);
        }
    }
}

/* Which points face the antenna, and boresight passes. Returns how many. */
/* Arrays: first, last (runs) < points + 1; position, normal (points, 3); one_sided, lift (points); polynomial (5, columns);
 * which, crossing, cosine (room) */
KERNEL int64_t passed_points(const Passage *of) {
    if (of->columns != 4 && of->columns != 13) return REFUSED;
    const double *antenna = of->polynomial;
    Complex boresight = phasor(of->middle * of->step);
    int64_t kept = 0, most = 0;
    for (int64_t r = 0; r < of->runs; r++) most += of->last[r] > of->first[r] ? of->last[r] - of->first[r] : 0;
    if (most > of->room) return REFUSED;
    for (int64_t r = 0; r < of->runs; r++) {
        int64_t facing = kept; /* from `kept` on: points with their distances, before their crossings */
        for (int64_t p = of->first[r]; p < of->last[r]; p++) {
            const double *position = of->position + 3 * p;
            const float *normal = of->normal + 3 * p;
            double line[3];
            subtract(antenna, position, line);
            double distance = sqrt(line[0] * line[0] + line[1] * line[1]);
            double ahead = -line[0] * boresight.im - line[1] * boresight.re;
            line[2] -= drop(line[0], line[1], of->earth_radius);
            double cosine = (line[0] * normal[0] + line[1] * normal[1] + line[2] * normal[2]) / larger(sqrt(dot(line, line)), 1e-9);
            of->which[facing] = p;
            of->crossing[facing] = distance;
            of->cosine[facing] = of->one_sided[p] ? cosine : fabs(cosine);
            facing += ((distance <= of->near) | (ahead >= distance * of->width_cosine)) & (of->cosine[facing] > 0.0);
        }
        for (int64_t begin = kept; begin < facing; begin += LANES) {
            double middle[3][LANES], number[LANES];
            int64_t count = facing - begin < LANES ? facing - begin : LANES;
            for (int64_t i = 0; i < LANES; i++) {
                int64_t p = of->which[begin + (i < count ? i : 0)];
                for (int axis = 0; axis < 3; axis++) middle[axis][i] = of->position[3 * p + axis];
                middle[2][i] += (double)of->lift[p];
            }
            crossings_of(of, middle, boresight, number);
            for (int64_t i = begin; i < begin + count; i++) {
                double crossing = of->crossing[i] <= of->beside ? of->middle : number[i - begin];
                of->which[kept] = of->which[i];
                of->cosine[kept] = of->cosine[i];
                of->crossing[kept] = crossing;
                kept += (crossing >= of->begin) & (crossing < of->end);
            }
        }
    }
    return kept;
}
