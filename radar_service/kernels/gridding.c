/* Points spread on a grid: receive/gridding.py. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "phasors.h"

static const double FARTHEST = 1e15; /* columns from the first one, and rows */

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
/* Arrays: first_row, first_column, amplitude (count); weight_row (count, width_row); weight_column (count, width_column); total (rows, 2 * size) */
KERNEL int64_t spread_points(int64_t count, int64_t rows, int64_t size, int64_t width_row, int64_t width_column,
                             const int64_t *first_row, const double *weight_row, const int64_t *first_column,
                             const double *weight_column, const Complex *amplitude, float *total) {
    if (!count || !rows || !size) return 0;
    for (int64_t e = 0; e < count; e++)
        if (!(fabs((double)first_row[e]) < FARTHEST && fabs((double)first_column[e]) < FARTHEST)) return REFUSED;
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

/* The numbers (n) of a point for the terms of a series (terms, n) at shifts (n): each is the one before times shift / term. */
static void series_of(int64_t terms, int64_t n, const float *number, const float *shift, float *restrict series) {
    for (int64_t j = 0; j < n; j++) series[j] = number[j];
    for (int64_t t = 1; t < terms; t++)
        for (int64_t j = 0; j < n; j++) series[t * n + j] = series[(t - 1) * n + j] * (shift[j] / (float)t);
}

/* Adds terms (terms, n) by their weights, `apart` numbers from one to the next, to a cell (n). */
static void add_series(int64_t terms, int64_t n, const float *weight, int64_t apart, const float *series, float *restrict cell) {
    if (terms == 1)
        for (int64_t j = 0; j < n; j++) cell[j] += weight[0] * series[j];
    else if (terms == 2)
        for (int64_t j = 0; j < n; j++) cell[j] = (cell[j] + weight[0] * series[j]) + weight[apart] * series[n + j];
    else
        for (int64_t j = 0; j < n; j++)
            cell[j] = ((cell[j] + weight[0] * series[j]) + weight[apart] * series[n + j]) + weight[2 * apart] * series[2 * n + j];
}

/* Points (E), E = count, for the rows from `begin` to `end` of `rows` (all, size, 2), circular: amplitude (E, all, 2); migration
 * (E, all) from column (E). table (steps + 1, terms, width): of the kernel and its derivatives, 1 to 3 terms; middle: of a row about
 * whose positions the series stands, -1: about column. */
typedef struct {
    int64_t count, all, size, begin, end, middle, terms, width, steps;
    const double *column;
    const float *migration, *amplitude, *table;
    float *rows;
} Series;

/* Spreads points by a Taylor series. In single precision, by rising point and term. */
/* Arrays: size from 1; begin < end + 1; end < all + 1; middle from -1 < all; terms from 1 < 4; column (count); migration (count, all);
 * amplitude (count, 2 * all); table (steps + 1, terms, width); rows (all, 2 * size) */
KERNEL int64_t spread_series(const Series *points) {
    int64_t all = points->all, size = points->size, begin = points->begin, end = points->end, middle = points->middle;
    int64_t terms = points->terms, width = points->width, n = 2 * (end - begin), failed = 0;
    float *grid = calloc((size_t)(size * n), sizeof(float)), *series = malloc((size_t)((terms + 1) * n) * sizeof(float));
    if (grid && series) {
        float *shift = series + terms * n;
        for (int64_t e = 0; e < points->count; e++) {
            const float *moved = points->migration + e * all, about = middle < 0 ? 0.0f : moved[middle];
            double position = middle < 0 ? points->column[e] : points->column[e] + about, below = floor(position);
            if (!(fabs(position) < FARTHEST)) {
                failed = REFUSED;
                break;
            }
            const float *weight = points->table + (int64_t)((position - below) * (double)points->steps + 0.5) * terms * width;
            int64_t first = (int64_t)below - (width / 2 - 1);
            int inside = first >= 0 && first + width <= size;
            for (int64_t k = begin; k < end; k++)
                shift[2 * (k - begin)] = shift[2 * (k - begin) + 1] = middle < 0 ? moved[k] : moved[k] - about;
            series_of(terms, n, points->amplitude + 2 * (e * all + begin), shift, series);
            for (int64_t i = 0; i < width; i++)
                add_series(terms, n, weight + i, width, series, grid + n * (inside ? first + i : wrapped(first + i, size)));
        }
        for (int64_t k = begin; k < end; k++)
            for (int64_t i = 0; i < size; i++) {
                points->rows[2 * (k * size + i)] = grid[n * i + 2 * (k - begin)];
                points->rows[2 * (k * size + i) + 1] = grid[n * i + 2 * (k - begin) + 1];
            }
    } else
        failed = NO_MEMORY;
    free(grid);
    free(series);
    return failed ? failed : points->count;
}
