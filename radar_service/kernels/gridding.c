/* Points spread on a grid: receive/gridding.py. */

#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "phasors.h"

enum { NO_MEMORY = -1 };

/* Some rows of a grid, row r as row r mod `width` of sums (width, size): those from `start` on. touched (width, 2): which columns of
 * each are not 0, from one to another. */
typedef struct {
    int64_t width, size, start;
    Complex *sums;
    int64_t *touched;
} Band;

static int64_t wrapped(int64_t index, int64_t size) {
    int64_t rest = index % size;
    return rest < 0 ? rest + size : rest;
}

/* Adds row `start` of a band to its row of `total` (rows, size, 2), which is circular, and begins one row later. */
static void next_row(Band *band, int64_t rows, float *total) {
    int64_t own = wrapped(band->start, band->width), *touched = band->touched + 2 * own;
    float *target = total + 2 * band->size * wrapped(band->start, rows);
    Complex *sums = band->sums + own * band->size;
    for (int64_t i = touched[0]; i < touched[1]; i++) {
        target[2 * i] = (float)(target[2 * i] + sums[i].re);
        target[2 * i + 1] = (float)(target[2 * i + 1] + sums[i].im);
    }
    if (touched[0] < touched[1]) memset(sums + touched[0], 0, (size_t)(touched[1] - touched[0]) * sizeof *sums);
    touched[0] = band->size;
    touched[1] = 0;
    band->start++;
}

/* Adds a point to row r of a band: its amplitude by weights (width) from column `first` on, circular. */
static void add_point(Band *band, int64_t r, int64_t width, int64_t first, const double *weight, Complex amplitude) {
    int64_t own = wrapped(r, band->width), *touched = band->touched + 2 * own, size = band->size;
    Complex *sums = band->sums + own * size;
    int inside = first >= 0 && first + width <= size;
    int64_t low = inside ? first : 0, high = inside ? first + width : size;
    if (low < touched[0]) touched[0] = low;
    if (high > touched[1]) touched[1] = high;
    for (int64_t i = 0; i < width; i++) {
        Complex *cell = sums + (inside ? first + i : wrapped(first + i, size));
        *cell = plus(*cell, scaled(amplitude, weight[i]));
    }
}

/* Spreads points (E), E = count, in order of rising first_row (E), on a grid `total` (rows, size, 2), both axes circular: weights
 * weight_row (E, width_row) from rows first_row on times weight_column (E, width_column) from columns first_column (E) on. */
KERNEL int64_t spread_points(int64_t count, int64_t rows, int64_t size, int64_t width_row, int64_t width_column,
                             const int64_t *first_row, const double *weight_row, const int64_t *first_column,
                             const double *weight_column, const Complex *amplitude, float *total) {
    if (!count) return 0;
    Band band = {width_row, size, first_row[0], calloc((size_t)(width_row * size), sizeof(Complex)),
                 malloc((size_t)(2 * width_row) * sizeof(int64_t))};
    if (band.sums && band.touched) {
        for (int64_t r = 0; r < width_row; r++) {
            band.touched[2 * r] = size;
            band.touched[2 * r + 1] = 0;
        }
        for (int64_t e = 0; e < count; e++) {
            for (int64_t passed = 0; band.start < first_row[e] && passed < width_row; passed++) next_row(&band, rows, total);
            band.start = first_row[e];
            for (int64_t r = 0; r < width_row; r++)
                add_point(&band, first_row[e] + r, width_column, first_column[e], weight_column + e * width_column,
                          scaled(amplitude[e], weight_row[e * width_row + r]));
        }
        for (int64_t r = 0; r < width_row; r++) next_row(&band, rows, total);
    } else
        count = NO_MEMORY;
    free(band.sums);
    free(band.touched);
    return count;
}
