/* Means over triangles of phasors times barycentric coordinates. */

#ifndef TRIANGLE_MEANS_H
#define TRIANGLE_MEANS_H

#include <math.h>

#include "phasors.h"

static const double NEARLY_FLAT = 0.05, GENTLE = 0.5, SMALL = 0.3; /* rad, of the same names in Python */

typedef struct {
    Complex plain, toward, bubble;
} EdgeMoments;

/* The corner that comes first when the one whose phase lies between the others comes second, in cyclic order. */
static inline int first_corner(const double phases[3]) {
    double first = phases[0] - phases[1], second = phases[1] - phases[2], third = phases[2] - phases[0];
    return first * third >= 0.0 ? 2 : first * second >= 0.0 ? 0 : 1;
}

/* 4 (exp(j bend) - 1) */
static inline Complex bubble_of(double bend) {
    double square = bend * bend;
    if (fabs(bend) > GENTLE) return scaled(minus(phasor(bend), complex_of(1.0, 0.0)), 4.0);
    return complex_of(
        -2.0 * square * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))),
        4.0 * bend * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))));
}

static inline EdgeMoments edge_moments(double rise, Complex begin, Complex end) {
    EdgeMoments edge;
    if (fabs(rise) <= 2.0 * SMALL) {
        double half = rise / 2.0, z2 = half * half;
        double zeroth = 1.0 - z2 / 6.0 * (1.0 - z2 / 20.0 * (1.0 - z2 / 42.0));
        double first_over = (1.0 - z2 / 10.0 * (1.0 - z2 / 28.0 * (1.0 - z2 / 54.0))) / 3.0;
        Complex centre = times(end, phasor(-half));
        edge.plain = scaled(centre, zeroth);
        edge.toward = scaled(plus(edge.plain, turned(centre, half * first_over)), 0.5);
        edge.bubble = scaled(centre, first_over / 2.0);
        return edge;
    }
    double step = -1.0 / rise;
    edge.plain = turned(minus(end, begin), step);
    edge.toward = turned(minus(end, edge.plain), step);
    edge.bubble = minus(edge.toward, turned(minus(end, scaled(edge.toward, 2.0)), step));
    return edge;
}

/* What corners get of the bubbles of the edges opposite to them: half of the two edges that meet there. */
static inline void share_bubbles(Complex bubbles[3], Complex means[3]) {
    Complex sum = plus(plus(bubbles[0], bubbles[1]), bubbles[2]);
    for (int corner = 0; corner < 3; corner++)
        means[corner] = plus(means[corner], scaled(minus(sum, bubbles[corner]), 0.5));
}

/* `ordered_means`: of one triangle by its phases [rad], exp(j phase) and bends [rad], corners as `first_corner` starts them. */
static inline void ordered_means(const double phases[3], const Complex at_corner[3], const double bends[3], Complex means[3]) {
    double span = phases[2] - phases[0];
    Complex weight[3], bubbles[3];
    for (int corner = 0; corner < 3; corner++) weight[corner] = bubble_of(bends[corner]);
    if (fabs(span) <= NEARLY_FLAT) {
        double x[3], together, squares;
        for (int corner = 0; corner < 3; corner++) x[corner] = phases[corner] - phases[1];
        together = x[0] + x[1] + x[2];
        squares = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        for (int corner = 0; corner < 3; corner++) {
            double second = (together * together + squares + 2.0 * x[corner] * (together + x[corner])) / 120.0;
            means[corner] = complex_of(1.0 / 3.0 - second, (together + x[corner]) / 12.0);
            bubbles[corner] = times(weight[corner], complex_of(1.0 / 12.0, together / 30.0 - x[corner] / 60.0));
        }
        share_bubbles(bubbles, means);
        for (int corner = 0; corner < 3; corner++) means[corner] = times(means[corner], at_corner[1]);
        return;
    }
    EdgeMoments lower = edge_moments(phases[1] - phases[0], at_corner[0], at_corner[1]);
    EdgeMoments upper = edge_moments(phases[1] - phases[2], at_corner[2], at_corner[1]);
    double step = -1.0 / span;
    Complex mean = turned(minus(upper.plain, lower.plain), 2.0 * step);
    means[1] = turned(minus(upper.toward, lower.toward), 2.0 * step);
    means[0] = turned(minus(mean, scaled(minus(lower.plain, lower.toward), 2.0)), step);
    means[2] = turned(minus(scaled(minus(upper.plain, upper.toward), 2.0), mean), step);
    bubbles[0] = times(weight[0], turned(minus(scaled(upper.bubble, 2.0), means[1]), step));
    bubbles[1] = times(weight[1], turned(minus(means[2], means[0]), step));
    bubbles[2] = times(weight[2], turned(minus(means[1], scaled(lower.bubble, 2.0)), step));
    share_bubbles(bubbles, means);
}

#endif
