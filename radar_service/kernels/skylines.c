/* The skyline of triangles in the antenna's picture: scattering/physical_optics/skylines.py. */

#include <stdlib.h>

#include "geometry.h"

static const double NEAREST = 1e-3; /* m, of picture.py */
static const double TOGETHER = 1e-9; /* of the width: parts with less between them follow each other */

typedef struct {
    double u[2], v[2];
} Segment; /* an edge in the picture, from left to right */

typedef struct {
    int64_t segment;
    double begin, end;
} Part; /* of a segment, from u to u */

typedef struct {
    Part *parts;
    int64_t count, room;
} Parts;

typedef struct {
    double low, high, tolerance, gap, anchor[2], last[2], least, most;
    double *chords;
    int64_t room, total;
    int open;
} Chords; /* the next one leads from anchor to last, or on with a slope between least and most */

/* Cuts the ends, shares of an edge, to where a value that is linear over it is not negative; returns whether anything is left. */
static int cut_ends(double *ends, double from, double to) {
    if (!(from >= 0.0 || to >= 0.0)) return 0;
    if (from < 0.0) ends[0] = larger(ends[0], from / (from - to));
    if (to < 0.0) ends[1] = smaller(ends[1], from / (from - to));
    return ends[0] < ends[1];
}

/* The edge from p to q (3) as the picture has it from left to right, shifted in u; returns whether any of it is in there above low. */
static int seen(const double *p, const double *q, const double *ahead, double left, double right, double low, double shift,
                Segment *segment) {
    const double *at[2] = {p, q};
    double x[2], y[2], ends[2] = {0.0, 1.0};
    for (int k = 0; k < 2; k++) {
        x[k] = at[k][0] * ahead[1] - at[k][1] * ahead[0];
        y[k] = at[k][0] * ahead[0] + at[k][1] * ahead[1];
    }
    if (!cut_ends(ends, y[0] - NEAREST, y[1] - NEAREST) || !cut_ends(ends, x[0] - left * y[0], x[1] - left * y[1]) ||
        !cut_ends(ends, right * y[0] - x[0], right * y[1] - x[1]))
        return 0;
    for (int k = 0; k < 2; k++) {
        double share = ends[k], depth = (1.0 - share) * y[0] + share * y[1];
        segment->u[k] = ((1.0 - share) * x[0] + share * x[1]) / depth + shift;
        segment->v[k] = ((1.0 - share) * p[2] + share * q[2]) / depth;
        if (!isfinite(segment->u[k]) || !isfinite(segment->v[k])) return 0;
    }
    if (segment->u[0] > segment->u[1]) {
        Segment turned = {{segment->u[1], segment->u[0]}, {segment->v[1], segment->v[0]}};
        *segment = turned;
    }
    return segment->u[0] < segment->u[1] && (segment->v[0] > low || segment->v[1] > low);
}

static double height_at(const Segment *segment, double u) {
    double share = (u - segment->u[0]) / (segment->u[1] - segment->u[0]);
    return (1.0 - share) * segment->v[0] + share * segment->v[1];
}

/* Whether the edge opposite to a corner of a triangle (3, 3) may be in its skyline: not where it runs below that corner. */
static int may_top(const double *corners, int opposite, const double *ahead) {
    double u[3], v[3];
    for (int k = 0; k < 3; k++) {
        const double *at = corners + 3 * ((opposite + k) % 3);
        double depth = at[0] * ahead[0] + at[1] * ahead[1];
        if (!(depth > NEAREST)) return 1;
        u[k] = (at[0] * ahead[1] - at[1] * ahead[0]) / depth;
        v[k] = at[2] / depth;
    }
    double side = (u[2] - u[1]) * (v[0] - v[1]) - (v[2] - v[1]) * (u[0] - u[1]);
    return !(u[2] > u[1] ? side > 0.0 : side < 0.0);
}

/* Appends a part of a skyline that begins at parts[first]; returns whether there was memory. */
static int append(Parts *list, int64_t first, int64_t segment, double begin, double end) {
    Part part = {segment, begin, end}, *next = list->parts + list->count;
    if (!(begin < end)) return 1;
    if (list->count > first && next[-1].segment == segment && next[-1].end == begin) {
        next[-1].end = end;
        return 1;
    }
    if (list->count == list->room) {
        int64_t room = 2 * list->room;
        Part *more = realloc(list->parts, (size_t)room * sizeof *more);
        if (!more) return 0;
        list->parts = more;
        list->room = room;
    }
    list->parts[list->count++] = part;
    return 1;
}

/* Appends the higher of two segments between two u. */
static int append_higher(Parts *list, int64_t first, const Segment *segments, int64_t a, int64_t b, double begin, double end) {
    double above = height_at(segments + a, begin) - height_at(segments + b, begin);
    double after = height_at(segments + a, end) - height_at(segments + b, end), across = end;
    if (above < 0.0 && after > 0.0) return append_higher(list, first, segments, b, a, begin, end);
    if (above < 0.0 || (above == 0.0 && after < 0.0)) return append(list, first, b, begin, end);
    if (after < 0.0) across = smaller(larger(begin + (end - begin) * (above / (above - after)), begin), end);
    return append(list, first, a, begin, across) && append(list, first, b, across, end);
}

/* Appends the skyline of two skylines; returns whether there was memory. */
static int merge(Parts *list, const Segment *segments, const Part *a, const Part *a_end, const Part *b, const Part *b_end) {
    int64_t first = list->count;
    double from = -INFINITY;
    while (a < a_end || b < b_end) {
        double of_a = a < a_end ? larger(a->begin, from) : INFINITY, of_b = b < b_end ? larger(b->begin, from) : INFINITY, end;
        int made;
        if (of_a == of_b) {
            end = smaller(a->end, b->end);
            made = append_higher(list, first, segments, a->segment, b->segment, of_a, end);
        } else if (of_a < of_b) {
            end = smaller(a->end, of_b);
            made = append(list, first, a->segment, of_a, end);
        } else {
            end = smaller(b->end, of_a);
            made = append(list, first, b->segment, of_b, end);
        }
        if (!made) return 0;
        from = end;
        a += a < a_end && a->end <= from;
        b += b < b_end && b->end <= from;
    }
    return 1;
}

/* Ends a chord, and begins one at its end. */
static void end_chord(Chords *to) {
    if (to->total < to->room && to->last[0] > to->anchor[0]) {
        double chord[4] = {to->anchor[0], to->anchor[1], to->last[0], to->last[1]};
        for (int k = 0; k < 4; k++) to->chords[4 * to->total + k] = chord[k];
    }
    to->total += to->last[0] > to->anchor[0];
    for (int k = 0; k < 2; k++) to->anchor[k] = to->last[k];
    to->least = -INFINITY;
    to->most = INFINITY;
}

/* Leads the chords on along a straight line. */
static void lead_on(Chords *to, double begin, double at_begin, double end, double at_end) {
    if (to->open && (begin > to->last[0] + to->gap || fabs(at_begin - to->last[1]) > 0.5 * to->tolerance)) {
        end_chord(to);
        to->open = 0;
    }
    if (!to->open) {
        to->anchor[0] = to->last[0] = begin;
        to->anchor[1] = to->last[1] = at_begin;
        to->open = 1;
    }
    double slope = (at_end - to->anchor[1]) / (end - to->anchor[0]);
    if (!(slope >= to->least && slope <= to->most)) end_chord(to);
    double width = end - to->anchor[0], rise = at_end - to->anchor[1];
    to->last[0] = end;
    to->last[1] = at_end;
    to->least = larger(to->least, (rise - to->tolerance) / width);
    to->most = smaller(to->most, (rise + to->tolerance) / width);
}

/* The part of a segment that rises above low, cut off at high. */
static void draw(Chords *to, const Segment *segment, double begin, double end) {
    double at[2] = {height_at(segment, begin), height_at(segment, end)}, cuts[4] = {begin, end, end, end};
    double low = (to->low - at[0]) / (at[1] - at[0]), high = (to->high - at[0]) / (at[1] - at[0]);
    if (low > 0.0 && low < 1.0) cuts[1] = begin + low * (end - begin);
    if (high > 0.0 && high < 1.0) cuts[2] = begin + high * (end - begin);
    if (cuts[1] > cuts[2]) {
        double swapped = cuts[1];
        cuts[1] = cuts[2];
        cuts[2] = swapped;
    }
    for (int k = 0; k < 3; k++) {
        if (!(cuts[k] < cuts[k + 1]) || height_at(segment, 0.5 * (cuts[k] + cuts[k + 1])) < to->low) continue;
        lead_on(to, cuts[k], smaller(height_at(segment, cuts[k]), to->high), cuts[k + 1],
                smaller(height_at(segment, cuts[k + 1]), to->high));
    }
}

/* The skyline of triangles (T, 3, 3), T = count, at virtual positions, between u of left and right: straight chords (C, 2, 2), from
 * (u, v) to (u, v), within a tolerance in v of it. Returns how many there are; the first `room` of them go to chords.
 *
 * u, v: to the right and up, as shares of the distance along ahead (2), a unit vector in plan. What is below low is left out, and
 * what is above high is high. shift (T): added to u, so that groups of triangles have skylines of their own. */
/* Arrays: ahead (2); corners (count, 3, 3); shift (count); chords (room, 2, 2) */
KERNEL int64_t skyline(int64_t count, int64_t room, double left, double right, double low, double high, double tolerance,
                       const double *ahead, const double *corners, const double *shift, double *chords) {
    size_t every = 3 * (size_t)count + 1;
    Segment *segments = malloc(every * sizeof *segments);
    int64_t *begin = malloc((every + 1) * sizeof *begin), skylines = 0;
    Parts parts = {malloc(every * sizeof(Part)), 0, (int64_t)every}, merged = {malloc(every * sizeof(Part)), 0, (int64_t)every};
    int made = segments && begin && parts.parts && merged.parts;
    for (int64_t i = 0; made && i < 3 * count; i++) {
        const double *other = corners + 3 * (i % 3 == 2 ? i - 2 : i + 1);
        if (!may_top(corners + 9 * (i / 3), (int)((i + 2) % 3), ahead) ||
            !seen(corners + 3 * i, other, ahead, left, right, low, shift[i / 3], segments + skylines)) continue;
        Part part = {skylines, segments[skylines].u[0], segments[skylines].u[1]};
        parts.parts[skylines] = part;
        begin[skylines] = skylines;
        skylines++;
    }
    parts.count = skylines;
    while (made && skylines > 1) {
        int64_t fewer = 0;
        begin[skylines] = parts.count;
        merged.count = 0;
        for (int64_t i = 0; made && i < skylines; i += 2) {
            const Part *a = parts.parts + begin[i], *b = parts.parts + begin[i + 1];
            const Part *end = i + 2 <= skylines ? parts.parts + begin[i + 2] : b;
            begin[fewer++] = merged.count;
            made = merge(&merged, segments, a, b, b, end);
        }
        Parts old = parts;
        parts = merged;
        merged = old;
        skylines = fewer;
    }
    Chords to = {.low = low, .high = high, .tolerance = tolerance, .gap = TOGETHER * (right - left), .least = -INFINITY,
                 .most = INFINITY, .chords = chords, .room = room};
    for (int64_t i = 0; made && i < parts.count; i++)
        draw(&to, segments + parts.parts[i].segment, parts.parts[i].begin, parts.parts[i].end);
    if (to.open) end_chord(&to);
    free(segments);
    free(begin);
    free(parts.parts);
    free(merged.parts);
    return made ? to.total : NO_MEMORY;
}
