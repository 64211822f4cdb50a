/* One aspect of convex planar pieces: scattering/physical_optics/plane_echoes.py. An eye is a point: the antenna, its image in the
 * sea, or an image of these in pieces. What an eye lights is what `shade` leaves; bounces are seen by mirrored eyes. Fields are sums
 * over edges (Gordon 1975) away from specular directions, and closed forms of small triangles near them. */

#include "plane_views.h"
#include "triangle_means.h"

static const double TURN = 6.283185307179586; /* 2 pi */
static const double STEEP = 0.05;    /* tangential phase gradient over k, 2 sin of 1.4 degrees, above which edges are summed */
static const double BENT = 800.0;    /* over wavenumber and path, of its square: nearer by, waves bend too much over the zone of a point */
static const double GRAZING = 0.005; /* sine of the angle at which a beam meets a piece, below which it bounces no further */
static const double ENDS = 20.0;     /* rad along an edge, from which on its two ends stand for it */

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

static double length_at(const Aspect *a, const Path *path, const View *back, Vec point) {
    const Leg *out = &a->view[path->leg].leg;
    double length = size_of(vsub(point, path->eye[path->n])) + size_of(vsub(point, back->leg.eye));
    if (isinf(out->earth_radius)) return length;
    return length + detour(out, first_point(a->scene, path, point)) + detour(&back->leg, point);
}

/* (p . d)(n . E) - (p . E)(n . d): what the current that a field makes on a surface sends back, as received. */
static inline double current(Vec received, Vec direction, Vec field, Vec normal) {
    return vdot(received, direction) * vdot(normal, field) - vdot(received, field) * vdot(normal, direction);
}

static At at_point(const Aspect *a, const Path *path, const View *back, Vec normal, Vec point) {
    At at;
    const Output *o = &a->out;
    Vec begin = first_point(a->scene, path, point), eye = path->eye[0];
    Vec in = vsub(point, path->eye[path->n]), away = vsub(point, back->leg.eye), leaves = vsub(begin, eye);
    double in_length = size_of(in), away_length = size_of(away), first_length = size_of(leaves);
    in = vscale(in, 1.0 / in_length);
    away = vscale(away, 1.0 / away_length);
    leaves = vscale(leaves, 1.0 / first_length);
    at.point = at.place = point;
    at.begins = begin.z;
    at.path = in_length + away_length;
    if (path->n) { /* between both ends, behind them by half of what lies between: its range is half the path */
        Vec middle = vscale(vadd(begin, point), 0.5), slope = vscale(vadd(leaves, away), 0.5);
        double missing = (at.path - size_of(vsub(middle, eye)) - size_of(vsub(middle, back->leg.eye))) / 2.0;
        at.place = vadd(middle, vscale(slope, missing / larger(vdot(slope, slope), 1e-3)));
    }
    if (!isinf(back->leg.earth_radius)) at.path += detour(&a->view[path->leg].leg, begin) + detour(&back->leg, point);
    at.gradient = vadd(in, away);
    at.gradient = vsub(at.gradient, vscale(normal, vdot(normal, at.gradient)));
    at.steep = vdot(at.gradient, at.gradient);
    Vec field = polarized(leaves, o->level), received = polarized(away, o->level);
    for (int k = 0; k < path->n; k++) field = vscale(reflected(field, a->scene->plane[path->chain[k]].normal), -1.0);
    at.weight = current(received, in, field, normal);
    if (path->leg != back->level && !path->n) at.weight += current(field, away, received, normal); /* both orders */
    at.weight *= a->wave;
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

/* The field of a triangle, in closed form where its edges are short enough, shared by its corners. */
static void triangle_field(Aspect *a, const Path *path, const View *back, Vec normal, At p, At q, At r, int depth) {
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
        At middle = at_point(a, path, back, normal, vscale(vadd(one.point, other.point), 0.5));
        triangle_field(a, path, back, normal, one, middle, third, depth + 1);
        triangle_field(a, path, back, normal, middle, other, third, depth + 1);
        return;
    }
    double unordered[3], phases[3], bends[3];
    Complex at_corner[3], means[3];
    double area = 0.5 * size_of(vcross(vsub(q.point, p.point), vsub(r.point, p.point)));
    double length[3] = {p.path, q.path, r.path};
    for (int i = 0; i < 3; i++) unordered[i] = -o->wavenumber * (length[i] - p.path);
    int first = first_corner(unordered);
    for (int i = 0; i < 3; i++) {
        int c = (first + i) % 3;
        Vec middle = vscale(vadd(corner[(c + 1) % 3].point, corner[(c + 2) % 3].point), 0.5);
        phases[i] = unordered[c];
        at_corner[i] = corner[c].phasor;
        bends[i] = -o->wavenumber * (length_at(a, path, back, middle) - 0.5 * (length[(c + 1) % 3] + length[(c + 2) % 3]));
    }
    ordered_means(phases, at_corner, bends, means);
    for (int i = 0; i < 3; i++) {
        const At *at = corner + (first + i) % 3;
        emit(o, at, turned(scaled(means[i], at->weight * area), -1.0), path, back);
    }
}

/* The field of a region by its edges; 0 where a specular point may be too near. */
static int edge_fields(Aspect *a, const Path *path, const View *back, Vec normal, const Polygon *p, const At *at) {
    Output *o = &a->out;
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
        double here = at[i].weight * vdot(outward, at[i].gradient) / (k * at[i].steep);
        double there = at[j].weight * vdot(outward, at[j].gradient) / (k * at[j].steep);
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
            At next = last ? at[j] : at_point(a, path, back, normal, vadd(p->at[i], vscale(along, step * s)));
            double bend = -k * (length_at(a, path, back, vscale(vadd(before.point, next.point), 0.5)) - 0.5 * (before.path + next.path));
            EdgeMoments e = edge_moments(-k * (next.path - before.path), before.phasor, next.phasor);
            Complex half = scaled(times(bubble_of(bend), e.bubble), 0.5);
            double low = here + (there - here) * (s - 1) / parts, high = here + (there - here) * s / parts;
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

/* The fields of regions on a piece, lit along a path and seen from a view. */
static void radiate(Aspect *a, const Regions *list, const Path *path, const View *back, Vec normal) {
    At at[MOST];
    for (int64_t k = 0; k < list->n; k++) {
        const Polygon *p = list->at + k;
        for (int i = 0; i < p->n; i++) at[i] = at_point(a, path, back, normal, p->at[i]);
        if (edge_fields(a, path, back, normal, p, at)) continue;
        for (int i = 1; i + 1 < p->n; i++) triangle_field(a, path, back, normal, at[0], at[i], at[i + 1], 0);
    }
}

/* ------------------------------------------------------------------------------------------------------------------- bounds */

/* What the field of a region has at most [m]: that of its surface, or of its edges over the gradient of the phase. */
static double most_field(const Aspect *a, const Polygon *p, Vec eye, Vec back, Vec normal) {
    Vec middle = middle_of(p), in = unit_of(vsub(middle, eye)), away = unit_of(vsub(middle, back)), g = vadd(in, away);
    double radius = 0.0, edges = 0.0, k = a->out.wavenumber;
    g = vsub(g, vscale(normal, vdot(g, normal)));
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
    add_region(&a->kept, &whole);
    hide(a, &a->kept, view, &whole, piece, NULL, view->leg.eye, water);
    int is_whole = a->kept.n == 1 && a->kept.at[0].n == whole.n && fabs(area_of(a->kept.at) - area) <= 1e-12 * area;
    view->seen[piece] = (signed char)(a->kept.n == 0 ? HIDDEN : is_whole ? WHOLE : PARTLY);
    return (enum Seen)view->seen[piece];
}

static void single_fields(Aspect *a, double water) {
    for (int piece = 0; piece < a->scene->n; piece++) {
        Polygon whole = piece_of(a->scene, piece);
        Vec normal = a->scene->plane[piece].normal;
        for (int s = 0; s < a->legs && whole.n; s++) {
            View *view = &a->view[s], *mixed = s == 0 && a->legs > 1 ? &a->view[1] : NULL;
            if (view->seen[piece] == BACK) continue;
            if (mixed && mixed->seen[piece] == BACK) mixed = NULL;
            Vec eye = view->leg.eye;
            int own = most_field(a, &whole, eye, eye, normal) >= a->skip;
            if (mixed && 2.0 * most_field(a, &whole, eye, mixed->leg.eye, normal) < a->skip) mixed = NULL;
            if (!own && !mixed) continue;
            enum Seen seen = seen_by(a, view, piece, water);
            if (seen == HIDDEN) continue;
            Path path = {0, {0, 0}, s, {eye, eye, eye}};
            a->lit.n = 0;
            add_region(&a->lit, &whole);
            if (seen == PARTLY) hide(a, &a->lit, view, &whole, piece, NULL, eye, water);
            if (own) radiate(a, &a->lit, &path, view, normal);
            if (!mixed || seen_by(a, mixed, piece, water) == HIDDEN) continue;
            if (mixed->seen[piece] == PARTLY) hide(a, &a->lit, mixed, &whole, piece, NULL, mixed->leg.eye, water);
            radiate(a, &a->lit, &path, mixed, normal);
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

/* What of a piece a beam lights; 0: nothing. */
static int lit_part(const Scene *scene, int piece, const Beam *beam, Polygon *part) {
    *part = piece_of(scene, piece);
    for (int k = 0; k < beam->n; k++) {
        int any = 0;
        for (int i = 0; i < part->n && !any; i++) any = height_over(beam->at[k], part->at[i]) > THIN;
        if (!any) return 0;
    }
    for (int k = 0; k < beam->n; k++)
        if (!keep_before(part, beam->at[k])) return 0;
    return part->n > 2 && area_of(part) > SPECK;
}

/* What returns by each leg from a region at the end of a path. The same way the other way round is a path of its own: its currents
 * are on the other end, and differ by a few percent. `wanted`: bits of legs. */
static void bounce_fields(Aspect *a, const Path *path, int last, const Polygon *region, int wanted, double water) {
    const Scene *scene = a->scene;
    Vec normal = scene->plane[last].normal, eye = path->eye[path->n];
    int made = 0;
    for (int r = 0; r < a->legs; r++) {
        View *back = &a->view[r];
        if (!(wanted >> r & 1) || most_field(a, region, eye, back->leg.eye, normal) < a->bounce_skip) continue;
        if (seen_by(a, back, last, water) == HIDDEN) continue;
        if (!made) {
            View *out = &a->view[path->leg];
            Polygon window[3];
            window[path->n] = *region;
            for (int k = path->n - 1; k >= 0; k--) window[k] = window_of(&window[k + 1], path->eye[k + 1], scene->plane[path->chain[k]]);
            a->lit.n = 0;
            add_region(&a->lit, region);
            if (seen_by(a, out, path->chain[0], water) == PARTLY) hide(a, &a->lit, out, window, path->chain[0], path, eye, water);
            for (int k = 0; k < path->n && a->lit.n; k++) {
                int to = k + 1 < path->n ? path->chain[k + 1] : last;
                hide_between(a, &a->lit, path->chain[k], to, &window[k], &window[k + 1], path->eye[k + 1], k + 1 < path->n ? path : NULL, eye);
            }
            made = 1;
        }
        if (!a->lit.n) return;
        if (back->seen[last] == WHOLE) {
            radiate(a, &a->lit, path, back, normal);
        } else {
            copy_regions(&a->kept, &a->lit);
            hide(a, &a->kept, back, region, last, NULL, back->leg.eye, water);
            radiate(a, &a->kept, path, back, normal);
        }
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
            Beam beam = beam_through(&window, path.eye[1], mirror);
            int count = all_in_beam(&a->tree, &beam, a->from_first);
            a->lit.work += count;
            for (int i = 0; i < count && !is_worn_out(a); i++) {
                int two = a->from_first[i], wanted = 0;
                if (two == one || height_over(scene->plane[two], path.eye[1]) <= THIN) continue;
                for (int r = 0; r < a->legs; r++)
                    if (a->view[r].seen[two] > HIDDEN && may_count(direction, a->view[r].leg.ahead, scene->plane[two].normal, reach[two], slack))
                        wanted |= 1 << r;
                if (!wanted && a->bounces < 3) continue;
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
                int further = all_in_beam(&a->tree, &narrow, a->from_second);
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
 * times its root [m]. screens: triangles screen (S, 3, 3) of other bodies, from screen_first (legs + 1) on of each leg. most_work: after so many cuts and pairs
 * of pieces all else is left out; work (1): how many there were. place (room, 3), ends (room, 2): heights at the first and the last piece [m], amplitude (room) with the phase of the whole path,
 * ways (room) by the sea, surfaces (room) in a row. */
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
    scene->corner = malloc(sizeof(Vec) * (size_t)(first[pieces] + pieces + 1));
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
 * eye (legs, 3); by_sea (legs); screen_first (legs + 1) < S + 1; screen (S, 3, 3); position, antenna (3); place (room, 3);
 * ends (room, 2); amplitude, ways, surfaces (room); work (1) */
KERNEL int64_t plane_echoes(const PlaneAspect *aspect) {
    PlaneAspect of = *aspect;
    Scene scene;
    Aspect a;
    memset(&a, 0, sizeof a);
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
