/* One aspect of convex planar pieces: scattering/physical_optics/plane_echoes.py. An eye is a point: the antenna, its image in the
 * sea, or an image of these in pieces. What an eye lights is what `shade` leaves; bounces are seen by mirrored eyes. Fields are sums
 * over edges (Gordon 1975) away from specular directions, and closed forms of small triangles near them. Dented walls are cut into
 * strips near their normals: plating.py. */

#include "plane_views.h"
#include "triangle_means.h"

static const double TURN = 6.283185307179586; /* 2 pi */
static const double STEEP = 0.05;    /* tangential phase gradient over k, 2 sin of 1.4 degrees, above which edges are summed */
static const double BENT = 3000.0;   /* over wavenumber and path, of its square: nearer by, waves bend too much over the zone of a point */
static const double FLUSH = 1e-3;    /* m: what rises less over a surface is no corner with it */
static const double GRAZING = 0.005; /* sine of the angle at which a beam meets a piece, below which it bounces no further */
static const double ENDS = 20.0;     /* rad along an edge, from which on its two ends stand for it */

/* ------------------------------------------------------------------------------------------------------------------ plating */

enum { STRIPS = 4, MOST_SLABS = 1 << 20 }; /* STRIPS to a panel: over a quarter of it sin^2 is quadratic within 0.003 */

/* Which pieces are plated, as of `PlatedWalls`: axis (P), wall (P), drawn (4, bays, tiers) [m] with the numbers of the first bay and
 * tier. flat, dented: its `zone`. kept (nodes): share of the field of a bounce by cosine, from 0 to 1. own: axes of the body's frame. */
typedef struct Walls {
    int64_t bays, tiers, nodes;
    double frame, tier, flat, dented;
    const int64_t *axis, *wall, *first;
    const double *drawn, *kept;
    Vec own[3];
} Walls;

/* The share of the field that a bounce on a piece keeps. */
static double coherent(const Walls *w, int piece, double facing) {
    if (w->axis[piece] < 0) return 1.0;
    double at = smaller(fabs(facing), 1.0) * (double)(w->nodes - 1);
    int64_t low = at >= 1.0 ? (int64_t)larger(ceil(at) - 1.0, 0.0) : 0;
    return w->kept[low] + (at - (double)low) * (w->kept[low + 1] - w->kept[low]);
}

/* By how many turns the two-way phase of the direct leg changes along a panel, with a sign. */
static double turns_at(const Aspect *a, int piece, Vec point) {
    const Walls *w = a->walls;
    Vec normal = a->scene->plane[piece].normal, way = unit_of(vsub(point, a->view[0].leg.eye));
    double east = vdot(normal, w->own[0]), north = vdot(normal, w->own[1]), level = sqrt(east * east + north * north);
    double along = (vdot(way, w->own[0]) * north - vdot(way, w->own[1]) * east) / level;
    double step = fabs(w->axis[piece] ? east : north) / level;
    return 2.0 * a->out.wavenumber / TURN * w->frame * along / larger(step, 0.5);
}

/* Whether dents count anywhere on a polygon. */
static int is_dented(const Aspect *a, int piece, const Polygon *p) {
    double low = INFINITY, high = -INFINITY;
    if (a->walls->axis[piece] < 0) return 0;
    for (int i = 0; i < p->n; i++) {
        double turns = turns_at(a, piece, p->at[i]);
        low = smaller(low, turns);
        high = larger(high, turns);
    }
    return low < a->walls->flat && high > -a->walls->flat;
}

/* How much of its dents plating has: 1 near the normal, 0 where it is flat. */
static inline double fading(const Walls *w, double turns) {
    double share = smaller(larger((w->flat - fabs(turns)) / (w->flat - w->dented), 0.0), 1.0);
    return share * share * (3.0 - 2.0 * share);
}

static inline int64_t index_of(double number, int64_t most) {
    return number > 0.0 ? number < (double)most ? (int64_t)number : most : 0;
}

/* Slabs of a polygon, between planes at whole heights over `across`, whose normal is a slab's thickness inverted. number: of the
 * next one; left: how many there are from it on. */
typedef struct {
    Plane across;
    double number;
    int64_t left;
} Slabs;

static Slabs slabs_of(const Polygon *p, Vec normal, double offset) {
    Slabs slabs = {{normal, offset}, 0.0, 0};
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < p->n; i++) {
        low = smaller(low, height_over(slabs.across, p->at[i]));
        high = larger(high, height_over(slabs.across, p->at[i]));
    }
    slabs.number = floor(low + THIN);
    slabs.left = index_of(ceil(high - THIN) - slabs.number, MOST_SLABS);
    return slabs;
}

/* Takes the next slab off the rest of a polygon; 0: it is empty. */
static int next_slab(Slabs *slabs, Polygon *rest, Polygon *part) {
    double height[MOST];
    Polygon above;
    Plane top = {slabs->across.normal, slabs->across.offset + ++slabs->number};
    heights_over(top, rest, height);
    int cut = rest->n < MOST ? cut_polygon(rest, height, &above, part) : NOTHING; /* as of `keep_before` */
    if (cut == NOTHING) copy_polygon(part, rest);
    if (cut == ALL) part->n = 0;
    if (cut == PART) copy_polygon(rest, &above);
    return part->n > 2;
}

/* ------------------------------------------------------------------------------------------------------------------- fields */

/* What a path has at a point of its last piece. */
typedef struct {
    Vec point, place, gradient; /* place: where its echo lies; gradient: of the path's length, along the piece */
    double path, steep, weight; /* length [m], square of the gradient, field over surface */
    double begins;              /* height at which it meets the first piece */
    Complex phasor;
} At;

static inline Vec polarized(Vec direction, int64_t level) {
    double flat = sqrt(larger(1.0 - direction.z * direction.z, 1e-24)), east = direction.x / flat, north = direction.y / flat;
    return level ? vec(north, -east, 0.0) : vec(-east * direction.z, -north * direction.z, flat);
}

/* Where a path to a point of its last piece meets its first one. */
static inline Vec first_point(const Scene *scene, const Path *path, Vec point) {
    for (int k = path->n - 1; k >= 0; k--) {
        Plane plane = scene->plane[path->chain[k]];
        Vec way = vsub(point, path->eye[k + 1]);
        point = vadd(path->eye[k + 1], vscale(way, -height_over(plane, path->eye[k + 1]) / vdot(plane.normal, way)));
    }
    return point;
}

/* A length, and what both legs are longer than straight lines. */
static inline double with_detours(double length, const Aspect *a, const Path *path, const View *back, Vec begin, Vec end) {
    double in = detour(&a->view[path->leg].leg, begin), same = !path->n && path->leg == back->level;
    return length + in + (same ? in : detour(&back->leg, end));
}

static double length_at(const Aspect *a, const Path *path, const View *back, Vec point) {
    const Leg *out = &a->view[path->leg].leg;
    double length = size_of(vsub(point, path->eye[path->n])) + size_of(vsub(point, back->leg.eye));
    return isinf(out->earth_radius) ? length : with_detours(length, a, path, back, first_point(a->scene, path, point), point);
}

/* (p . d)(n . E) - (p . E)(n . d): what the current that a field makes on a surface sends back, as received. */
static inline double current(Vec received, Vec direction, Vec field, Vec normal) {
    return vdot(received, direction) * vdot(normal, field) - vdot(received, field) * vdot(normal, direction);
}

static At at_point(const Aspect *a, const Path *path, const View *back, int piece, Vec point) {
    At at;
    const Output *o = &a->out;
    Vec normal = a->scene->plane[piece].normal;
    Vec begin = first_point(a->scene, path, point), eye = path->eye[0];
    Vec in = vsub(point, path->eye[path->n]), away = vsub(point, back->leg.eye), leaves;
    int direct = !path->n, same = direct && path->leg == back->level;
    double in_length = size_of(in), away_length = same ? in_length : size_of(away);
    in = vscale(in, 1.0 / in_length);
    away = same ? in : vscale(away, 1.0 / away_length);
    leaves = direct ? in : unit_of(vsub(begin, eye));
    at.point = at.place = point;
    at.begins = begin.z;
    at.path = in_length + away_length;
    if (path->n) { /* between both ends, behind them by half of what lies between: its range is half the path */
        Vec middle = vscale(vadd(begin, point), 0.5), slope = vscale(vadd(leaves, away), 0.5);
        double missing = (at.path - size_of(vsub(middle, eye)) - size_of(vsub(middle, back->leg.eye))) / 2.0;
        at.place = vadd(middle, vscale(slope, missing / larger(vdot(slope, slope), 1e-3)));
    }
    if (!isinf(back->leg.earth_radius)) at.path += with_detours(0.0, a, path, back, begin, point);
    at.gradient = vadd(in, away);
    at.gradient = vsub(at.gradient, vscale(normal, vdot(normal, at.gradient)));
    at.steep = vdot(at.gradient, at.gradient);
    Vec field = polarized(leaves, o->level), received = same ? field : polarized(away, o->level);
    double kept = path->n ? coherent(a->walls, piece, vdot(in, normal)) : 1.0;
    for (int k = 0; k < path->n; k++) {
        Vec there = a->scene->plane[path->chain[k]].normal;
        kept *= coherent(a->walls, path->chain[k], vdot(leaves, there));
        leaves = reflected(leaves, there);
        field = vscale(reflected(field, there), -1.0);
    }
    at.weight = current(received, in, field, normal);
    if (path->leg != back->level && !path->n) at.weight += current(field, away, received, normal); /* both orders */
    at.weight *= a->wave * kept;
    at.phasor = phasor(-o->wavenumber * at.path);
    return at;
}

static void emit(Output *o, const At *at, Complex amplitude, const Path *path, const View *back) {
    if (o->count < o->room) {
        double *to = o->position + 3 * o->count;
        to[0] = at->place.x;
        to[1] = at->place.y;
        to[2] = at->place.z;
        o->ends[2 * o->count] = at->begins;
        o->ends[2 * o->count + 1] = at->point.z;
        o->amplitude[o->count] = amplitude;
        o->ways[o->count] = path->leg + back->level;
        o->surfaces[o->count] = path->n + 1;
    }
    o->count++;
}

/* Edge over which a field may be taken as linear, where a path has a length. */
static inline double longest_at(const Output *o, double path) {
    return smaller(o->longest, smaller(0.5 * o->wide * path, o->bend * sqrt(0.5 * path)));
}

/* Means over a triangle: paths [m] and their phasors at corners, paths at the middles of the edges opposite to them. */
static void means_of(double k, const double length[3], const Complex at[3], const double middle[3], Complex means[3]) {
    double unordered[3], phases[3], bends[3];
    Complex at_corner[3], ordered[3];
    for (int i = 0; i < 3; i++) unordered[i] = -k * (length[i] - length[0]);
    int first = first_corner(unordered);
    for (int i = 0; i < 3; i++) {
        int c = (first + i) % 3;
        phases[i] = unordered[c];
        at_corner[i] = at[c];
        bends[i] = -k * (middle[c] - 0.5 * (length[(c + 1) % 3] + length[(c + 2) % 3]));
    }
    ordered_means(phases, at_corner, bends, ordered);
    for (int i = 0; i < 3; i++) means[(first + i) % 3] = ordered[i];
}

/* The field of a triangle, in closed form where its edges are short enough, shared by its corners. */
static void triangle_field(Aspect *a, const Path *path, const View *back, int piece, At p, At q, At r, int depth) {
    At corner[3] = {p, q, r};
    Output *o = &a->out;
    double edge[3];
    int longest = 0;
    for (int i = 0; i < 3; i++) {
        Vec e = vsub(corner[(i + 1) % 3].point, corner[i].point);
        edge[i] = vdot(e, e);
        if (edge[i] > edge[longest]) longest = i;
    }
    double most = longest_at(o, p.path);
    if (edge[longest] > most * most && depth < 40) {
        At one = corner[longest], other = corner[(longest + 1) % 3], third = corner[(longest + 2) % 3];
        At middle = at_point(a, path, back, piece, vscale(vadd(one.point, other.point), 0.5));
        triangle_field(a, path, back, piece, one, middle, third, depth + 1);
        triangle_field(a, path, back, piece, middle, other, third, depth + 1);
        return;
    }
    double area = 0.5 * size_of(vcross(vsub(q.point, p.point), vsub(r.point, p.point)));
    double length[3] = {p.path, q.path, r.path}, middle[3];
    Complex at[3] = {p.phasor, q.phasor, r.phasor}, means[3];
    for (int i = 0; i < 3; i++)
        middle[i] = length_at(a, path, back, vscale(vadd(corner[(i + 1) % 3].point, corner[(i + 2) % 3].point), 0.5));
    means_of(o->wavenumber, length, at, middle, means);
    for (int i = 0; i < 3; i++) emit(o, corner + i, turned(scaled(means[i], corner[i].weight * area), -1.0), path, back);
}

/* A part of a dented wall, and the panel of one of its strips: values at three corners, which those of points follow by their shares
 * of the three; the flat path quadratically, by its sags at the middles between corners (times 4). */
typedef struct {
    double area; /* of the triangle between the corners */
    Vec path, sag, turns, facing, bay, tier, weight;
    double frame, low, high; /* where the panel begins, and its largest depths at whole numbers of `tier`, 0 and 1 */
} Block;

/* Lengths at points of a panel (count) of these shares. */
static void dented_paths(const Walls *w, const Block *b, int count, const Vec *at, double *length) {
    double phase[3 * MOST];
    Complex turn[3 * MOST];
    for (int i = 0; i < count; i++) phase[i] = 0.5 * TURN * (vdot(at[i], b->bay) - b->frame);
    phasors_of(count, phase, turn);
    for (int i = 0; i < count; i++) {
        Vec share = at[i];
        double sag = share.y * share.z * b->sag.x + share.z * share.x * b->sag.y + share.x * share.y * b->sag.z;
        double sine = turn[i].im, depth = b->low + vdot(share, b->tier) * (b->high - b->low);
        length[i] = vdot(share, b->path) + sag + vdot(share, b->facing) * fading(w, vdot(share, b->turns)) * depth * sine * sine;
    }
}

/* Adds to the fields of the corners what a strip of a block gives. */
static void strip_field(const Aspect *a, const Block *b, const Polygon *strip, Complex sum[3]) {
    int n = strip->n, points = n; /* corners, and from n on the middles between the first and each, then between neighbours */
    double length[3 * MOST], phase[MOST], k = a->out.wavenumber;
    Vec share[3 * MOST];
    Complex at[MOST], of_corner[MOST], means[3];
    memcpy(share, strip->at, (size_t)n * sizeof(Vec));
    for (int i = 1; i < n; i++) share[points++] = vscale(vadd(share[0], share[i]), 0.5);
    for (int i = 1; i + 1 < n; i++) share[points++] = vscale(vadd(share[i], share[i + 1]), 0.5);
    dented_paths(a->walls, b, points, share, length);
    for (int i = 0; i < n; i++) {
        of_corner[i] = complex_of(0.0, 0.0);
        phase[i] = -k * length[i];
    }
    phasors_of(n, phase, at);
    for (int i = 1; i + 1 < n; i++) {
        double lengths[3] = {length[0], length[i], length[i + 1]}, middle[3] = {length[2 * n - 2 + i], length[n + i], length[n + i - 1]};
        Complex phasors[3] = {at[0], at[i], at[i + 1]};
        double area = b->area * fabs(vdot(share[0], vcross(share[i], share[i + 1])));
        means_of(k, lengths, phasors, middle, means);
        of_corner[0] = plus(of_corner[0], scaled(means[0], area));
        of_corner[i] = plus(of_corner[i], scaled(means[1], area));
        of_corner[i + 1] = plus(of_corner[i + 1], scaled(means[2], area));
    }
    for (int i = 0; i < strip->n; i++) {
        Vec share = vscale(strip->at[i], vdot(strip->at[i], b->weight));
        sum[0] = plus(sum[0], scaled(of_corner[i], share.x));
        sum[1] = plus(sum[1], scaled(of_corner[i], share.y));
        sum[2] = plus(sum[2], scaled(of_corner[i], share.z));
    }
}

/* The field of a block of a dented wall, strip by strip, shared by the first of its corners and two that span most with it.
 * below: the middle of a tier from which on its depths are linear up to the next. */
static void block_field(Aspect *a, const Path *path, const View *back, int piece, const Polygon *p, double below) {
    const Walls *w = a->walls;
    Vec normal = a->scene->plane[piece].normal, point[3] = {p->at[0], p->at[1], p->at[2]}, along = w->own[w->axis[piece]], span = vec(0.0, 0.0, 0.0);
    for (int i = 1; i < p->n; i++)
        for (int j = i + 1; j < p->n; j++) {
            Vec other = vcross(vsub(p->at[i], point[0]), vsub(p->at[j], point[0]));
            if (vdot(other, other) <= vdot(span, span)) continue;
            span = other;
            point[1] = p->at[i];
            point[2] = p->at[j];
        }
    At at[3];
    double value[7][3];
    for (int i = 0; i < 3; i++) at[i] = at_point(a, path, back, piece, point[i]);
    for (int i = 0; i < 3; i++) {
        int one = (i + 1) % 3, other = (i + 2) % 3;
        Vec in = unit_of(vsub(point[i], path->eye[0])), away = unit_of(vsub(point[i], back->leg.eye));
        double mean = 0.5 * (at[one].path + at[other].path);
        value[0][i] = at[i].path;
        value[1][i] = 4.0 * (length_at(a, path, back, vscale(vadd(point[one], point[other]), 0.5)) - mean);
        value[2][i] = turns_at(a, piece, point[i]);
        value[3][i] = fabs(vdot(in, normal)) + fabs(vdot(away, normal));
        value[4][i] = vdot(along, point[i]) / w->frame;
        value[5][i] = vdot(w->own[2], point[i]) / w->tier - 0.5 - below;
        value[6][i] = at[i].weight;
    }
    Block b = {.area = 0.5 * size_of(span)};
    Vec *to[7] = {&b.path, &b.sag, &b.turns, &b.facing, &b.bay, &b.tier, &b.weight};
    for (int i = 0; i < 7; i++) *to[i] = vec(value[i][0], value[i][1], value[i][2]);
    Polygon shares, strip;
    shares.n = p->n;
    for (int i = 0; i < p->n; i++) {
        Vec offset = vscale(vsub(p->at[i], point[0]), 1.0 / vdot(span, span));
        double one = vdot(span, vcross(offset, vsub(point[2], point[0]))), other = vdot(span, vcross(vsub(point[1], point[0]), offset));
        shares.at[i] = vec(1.0 - one - other, one, other);
    }
    Complex sum[3] = {{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}};
    Slabs strips = slabs_of(&shares, vscale(b.bay, STRIPS), 0.0);
    for (a->lit.work += strips.left; strips.left > 0 && !is_worn_out(a); strips.left--) {
        b.frame = floor(strips.number / STRIPS);
        if (!next_slab(&strips, &shares, &strip)) continue;
        int64_t bay = index_of(b.frame - (double)w->first[0], w->bays - 1), tier = index_of(below - (double)w->first[1], w->tiers - 2);
        const double *drawn = w->drawn + (w->wall[piece] * w->bays + bay) * w->tiers + tier;
        b.low = drawn[0];
        b.high = drawn[1];
        strip_field(a, &b, &strip, sum);
    }
    for (int i = 0; i < 3; i++) emit(&a->out, at + i, turned(sum[i], -1.0), path, back);
}

/* What the field at an edge is over its length, over the phasor; outward: across the edge, along the piece. */
static inline double edge_weight(const At *at, Vec outward, double k) { return at->weight * vdot(outward, at->gradient) / (k * at->steep); }

/* The field of a region by its edges; 0 where a specular point may be too near. */
static int edge_fields(Aspect *a, const Path *path, const View *back, int piece, const Polygon *p, const At *at) {
    Output *o = &a->out;
    Vec normal = a->scene->plane[piece].normal;
    double k = o->wavenumber;
    Complex sum[MOST];
    for (int i = 0; i < p->n; i++) {
        if (at[i].steep < larger(STEEP * STEEP, BENT / (k * at[i].path)) || vdot(at[i].gradient, at[0].gradient) < 0.5 * at[0].steep) return 0;
        sum[i] = complex_of(0.0, 0.0);
    }
    for (int i = 0; i < p->n; i++) {
        int j = i + 1 == p->n ? 0 : i + 1;
        Vec along = vsub(p->at[j], p->at[i]);
        double length = size_of(along);
        if (length < 1e-9) continue;
        along = vscale(along, 1.0 / length);
        Vec outward = vcross(along, normal);
        double here = edge_weight(at + i, outward, k), there = edge_weight(at + j, outward, k);
        double turn_here = -k * vdot(at[i].gradient, along), turn_there = -k * vdot(at[j].gradient, along);
        double least = smaller(fabs(turn_here), fabs(turn_there));
        if (turn_here * turn_there > 0.0 && least * length > ENDS && fabs(turn_there - turn_here) < 0.02 * least * least * length) {
            sum[j] = plus(sum[j], turned(scaled(at[j].phasor, there / turn_there), -1.0));
            sum[i] = plus(sum[i], turned(scaled(at[i].phasor, here / turn_here), 1.0));
            continue;
        }
        int parts = (int)ceil(length / longest_at(o, at[i].path));
        double step = length / parts;
        At before = at[i];
        Complex carried = complex_of(0.0, 0.0);
        for (int s = 1; s <= parts; s++) {
            int last = s == parts;
            At next = last ? at[j] : at_point(a, path, back, piece, vadd(p->at[i], vscale(along, step * s)));
            double bend = -k * (length_at(a, path, back, vscale(vadd(before.point, next.point), 0.5)) - 0.5 * (before.path + next.path));
            EdgeMoments e = edge_moments(-k * (next.path - before.path), before.phasor, next.phasor);
            Complex half = scaled(times(bubble_of(bend), e.bubble), 0.5);
            double low = edge_weight(&before, outward, k), high = edge_weight(&next, outward, k);
            Complex to_before = scaled(plus(minus(e.plain, e.toward), half), low * step);
            Complex to_next = scaled(plus(e.toward, half), high * step);
            if (s == 1)
                sum[i] = plus(sum[i], to_before);
            else
                emit(o, &before, plus(carried, to_before), path, back);
            carried = to_next;
            before = next;
        }
        sum[j] = plus(sum[j], carried);
    }
    for (int i = 0; i < p->n; i++) emit(o, at + i, sum[i], path, back);
    return 1;
}

static void flat_field(Aspect *a, const Path *path, const View *back, int piece, const Polygon *p) {
    At at[MOST];
    for (int i = 0; i < p->n; i++) at[i] = at_point(a, path, back, piece, p->at[i]);
    if (edge_fields(a, path, back, piece, p, at)) return;
    for (int i = 1; i + 1 < p->n; i++) triangle_field(a, path, back, piece, at[0], at[i], at[i + 1], 0);
}

/* The field of a region of a dented wall, cut where depths bend, and into blocks of whole strips over which fields are linear. */
static void dented_field(Aspect *a, const Path *path, const View *back, int piece, const Polygon *p) {
    const Walls *w = a->walls;
    double longest = a->out.longest, rows = larger(floor(w->tier / longest + 0.5), 1.0), strips = larger(floor(STRIPS * longest / w->frame), 1.0);
    Slabs levels = slabs_of(p, vscale(w->own[2], rows / w->tier), 0.5 * rows);
    Polygon rest, level, block;
    copy_polygon(&rest, p);
    for (; levels.left > 0 && !is_worn_out(a); levels.left--) {
        double below = floor(levels.number / rows);
        if (!next_slab(&levels, &rest, &level)) continue;
        Slabs blocks = slabs_of(&level, vscale(w->own[w->axis[piece]], STRIPS / (w->frame * strips)), 0.0);
        for (a->lit.work += blocks.left; blocks.left > 0 && !is_worn_out(a); blocks.left--) {
            if (!next_slab(&blocks, &level, &block) || area_of(&block) < SPECK) continue;
            if (is_dented(a, piece, &block))
                block_field(a, path, back, piece, &block, below);
            else
                flat_field(a, path, back, piece, &block);
        }
    }
}

/* The fields of regions on a piece, lit along a path and seen from a view. */
static void radiate(Aspect *a, const Regions *list, const Path *path, const View *back, int piece) {
    for (int64_t k = 0; k < list->n; k++) {
        int dented = !path->n && is_dented(a, piece, list->at + k);
        (dented ? dented_field : flat_field)(a, path, back, piece, list->at + k);
    }
}

/* ------------------------------------------------------------------------------------------------------------------- bounds */

/* What the field of a region has at most [m]: that of its surface, or of its edges over the gradient of the phase. Dents scatter
 * along their wall, so that of a dented one the gradient upward counts alone. */
static double most_field(const Aspect *a, const Polygon *p, Vec eye, Vec back, Vec normal, int dented) {
    Vec middle = middle_of(p), in = unit_of(vsub(middle, eye)), away = unit_of(vsub(middle, back)), g = vadd(in, away);
    double radius = 0.0, edges = 0.0, k = a->out.wavenumber;
    g = vsub(g, vscale(normal, vdot(g, normal)));
    if (dented) {
        Vec level = unit_of(vcross(normal, a->walls->own[2]));
        g = vsub(g, vscale(level, vdot(g, level)));
    }
    for (int i = 0; i < p->n; i++) radius = larger(radius, size_of(vsub(p->at[i], middle)));
    double slack = radius * (1.0 / size_of(vsub(middle, eye)) + 1.0 / size_of(vsub(middle, back))), steep = size_of(g) - slack;
    double area = area_of(p);
    if (steep < 1e-3) return a->wave * area;
    for (int i = 0; i < p->n; i++) {
        Vec along = vsub(p->at[i + 1 == p->n ? 0 : i + 1], p->at[i]);
        double length = size_of(along);
        if (length < 1e-9) continue;
        double turn = k * (fabs(vdot(along, g)) / length - slack);
        edges += turn * length > 2.0 ? 2.0 / turn : length;
    }
    return a->wave * smaller(area, edges / (k * steep));
}

/* The same of all regions on a piece for rays that come about a direction: by its surface and the length of its edges. */
static inline int may_count(Vec direction, Vec ahead, Vec normal, double reach, double slack) {
    Vec g = vadd(direction, ahead);
    double along = vdot(g, normal), square = vdot(g, g) - along * along, far = reach + slack;
    return far > 0.0 && square <= far * far;
}

/* ------------------------------------------------------------------------------------------------------------------ aspects */

static enum Seen seen_by(Aspect *a, View *view, int piece, double water) {
    if (view->seen[piece] != UNKNOWN) return (enum Seen)view->seen[piece];
    Polygon whole = piece_of(a->scene, piece);
    double area = area_of(&whole);
    a->kept.n = 0;
    if (!is_covered(a, view, &whole, piece, water)) {
        add_region(&a->kept, &whole);
        hide(a, &a->kept, view, &whole, piece, NULL, water);
        if (!a->kept.n && view->told) view->hider = view->telling[view->told - 1];
    }
    int is_whole = a->kept.n == 1 && a->kept.at[0].n == whole.n && fabs(area_of(a->kept.at) - area) <= 1e-12 * area;
    view->seen[piece] = (signed char)(a->kept.n == 0 ? HIDDEN : is_whole ? WHOLE : PARTLY);
    if (view->seen[piece] == PARTLY) remember(view, piece, &a->kept);
    return (enum Seen)view->seen[piece];
}

static void single_fields(Aspect *a, double water) {
    for (int piece = 0; piece < a->scene->n; piece++) {
        Polygon whole = piece_of(a->scene, piece);
        Vec normal = a->scene->plane[piece].normal;
        int dented = is_dented(a, piece, &whole);
        for (int s = 0; s < a->legs && whole.n; s++) {
            View *view = &a->view[s], *mixed = s == 0 && a->legs > 1 ? &a->view[1] : NULL;
            if (view->seen[piece] == BACK) continue;
            if (mixed && mixed->seen[piece] == BACK) mixed = NULL;
            Vec eye = view->leg.eye;
            int own = most_field(a, &whole, eye, eye, normal, dented) >= a->skip;
            if (mixed && 2.0 * most_field(a, &whole, eye, mixed->leg.eye, normal, dented) < a->skip) mixed = NULL;
            if (!own && !mixed) continue;
            enum Seen seen = seen_by(a, view, piece, water);
            if (seen == HIDDEN) continue;
            Path path = {0, {0, 0}, s, {eye, eye, eye}};
            a->lit.n = 0;
            if (seen == WHOLE) add_region(&a->lit, &whole);
            if (seen == PARTLY) parts_of(a, &a->lit, view, &whole, piece, water);
            if (own) radiate(a, &a->lit, &path, view, piece);
            if (!mixed || seen_by(a, mixed, piece, water) == HIDDEN) continue;
            if (mixed->seen[piece] == PARTLY) hide(a, &a->lit, mixed, &whole, piece, NULL, water);
            radiate(a, &a->lit, &path, mixed, piece);
        }
    }
}

/* Where rays from an eye to a region cross a plane. */
static Polygon window_of(const Polygon *region, Vec eye, Plane plane) {
    Polygon window;
    double above = -height_over(plane, eye);
    window.n = region->n;
    for (int i = 0; i < region->n; i++) {
        Vec way = vsub(region->at[i], eye);
        window.at[i] = vadd(eye, vscale(way, above / vdot(plane.normal, way)));
    }
    return window;
}

/* What of a piece a beam lights; 0: nothing, or none that rises over the piece that the beam comes from: outlines of neighbours
 * may overlap by as much as pieces are off their planes. */
static int lit_part(const Scene *scene, int piece, const Beam *beam, Polygon *part) {
    double rise = 0.0;
    const Vec *corner = scene->corner + scene->first[piece];
    int corners = scene->first[piece + 1] - scene->first[piece], cuts[MOST + 2], count = 0;
    for (int k = beam->n - 1; k >= 0; k--) {
        int any = 0, all = 1;
        for (int i = 0; i < corners; i++) {
            double height = height_over(beam->at[k], corner[i]);
            any |= height > THIN;
            all &= height >= -THIN;
        }
        if (!any) return 0;
        if (!all) cuts[count++] = k;
    }
    if (passes_by(beam, corner, corners)) return 0;
    part->n = corners;
    memcpy(part->at, corner, (size_t)corners * sizeof(Vec));
    while (count--) /* the plane beyond first */
        if (!keep_before(part, beam->at[cuts[count]])) return 0;
    for (int i = 0; i < part->n; i++) rise = larger(rise, height_over(beam->at[0], part->at[i]));
    return part->n > 2 && rise > FLUSH && area_of(part) > SPECK;
}

/* What returns by each leg from a region at the end of a path. The same way the other way round is a path of its own: its currents
 * are on the other end, and differ by a few percent. `wanted`: bits of legs. */
static void bounce_fields(Aspect *a, const Path *path, int last, const Polygon *region, int wanted, double water) {
    const Scene *scene = a->scene;
    Vec normal = scene->plane[last].normal, eye = path->eye[path->n];
    int made = 0;
    for (int r = 0; r < a->legs; r++) {
        View *back = &a->view[r];
        if (!(wanted >> r & 1) || most_field(a, region, eye, back->leg.eye, normal, 0) < a->bounce_skip) continue;
        if (seen_by(a, back, last, water) == HIDDEN) continue;
        if (!made) {
            View *out = &a->view[path->leg];
            Polygon window[3];
            window[path->n] = *region;
            for (int k = path->n - 1; k >= 0; k--) window[k] = window_of(&window[k + 1], path->eye[k + 1], scene->plane[path->chain[k]]);
            a->lit.n = 0;
            add_region(&a->lit, region);
            if (seen_by(a, out, path->chain[0], water) == PARTLY) hide(a, &a->lit, out, window, path->chain[0], path, water);
            for (int k = 0; k < path->n && a->lit.n; k++) {
                int to = k + 1 < path->n ? path->chain[k + 1] : last;
                hide_between(a, &a->lit, path->chain[k], to, &window[k + 1], path->eye[k + 1], k + 1 < path->n ? path : NULL);
            }
            made = 1;
        }
        if (!a->lit.n) return;
        if (back->seen[last] == WHOLE) {
            radiate(a, &a->lit, path, back, last);
        } else {
            copy_regions(&a->kept, &a->lit);
            hide(a, &a->kept, back, region, last, NULL, water);
            radiate(a, &a->kept, path, back, last);
        }
    }
}

/* Narrows a window, a piece that an eye sees in part, to a box about what it sees. */
static void narrow(Aspect *a, View *view, int piece, Polygon *window, double water) {
    Vec along = unit_of(vsub(window->at[1], window->at[0])), axes[2] = {along, vcross(a->scene->plane[piece].normal, along)};
    parts_of(a, &a->kept, view, window, piece, water);
    for (int side = 0; side < 4; side++) {
        Plane end = {vscale(axes[side / 2], side % 2 ? 1.0 : -1.0), INFINITY};
        for (int64_t k = 0; k < a->kept.n; k++)
            for (int i = 0; i < a->kept.at[k].n; i++) end.offset = smaller(end.offset, vdot(end.normal, a->kept.at[k].at[i]));
        if (a->kept.n) keep_before(window, end);
    }
}

static void bounces(Aspect *a, const double *reach, double water) {
    const Scene *scene = a->scene;
    for (int s = 0; s < a->legs; s++) {
        View *out = &a->view[s];
        double slack = 2.0 * scene->radius / size_of(vsub(scene->middle, out->leg.eye));
        for (int one = 0; one < scene->n; one++) {
            if (is_worn_out(a) || out->seen[one] == BACK || seen_by(a, out, one, water) == HIDDEN) continue;
            Plane mirror = scene->plane[one];
            Path path = {1, {one, 0}, s, {out->leg.eye, mirrored(out->leg.eye, mirror), out->leg.eye}};
            Vec direction = reflected(out->leg.ahead, mirror.normal);
            Polygon window = piece_of(scene, one);
            if (out->seen[one] == PARTLY) narrow(a, out, one, &window, water);
            if (window.n < 3) continue;
            Beam beam = beam_through(&window, path.eye[1], mirror);
            int count = all_in_beam(&a->tree, scene, &beam, a->from_first);
            a->lit.work += count;
            for (int i = 0; i < count && !is_worn_out(a); i++) {
                int two = a->from_first[i], wanted = 0;
                if (two == one || height_over(scene->plane[two], path.eye[1]) <= THIN) continue;
                for (int r = 0; r < a->legs; r++)
                    if (a->view[r].seen[two] > HIDDEN && may_count(direction, a->view[r].leg.ahead, scene->plane[two].normal, reach[two], slack))
                        wanted |= 1 << r;
                if (!wanted && (a->bounces < 3 || isinf(reach[two]))) continue; /* as faint ones bounce no further */
                Polygon region;
                if (!lit_part(scene, two, &beam, &region)) continue;
                Vec in = unit_of(vsub(region.at[0], path.eye[1]));
                double facing = fabs(vdot(in, scene->plane[two].normal));
                if (wanted) bounce_fields(a, &path, two, &region, wanted, water);
                if (a->bounces < 3 || facing < GRAZING || 1.5 * a->wave * area_of(&region) * facing < a->bounce_skip) continue;
                Plane second = scene->plane[two];
                Path longer = {2, {one, two}, s, {path.eye[0], path.eye[1], mirrored(path.eye[1], second)}};
                Vec onward = reflected(direction, second.normal);
                Beam narrow = beam_through(&region, longer.eye[2], second);
                int further = all_in_beam(&a->tree, scene, &narrow, a->from_second);
                a->lit.work += further;
                for (int j = 0; j < further && !is_worn_out(a); j++) {
                    int three = a->from_second[j], some = 0;
                    if (three == two || height_over(scene->plane[three], longer.eye[2]) <= THIN) continue;
                    for (int r = 0; r < a->legs; r++)
                        if (a->view[r].seen[three] > HIDDEN && may_count(onward, a->view[r].leg.ahead, scene->plane[three].normal, reach[three], slack))
                            some |= 1 << r;
                    Polygon end;
                    if (some && lit_part(scene, three, &narrow, &end)) bounce_fields(a, &longer, three, &end, some, water);
                }
            }
        }
    }
}

/* One aspect, and its result. Of a body: `pieces`, first (P + 1), corner (C, 3) [m], normal (P, 3), patch (P) as of `planar_pieces`,
 * one-sided. legs: 1 or 2, of each eye (legs, 3) and by_sea (legs). bounces: surfaces in a row. level: whether the polarization is
 * "h". position, antenna (3), cosine, sine, earth_radius: as of `leg_rays`. water: height of the sea; -inf: there is none. skip,
 * bounce_skip: fields that are left out [m]. Edges over which fields are linear: longest [m], wide times the distance, and bend
 * times its root [m]. screens: triangles screen (S, 3, 3) of other bodies, from screen_first (legs + 1) on of each leg. most_work:
 * after so many cuts and pairs of pieces all else is left out; work (1): how many there were. place (room, 3), ends (room, 2):
 * heights at the first and the last piece [m], amplitude (room) with the phase of the whole path, ways (room) by the sea, surfaces
 * (room) in a row. From bays to kept: as of `Walls`; rotation (3, 3): of the frame from the body's own. */
typedef struct {
    int64_t pieces, legs, bounces, level, most_work, room;
    double water, wavelength, longest, wide, bend, skip, bounce_skip;
    const int64_t *first;
    const double *corner, *normal;
    const int64_t *patch;
    const double *eye;
    const int64_t *by_sea;
    const int64_t *screen_first;
    const double *screen, *position, *antenna;
    double cosine, sine, earth_radius;
    int64_t bays, tiers, nodes;
    double frame, tier, flat, dented;
    const int64_t *axis, *wall, *first_panel;
    const double *drawn, *kept, *rotation;
    double *place, *ends;
    Complex *amplitude;
    int64_t *ways, *surfaces, *work;
} PlaneAspect;

/* What rises above the water of pieces; 0 without memory. */
static int dry_scene(Scene *scene, const PlaneAspect *of) {
    int64_t pieces = of->pieces;
    const int64_t *first = of->first;
    const double *corner = of->corner, *normal = of->normal, water = of->water;
    Plane sea = {vec(0.0, 0.0, 1.0), water};
    Vec low = vec(INFINITY, INFINITY, INFINITY), high = vec(-INFINITY, -INFINITY, -INFINITY);
    memset(scene, 0, sizeof *scene);
    scene->n = (int)pieces;
    scene->patch = of->patch;
    scene->first = malloc(sizeof(int) * (size_t)(pieces + 1));
    size_t corners = (size_t)pieces + 1; /* the water adds one to each piece */
    for (int64_t i = 0; i < pieces; i++) corners += first[i + 1] > first[i] ? (size_t)(first[i + 1] - first[i]) : 0;
    scene->corner = malloc(sizeof(Vec) * corners);
    scene->plane = malloc(sizeof(Plane) * (size_t)(pieces + 1));
    if (!scene->first || !scene->corner || !scene->plane) return 0;
    scene->first[0] = 0;
    for (int64_t i = 0; i < pieces; i++) {
        Polygon p;
        p.n = 0;
        for (int64_t k = first[i]; k < first[i + 1] && p.n < MOST - 2; k++) p.at[p.n++] = vec(corner[3 * k], corner[3 * k + 1], corner[3 * k + 2]);
        scene->plane[i].normal = vec(normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]);
        scene->plane[i].offset = vdot(scene->plane[i].normal, middle_of(&p));
        if (!isinf(water) && !keep_before(&p, sea)) p.n = 0;
        memcpy(scene->corner + scene->first[i], p.at, (size_t)p.n * sizeof(Vec));
        scene->first[i + 1] = scene->first[i] + p.n;
        for (int k = 0; k < p.n; k++) {
            low = vec(smaller(low.x, p.at[k].x), smaller(low.y, p.at[k].y), smaller(low.z, p.at[k].z));
            high = vec(larger(high.x, p.at[k].x), larger(high.y, p.at[k].y), larger(high.z, p.at[k].z));
        }
    }
    if (low.x > high.x) low = high = vec(0.0, 0.0, 0.0);
    scene->middle = vscale(vadd(low, high), 0.5);
    scene->radius = 0.5 * size_of(vsub(high, low));
    return 1;
}

/* How steep the phase over a piece may be so that the field of its surface, or of its edges, still counts. */
static void reach_of_pieces(const Aspect *a, double *reach) {
    for (int i = 0; i < a->scene->n; i++) {
        Polygon p = piece_of(a->scene, i);
        double edges = 0.0;
        for (int k = 0; k < p.n; k++) edges += size_of(vsub(p.at[k + 1 == p.n ? 0 : k + 1], p.at[k]));
        int faint = p.n < 3 || 2.0 * a->wave * area_of(&p) < a->bounce_skip;
        reach[i] = faint ? -INFINITY : 2.0 * a->wave * edges / (a->out.wavenumber * a->bounce_skip);
    }
}

/* The echoes of one aspect; returns how many there are, of which `room` are in the result. */
/* Arrays: legs from 1 < 3; bounces from 1 < 4; first (pieces + 1) < C + 1; corner (C, 3); normal (pieces, 3); patch (pieces);
 * eye (legs, 3); by_sea (legs); screen_first (legs + 1) < S + 1; screen (S, 3, 3); position, antenna (3); bays from 1; tiers, nodes
 * from 2; axis (pieces) from -1 < 2; wall (pieces) < 4; first_panel (2); drawn (4, bays, tiers); kept (nodes); rotation (3, 3);
 * place (room, 3); ends (room, 2); amplitude, ways, surfaces (room); work (1) */
KERNEL int64_t plane_echoes(const PlaneAspect *aspect) {
    PlaneAspect of = *aspect;
    Scene scene;
    Aspect a;
    memset(&a, 0, sizeof a);
    const double *r = of.rotation;
    Walls walls = {of.bays, of.tiers, of.nodes, of.frame, of.tier, of.flat, of.dented, of.axis, of.wall, of.first_panel, of.drawn, of.kept,
                   {vec(r[0], r[3], r[6]), vec(r[1], r[4], r[7]), vec(r[2], r[5], r[8])}};
    a.walls = &walls;
    a.scene = &scene;
    a.most_work = of.most_work;
    a.legs = (int)of.legs;
    a.bounces = (int)of.bounces;
    Output out = {TURN / of.wavelength, of.wavelength, of.longest, of.wide, of.bend, of.level, of.room, 0, of.place, of.ends, of.amplitude,
                  of.ways, of.surfaces};
    a.out = out;
    a.skip = of.skip;
    a.bounce_skip = larger(of.bounce_skip, 1e-12);
    a.wave = 2.0 * sqrt(0.5 * TURN) / of.wavelength;
    int sound = of.pieces < INT32_MAX / 4 && dry_scene(&scene, &of);
    double *reach = malloc(sizeof(double) * (size_t)(of.pieces + 1));
    sound = sound && grow_tree(&a.tree, &scene);
    a.near_list = malloc(sizeof(int) * (size_t)(of.pieces + 1));
    a.from_first = malloc(sizeof(int) * (size_t)(of.pieces + 1));
    a.from_second = malloc(sizeof(int) * (size_t)(of.pieces + 1));
    sound = sound && reach && a.near_list && a.from_first && a.from_second;
    for (int s = 0; s < a.legs && sound; s++) {
        Leg leg = {vec(of.eye[3 * s], of.eye[3 * s + 1], of.eye[3 * s + 2]), vec(0.0, 0.0, 0.0), of.by_sea[s], of.position,
                   of.antenna, of.cosine, of.sine, of.earth_radius, (int)(of.screen_first[s + 1] - of.screen_first[s]),
                   (const Vec *)of.screen + 3 * of.screen_first[s]};
        leg.ahead = unit_of(vsub(scene.middle, leg.eye));
        sound = leg.screens >= 0 && look(&a.view[s], &scene, &leg, s, of.water);
    }
    if (sound) {
        single_fields(&a, of.water);
        if (a.bounces > 1) {
            reach_of_pieces(&a, reach);
            bounces(&a, reach, of.water);
        }
    }
    sound = sound && !a.lit.failed && !a.kept.failed;
    *of.work = a.lit.work + a.kept.work;
    for (int s = 0; s < a.legs; s++) free_view(&a.view[s]);
    free_tree(&a.tree);
    free(a.lit.at);
    free(a.kept.at);
    free(a.near_list);
    free(a.from_first);
    free(a.from_second);
    free(reach);
    free(scene.first);
    free(scene.corner);
    free(scene.plane);
    return sound ? a.out.count : NO_MEMORY;
}
