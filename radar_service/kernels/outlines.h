/* Outlines of planar patches, cut into convex pieces: for planar_pieces.c. */

#ifndef OUTLINES_H
#define OUTLINES_H

#include "mesh_edges.h"

/* Corners of an outline in the plane of its patch. */
typedef struct {
    double x, y;
    int32_t vertex;
} Corner;

typedef struct {
    int64_t begin, end; /* in the corners of all outlines */
    double area;        /* twice, positive counterclockwise */
    int64_t within;     /* of a hole: the outline about it */
} Outline;

/* What a patch is cut with; grows with the largest one. */
typedef struct {
    Corner *corners, *polygon; /* of outlines; of one with its holes joined on */
    Outline *outlines;
    int32_t *edge_from, *edge_to, *next, *previous, *out, *leaving; /* edges of the rim; `out` of a vertex: the first that leaves it */
    int8_t *ear;
    int32_t *pieces; /* (triangles, PIECE_CORNERS) */
    int32_t *sizes;
    int64_t room, work;
} Bench;

static void free_bench(Bench *b) {
    free(b->corners);
    free(b->polygon);
    free(b->outlines);
    free(b->edge_from);
    free(b->edge_to);
    free(b->next);
    free(b->previous);
    free(b->leaving);
    free(b->ear);
    free(b->pieces);
    free(b->sizes);
    free(b->out);
}

static int widen(Bench *b, int64_t corners) {
    if (corners <= b->room) return 1;
    int64_t room = 2 * corners;
    int32_t *out = b->out;
    b->out = NULL;
    free_bench(b);
    memset(b, 0, sizeof *b);
    b->out = out;
    b->room = room;
    size_t n = (size_t)room;
    b->corners = malloc(n * sizeof *b->corners);
    b->polygon = malloc(3 * n * sizeof *b->polygon);
    b->outlines = malloc(n * sizeof *b->outlines);
    b->edge_from = malloc(n * sizeof *b->edge_from);
    b->edge_to = malloc(n * sizeof *b->edge_to);
    b->leaving = malloc(n * sizeof *b->leaving);
    b->next = malloc(3 * n * sizeof *b->next);
    b->previous = malloc(3 * n * sizeof *b->previous);
    b->ear = malloc(3 * n * sizeof *b->ear);
    b->pieces = malloc(3 * n * PIECE_CORNERS * sizeof *b->pieces);
    b->sizes = malloc(3 * n * sizeof *b->sizes);
    return b->corners && b->polygon && b->outlines && b->edge_from && b->edge_to && b->leaving && b->next && b->previous &&
           b->ear && b->pieces && b->sizes;
}

static inline double turn(Corner a, Corner b, Corner c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

static double twice_area(const Corner *c, int64_t n) {
    double sum = 0.0;
    for (int64_t i = 1; i + 1 < n; i++) sum += turn(c[0], c[i], c[i + 1]);
    return sum;
}

static void reverse(Corner *c, int64_t begin, int64_t end) {
    for (end--; begin < end; begin++, end--) {
        Corner other = c[begin];
        c[begin] = c[end];
        c[end] = other;
    }
}

/* Drops the corners of an outline that lie on the line of their neighbours; returns how many are left. */
static int64_t straightened(Corner *c, int64_t n) {
    int64_t start = 0, kept = 0;
    for (int64_t i = 1; i < n; i++)
        if (c[i].x < c[start].x - ALIKE || (c[i].x <= c[start].x + ALIKE && c[i].y < c[start].y)) start = i; /* surely a corner */
    reverse(c, 0, start); /* from it on */
    reverse(c, start, n);
    reverse(c, 0, n);
    for (int64_t i = 0; i < n; i++) {
        Corner next = i + 1 == n ? c[0] : c[i + 1];
        if (kept) {
            double dx = next.x - c[kept - 1].x, dy = next.y - c[kept - 1].y, length = sqrt(dx * dx + dy * dy);
            double along = (c[i].x - c[kept - 1].x) * dx + (c[i].y - c[kept - 1].y) * dy;
            if (fabs(turn(c[kept - 1], c[i], next)) <= STRAIGHT * length && along >= 0.0 && along <= length * length) continue;
        }
        c[kept++] = c[i];
    }
    return kept;
}

static int is_inside(Corner p, const Corner *c, int64_t n) {
    int inside = 0;
    for (int64_t i = 0, j = n - 1; i < n; j = i++)
        if ((c[i].y > p.y) != (c[j].y > p.y) && p.x < (c[j].x - c[i].x) * (p.y - c[i].y) / (c[j].y - c[i].y) + c[i].x) inside = !inside;
    return inside;
}

/* The outlines of a patch: edges that run one way only, linked so that the patch lies at their left. Returns their number; -1 where
 * edges do not close, or run the same way twice. */
static int64_t trace_outlines(const Triangles *t, const int32_t *members, int64_t count, Plane plane, Bench *b) {
    int64_t edges = 0, corners = 0, outlines = 0;
    int32_t number = t->patch[members[0]];
    Vec origin = vertex(t, t->corner[3 * members[0]]), right, up;
    right = vcross(plane.normal, fabs(plane.normal.z) < 0.9 ? vec(0.0, 0.0, 1.0) : vec(1.0, 0.0, 0.0));
    right = unit_of(right);
    up = vcross(plane.normal, right);
    for (int64_t m = 0; m < count; m++)
        for (int32_t e = 3 * members[m]; e < 3 * members[m] + 3; e++) {
            int32_t from = half_edge_from(t, e), to = half_edge_to(t, e), other = t->first[edge_place(t, from, to)];
            int along = 0, against = 0, seen = 0;
            for (; other >= 0 && seen < SHARED; other = t->after[other]) {
                if (!same_edge(t, other, from, to)) continue;
                seen++;
                if (t->patch[other / 3] != number) continue;
                along += half_edge_from(t, other) == from;
                against += half_edge_from(t, other) == to;
            }
            if (along != 1 || against > 1 || (seen == SHARED && other >= 0)) return -1;
            if (against) continue;
            b->edge_from[edges] = from;
            b->edge_to[edges++] = to;
        }
    for (int64_t e = 0; e < edges; e++) b->out[b->edge_from[e]] = -1;
    for (int64_t e = edges - 1; e >= 0; e--) {
        b->leaving[e] = b->out[b->edge_from[e]];
        b->out[b->edge_from[e]] = (int32_t)e;
    }
    int64_t used = 0;
    for (int64_t e = 0; e < edges; e++) {
        if (b->edge_from[e] < 0) continue;
        int32_t here = (int32_t)e, start = b->edge_from[e];
        int64_t begin = corners;
        for (;;) {
            int32_t from = b->edge_from[here], to = b->edge_to[here], *link = b->out + from;
            while (*link >= 0 && *link != here && b->work++ < WORK) link = b->leaving + *link;
            if (*link != here) return -1;
            *link = b->leaving[here];
            Vec at = vsub(vertex(t, from), origin);
            Corner corner = {vdot(at, right), vdot(at, up), from};
            b->corners[corners++] = corner;
            b->edge_from[here] = -1;
            used++;
            if (to == start) break;
            Vec came = vsub(vertex(t, to), vertex(t, from));
            double best = -10.0;
            int32_t chosen = -1, tried = 0;
            for (int32_t o = b->out[to]; o >= 0; o = b->leaving[o]) {
                Vec goes = vsub(vertex(t, b->edge_to[o]), vertex(t, to));
                double angle = atan2(vdot(vcross(came, goes), plane.normal), vdot(came, goes)); /* the leftmost keeps the patch */
                if (angle > best) best = angle, chosen = o;
                if (++tried > SHARED) return -1;
            }
            if (chosen < 0) return -1;
            here = chosen;
        }
        int64_t kept = straightened(b->corners + begin, corners - begin);
        corners = begin + kept;
        if (kept < 3) {
            corners = begin;
            continue;
        }
        Outline outline = {begin, corners, twice_area(b->corners + begin, kept), -1};
        b->outlines[outlines++] = outline;
    }
    return used == edges ? outlines : -1;
}

/* Whether the way between two corners crosses no edge of an outline. */
static int sees(Corner a, Corner c, const Corner *at, int64_t n, int64_t *work) {
    *work += n;
    for (int64_t i = 0, j = n - 1; i < n; j = i++) {
        if (at[i].vertex == a.vertex || at[j].vertex == a.vertex || at[i].vertex == c.vertex || at[j].vertex == c.vertex) continue;
        if (turn(a, c, at[i]) * turn(a, c, at[j]) <= 0.0 && turn(at[j], at[i], a) * turn(at[j], at[i], c) <= 0.0) return 0;
    }
    return 1;
}

/* Joins the holes of an outline on it, each by a bridge to the nearest corner that sees it; returns its corners, 0 where one has none. */
static int64_t bridged(Bench *b, int64_t outer_line, int64_t outlines) {
    const Outline *line = b->outlines + outer_line;
    int64_t n = line->end - line->begin;
    memcpy(b->polygon, b->corners + line->begin, (size_t)n * sizeof(Corner));
    for (;;) {
        int64_t hole = -1, tip = -1;
        for (int64_t h = 0; h < outlines; h++) { /* the rightmost hole that is left */
            if (b->outlines[h].within != outer_line) continue;
            b->work += b->outlines[h].end - b->outlines[h].begin;
            for (int64_t i = b->outlines[h].begin; i < b->outlines[h].end; i++)
                if (tip < 0 || b->corners[i].x > b->corners[tip].x) hole = h, tip = i;
        }
        if (hole < 0) return n;
        if (b->work > WORK) return 0;
        Corner from = b->corners[tip];
        int64_t best = -1, size = b->outlines[hole].end - b->outlines[hole].begin;
        double nearest = INFINITY;
        for (int64_t i = 0; i < n; i++) {
            double dx = b->polygon[i].x - from.x, dy = b->polygon[i].y - from.y, away = dx * dx + dy * dy;
            if (away >= nearest) continue;
            int free_way = sees(from, b->polygon[i], b->polygon, n, &b->work);
            for (int64_t h = 0; h < outlines && free_way; h++)
                if (b->outlines[h].within == outer_line)
                    free_way = sees(from, b->polygon[i], b->corners + b->outlines[h].begin, b->outlines[h].end - b->outlines[h].begin, &b->work);
            if (free_way) best = i, nearest = away;
            if (b->work > WORK) return 0;
        }
        if (best < 0) return 0;
        memmove(b->polygon + best + size + 2, b->polygon + best, (size_t)(n - best) * sizeof(Corner));
        for (int64_t i = 0; i <= size; i++) b->polygon[best + 1 + i] = b->corners[b->outlines[hole].begin + (tip - b->outlines[hole].begin + i) % size];
        n += size + 2;
        b->outlines[hole].within = -1;
        b->outlines[hole].area = 0.0;
    }
}

/* Whether corner i of what is left of a polygon is an ear: no other corner lies in its triangle. Negative: it is none; else how
 * good it is, its height over its longest side. */
static double ear_quality(Bench *b, int32_t i) {
    Corner a = b->polygon[b->previous[i]], c = b->polygon[i], d = b->polygon[b->next[i]];
    double area = turn(a, c, d), longest = 0.0;
    if (!(area > 1e-12)) return -1.0;
    for (int32_t j = b->next[b->next[i]]; j != b->previous[i]; j = b->next[j]) {
        Corner p = b->polygon[j];
        b->work++;
        if (p.vertex == a.vertex || p.vertex == c.vertex || p.vertex == d.vertex) continue;
        if (turn(a, c, p) >= -1e-12 && turn(c, d, p) >= -1e-12 && turn(d, a, p) >= -1e-12) return -1.0;
    }
    Corner ring[4] = {a, c, d, a};
    for (int k = 0; k < 3; k++) {
        double dx = ring[k + 1].x - ring[k].x, dy = ring[k + 1].y - ring[k].y;
        longest = larger(longest, dx * dx + dy * dy);
    }
    return area / longest;
}

/* Triangles of a polygon (n corners), added to those of the patch from `made` on; returns how many there are then, -1 where some
 * of it is left. */
static int64_t clip_ears(Bench *b, int64_t n, int64_t made, double *quality) {
    for (int32_t i = 0; i < n; i++) {
        b->next[i] = i + 1 == n ? 0 : i + 1;
        b->previous[i] = i ? i - 1 : (int32_t)n - 1;
    }
    for (int32_t i = 0; i < n; i++) quality[i] = ear_quality(b, i);
    int32_t start = 0;
    for (; n >= 3; n--) {
        int32_t best = -1, i = start;
        do {
            if (quality[i] > 0.0 && (best < 0 || quality[i] > quality[best] + ALIKE)) best = i;
            i = b->next[i];
            b->work++;
        } while (i != start);
        if (b->work > WORK) return -1;
        if (best < 0) { /* what is left is flat, or the outline crosses itself: the areas will tell */
            int32_t flat = start;
            double least = INFINITY;
            i = start;
            do {
                double area = fabs(turn(b->polygon[b->previous[i]], b->polygon[i], b->polygon[b->next[i]]));
                if (area < least) least = area, flat = i;
                i = b->next[i];
            } while (i != start);
            best = flat;
        } else {
            int32_t *piece = b->pieces + made * PIECE_CORNERS;
            piece[0] = b->polygon[b->previous[best]].vertex;
            piece[1] = b->polygon[best].vertex;
            piece[2] = b->polygon[b->next[best]].vertex;
            b->sizes[made++] = 3;
        }
        int32_t before = b->previous[best], after = b->next[best];
        b->next[before] = after;
        b->previous[after] = before;
        start = after;
        if (n > 3) {
            quality[before] = ear_quality(b, before);
            quality[after] = ear_quality(b, after);
        }
    }
    return made;
}

/* An edge between two pieces, and how long it is. */
typedef struct {
    double length;
    int32_t from, to, piece;
} Joint;

static int by_ends(const void *first, const void *second) {
    const Joint *a = first, *b = second;
    int32_t a_low = a->from < a->to ? a->from : a->to, b_low = b->from < b->to ? b->from : b->to;
    int32_t a_high = a->from < a->to ? a->to : a->from, b_high = b->from < b->to ? b->to : b->from;
    if (a_low != b_low) return a_low < b_low ? -1 : 1;
    if (a_high != b_high) return a_high < b_high ? -1 : 1;
    return a->piece < b->piece ? -1 : a->piece > b->piece;
}

typedef struct {
    double length;
    int32_t from, to, one, other;
} Diagonal;

static int longest_first(const void *first, const void *second) {
    const Diagonal *a = first, *b = second;
    if (a->length != b->length) return a->length > b->length ? -1 : 1;
    return a->one != b->one ? (a->one < b->one ? -1 : 1) : a->other < b->other ? -1 : a->other > b->other;
}

static int32_t root_of(int32_t *joined, int32_t piece) {
    while (joined[piece] != piece) piece = joined[piece] = joined[joined[piece]];
    return piece;
}

/* The piece that two make across the edge (from, to) of the first one; 0 where it is not convex or has too many corners. */
static int joined_piece(const Triangles *t, Vec normal, const int32_t *one, int n, const int32_t *other, int m, int32_t from,
                        int32_t to, int32_t *result) {
    int i = 0, j = 0, count = 0;
    if (n + m - 2 > PIECE_CORNERS) return 0;
    while (i < n && !(one[i] == from && one[(i + 1) % n] == to)) i++;
    while (j < m && !(other[j] == to && other[(j + 1) % m] == from)) j++;
    if (i == n || j == m) return 0;
    for (int k = 1; k <= n; k++) result[count++] = one[(i + k) % n];        /* to ... from */
    for (int k = 2; k < m; k++) result[count++] = other[(j + k) % m];       /* what lies beyond */
    for (int k = 0; k < count; k++) {
        for (int l = 0; l < k; l++)
            if (result[l] == result[k]) return 0;
        Vec a = vertex(t, result[(k + count - 1) % count]), c = vertex(t, result[k]), d = vertex(t, result[(k + 1) % count]);
        if (vdot(vcross(vsub(c, a), vsub(d, c)), normal) < -1e-9) return 0;
    }
    return count;
}

/* Joins triangles of a patch where what they make is convex, across the longest edges first; 0 without memory. */
static int join_pieces(const Triangles *t, Vec normal, Bench *b, int64_t count) {
    Joint *joint = malloc((size_t)(3 * count + 1) * sizeof *joint);
    Diagonal *diagonal = malloc((size_t)(3 * count + 1) * sizeof *diagonal);
    int32_t *joined = malloc((size_t)(count + 1) * sizeof *joined);
    int64_t joints = 0, diagonals = 0;
    if (joint && diagonal && joined) {
        for (int64_t p = 0; p < count; p++) {
            joined[p] = (int32_t)p;
            for (int k = 0; k < 3; k++) {
                const int32_t *piece = b->pieces + p * PIECE_CORNERS;
                Joint edge = {size_of(vsub(vertex(t, piece[k]), vertex(t, piece[(k + 1) % 3]))), piece[k], piece[(k + 1) % 3], (int32_t)p};
                joint[joints++] = edge;
            }
        }
        qsort(joint, (size_t)joints, sizeof *joint, by_ends);
        for (int64_t i = 0; i + 1 < joints; i++) {
            if (joint[i].from != joint[i + 1].to || joint[i].to != joint[i + 1].from) continue;
            Diagonal edge = {floor(joint[i].length / ALIKE + 0.5), joint[i].from, joint[i].to, joint[i].piece, joint[i + 1].piece};
            diagonal[diagonals++] = edge;
            i++;
        }
        qsort(diagonal, (size_t)diagonals, sizeof *diagonal, longest_first);
        for (int64_t i = 0; i < diagonals; i++) {
            int32_t one = root_of(joined, diagonal[i].one), other = root_of(joined, diagonal[i].other), result[2 * PIECE_CORNERS];
            if (one == other) continue;
            int32_t *first = b->pieces + (int64_t)one * PIECE_CORNERS, *second = b->pieces + (int64_t)other * PIECE_CORNERS;
            int n = joined_piece(t, normal, first, b->sizes[one], second, b->sizes[other], diagonal[i].from, diagonal[i].to, result);
            if (!n) continue;
            memcpy(first, result, (size_t)n * sizeof *first);
            b->sizes[one] = n;
            b->sizes[other] = 0;
            joined[other] = one;
        }
    }
    int sound = joint && diagonal && joined;
    free(joint);
    free(diagonal);
    free(joined);
    return sound;
}

/* Cuts a patch into convex pieces; returns how many there are in the bench, some of size 0; 0 where it stays as its triangles, and
 * NO_MEMORY. */
static int64_t cut_patch(const Triangles *t, const int32_t *members, int64_t count, Bench *b) {
    Plane plane = {normal_of(t, members[0]), 0.0};
    double whole = 0.0, made_area = 0.0;
    int64_t made = 0;
    if (!widen(b, 3 * count)) return NO_MEMORY;
    b->work = 0;
    int64_t outlines = trace_outlines(t, members, count, plane, b);
    if (outlines < 1) return 0;
    for (int64_t h = 0; h < outlines; h++) { /* each hole lies within the smallest outline about it */
        Outline *hole = b->outlines + h;
        if (hole->area > 0.0) continue;
        for (int64_t o = 0; o < outlines; o++) {
            const Outline *about = b->outlines + o;
            b->work += about->end - about->begin;
            if (!(about->area > 0.0) || (hole->within >= 0 && b->outlines[hole->within].area <= about->area)) continue;
            if (is_inside(b->corners[hole->begin], b->corners + about->begin, about->end - about->begin)) hole->within = o;
        }
        if (hole->within < 0 || b->work > WORK) return 0;
    }
    double *quality = malloc(3 * (size_t)b->room * sizeof *quality);
    if (!quality) return NO_MEMORY;
    for (int64_t o = 0; o < outlines && made >= 0; o++) {
        if (!(b->outlines[o].area > 0.0)) continue;
        int64_t corners = bridged(b, o, outlines);
        made = corners ? clip_ears(b, corners, made, quality) : -1;
    }
    free(quality);
    if (made < 1) return 0;
    if (!join_pieces(t, plane.normal, b, made)) return NO_MEMORY;
    for (int64_t m = 0; m < count; m++) whole += t->area[members[m]];
    for (int64_t p = 0; p < made; p++) {
        Vec sum = vec(0.0, 0.0, 0.0), start = vertex(t, b->pieces[p * PIECE_CORNERS]);
        for (int k = 1; k + 1 < b->sizes[p]; k++)
            sum = vadd(sum, vcross(vsub(vertex(t, b->pieces[p * PIECE_CORNERS + k]), start), vsub(vertex(t, b->pieces[p * PIECE_CORNERS + k + 1]), start)));
        made_area += vdot(sum, plane.normal);
    }
    return fabs(made_area - whole) <= larger(SAME_AREA * whole, 1e-9) + 4.0 * OFF_PLANE * OFF_PLANE ? made : 0;
}

#endif
