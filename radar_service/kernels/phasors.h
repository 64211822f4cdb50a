/* Complex numbers, and exp(j phase) that does not depend on the processor: reduced by pi / 2 in pieces of 26 bits (Cody and Waite
 * 1980), so that the products with quarter turns are exact up to 1e8 rad, then the polynomials of fdlibm (Sun Microsystems 1993). */

#ifndef PHASORS_H
#define PHASORS_H

#include <stdint.h>
#include <string.h>

typedef struct {
    double re, im;
} Complex;

static inline Complex complex_of(double re, double im) {
    Complex result = {re, im};
    return result;
}

static inline Complex plus(Complex a, Complex b) { return complex_of(a.re + b.re, a.im + b.im); }

static inline Complex minus(Complex a, Complex b) { return complex_of(a.re - b.re, a.im - b.im); }

static inline Complex times(Complex a, Complex b) { return complex_of(a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re); }

static inline Complex scaled(Complex a, double by) { return complex_of(a.re * by, a.im * by); }

/* j `by` times a number. */
static inline Complex turned(Complex a, double by) { return complex_of(-a.im * by, a.re * by); }

static inline Complex phasor(double phase) {
    const double toward_integer = 6755399441055744.0; /* 1.5 * 2^52: a sum with it has the nearest integer in its low bits */
    double shifted = phase * 0x1.45f306dc9c883p-1 + toward_integer, quarters = shifted - toward_integer;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    double x = ((phase - quarters * 0x1.921fb5p+0) - quarters * 0x1.110b46p-26) - quarters * 0x1.1a62633145c07p-54;
    double z = x * x;
    double odd = -1.66666666666666324348e-01 +
                 z * (8.33333333332248946124e-03 +
                      z * (-1.98412698298579493134e-04 +
                           z * (2.75573137070700676789e-06 +
                                z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))));
    double even = 4.16666666666666019037e-02 +
                  z * (-1.38888888888741095749e-03 +
                       z * (2.48015872894767294178e-05 +
                            z * (-2.75573143513906633035e-07 +
                                 z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11))));
    double sine = x + x * z * odd, whole = 1.0 - 0.5 * z, cosine = whole + (((1.0 - whole) - 0.5 * z) + z * z * even);
    uint64_t odd_quarter = -(bits & 1), re, im; /* no branch: quarters follow no order */
    memcpy(&re, &cosine, sizeof re);
    memcpy(&im, &sine, sizeof im);
    uint64_t swap = (re ^ im) & odd_quarter;
    re ^= swap ^ ((bits + 1) & 2) << 62;
    im ^= swap ^ (bits & 2) << 62;
    Complex result;
    memcpy(&result.re, &re, sizeof re);
    memcpy(&result.im, &im, sizeof im);
    return result;
}

/* `phasor` of phases (count) [rad]. */
static inline void phasors_of(int64_t count, const double *restrict phase, Complex *restrict result) {
    for (int64_t i = 0; i < count; i++) result[i] = phasor(phase[i]);
}

#endif
