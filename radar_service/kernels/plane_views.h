/* What eyes see of convex planar pieces, for plane_echoes.c: pieces above the water, boxes about them, and what hides what. */

#ifndef PLANE_VIEWS_H
#define PLANE_VIEWS_H

#include "phasors.h"
#include "polygons.h"

enum { WAYS = 2, LEVELS = 17, FAN = 4, CELLS = 128, MOST_KEPT = 1 << 23 };

static const double ROUNDED = 4e-6; /* of the radius of a scene: by which boxes in single precision are too large */

/* Adds the planes through an eye and the edges of a polygon, its middle above them, to the `count` that are there. All take the edges'
 * sense: what lies above all is within the outline, even of a bent piece that is seen so flat that its outline is not convex. */
static int add_planes_of_edges(const Vec *corner, int corners, Vec eye, Vec middle, Plane *planes, int count) {
    int first = count;
    double over = 0.0;
    for (int i = 0; i < corners; i++) {
        Vec next = corner[i + 1 == corners ? 0 : i + 1], normal = vcross(vsub(corner[i], eye), vsub(next, corner[i]));
        double size = size_of(normal);
        if (size < 1e-12) continue;
        Plane side = {vscale(normal, 1.0 / size), 0.0};
        side.offset = vdot(side.normal, eye);
        over += size * height_over(side, middle);
        planes[count++] = side;
    }
    for (int i = first; i < count && over < 0.0; i++) {
        planes[i].normal = vscale(planes[i].normal, -1.0);
        planes[i].offset = -planes[i].offset;
    }
    return count;
}

/* The planes that a shadow lies above which a convex occluder throws from an eye, its own plane first; none of one seen edge on. */
static int shadow_sides(const Polygon *occluder, Vec eye, Plane plane, Plane *sides) {
    double toward = height_over(plane, eye);
    if (fabs(toward) < THIN) return 0;
    sides[0].normal = vscale(plane.normal, toward > 0.0 ? -1.0 : 1.0);
    sides[0].offset = toward > 0.0 ? -plane.offset : plane.offset;
    return add_planes_of_edges(occluder->at, occluder->n, eye, middle_of(occluder), sides, 1);
}

/* Takes a shadow out of regions; `first`: also of regions that lie in the plane of its occluder, so that of two layers in one place
 * one counts. What no shadow meets stays as it is. Returns whether anything changes. */
static int shade(Regions *list, const Plane *planes, int count, int first) {
    Plane sides[MOST + 1];
    int changed = 0, telling = 0;
    int64_t before = count ? list->n : 0;
    memcpy(sides, planes, (size_t)count * sizeof(Plane));
    sides[0].offset -= first ? 2.0 * THIN : 0.0;
    list->work += before;
    for (int64_t k = 0; k < before && !list->failed; k++) {
        int met = 1;
        for (int s = -1; s < count && met; s++) { /* what tells of one region often tells of the next */
            int side = s < 0 ? telling : s;
            const Polygon *p = list->at + k;
            met = 0;
            for (int i = 0; i < p->n && !met; i++) met = height_over(sides[side], p->at[i]) > THIN;
            telling = met ? telling : side;
        }
        if (!met) continue;
        halve_if_large(list, k, count);
        if (list->failed) return 1;
        Polygon halves[2], outside[MOST + 1], *rest = list->at + k, *inside = halves;
        int lit = 0, gone = 0;
        for (int s = 0; s < count && !gone; s++) {
            double height[MOST];
            heights_over(sides[s], rest, height);
            int part = cut_polygon(rest, height, inside, outside + lit);
            if (part == PART) {
                if (outside[lit].n > 2 && area_of(outside + lit) > SPECK) lit++;
                rest = inside;
                inside = halves + (rest == halves);
            }
            gone = part == NOTHING || rest->n < 3;
        }
        if (gone || area_of(rest) < SPECK) continue;
        changed = 1;
        if (!lit) {
            copy_polygon(list->at + k, list->at + list->n - 1);
            if (--list->n < before) {
                before--;
                k--;
            }
            continue;
        }
        copy_polygon(list->at + k, outside);
        for (int i = 1; i < lit; i++) add_region(list, outside + i);
    }
    return changed;
}

/* Of leg_rays.c. */
KERNEL int64_t leg_lengths(int64_t count, int64_t by_sea, const double *points, const double *position, double cosine, double sine,
                           const double *antenna, double earth_radius, double *length);

/* One way between the antenna and the body, as of a `BodyLeg`; in its frame a point, but for what the curved earth adds. */
typedef struct {
    Vec eye, ahead; /* ahead: unit direction from the eye to the middle of the body */
    int64_t by_sea;
    const double *position, *antenna;
    double cosine, sine, earth_radius;
    int screens; /* triangles of other bodies that hide parts of this one on this way, in its frame */
    const Vec *screen;
} Leg;

/* What a leg is longer than the straight line from its eye to a point. */
static double detour(const Leg *leg, Vec point) {
    if (isinf(leg->earth_radius)) return 0.0;
    double at[3] = {point.x, point.y, point.z}, length;
    leg_lengths(1, leg->by_sea, at, leg->position, leg->cosine, leg->sine, leg->antenna, leg->earth_radius, &length);
    return length - size_of(vsub(point, leg->eye));
}

/* The pieces that rise above the water. */
typedef struct {
    int n;
    const int64_t *patch;
    int *first; /* (n + 1) */
    Vec *corner;
    Plane *plane;
    Vec middle;
    double radius;
} Scene;

typedef float Row __attribute__((vector_size(4 * FAN), aligned(4), may_alias));
typedef int32_t Mask __attribute__((vector_size(4 * FAN), aligned(4), may_alias));

/* Boxes about pieces, and about FAN of these in a row, and so on up to one such group. Of each group: middles (3, FAN) from the
 * middle of the scene, and halves of the sides (3, FAN), a little too large; a half of an empty box is negative. */
typedef struct {
    int levels;
    float *box[LEVELS], *plane; /* plane (4, FAN) of each group of pieces: normals, and offsets from the middle */
} Tree;

/* Numbers that are kept, as many as MOST_KEPT; place 0 is that of none. */
typedef struct {
    double *at;
    int n, room;
} Store;

/* The place of `count` numbers more; 0: there is no room, and what they say is computed anew. */
static int keep(Store *store, int64_t count) {
    int64_t place = store->n ? store->n : 1;
    if (place + count > MOST_KEPT) return 0;
    if (place + count > store->room) {
        int room = (int)(2 * (place + count));
        double *wider = realloc(store->at, (size_t)room * sizeof(double));
        if (!wider) return 0;
        store->at = wider;
        store->room = room;
    }
    store->n = (int)(place + count);
    return (int)place;
}

/* What lies before an eye: projected boxes of the pieces that face it, in a grid. By the sea their images in it come after them,
 * numbered from n on: they stop rays on their way down. Other bodies' screens are numbered from 2 n on. */
typedef struct {
    Leg leg;
    int level; /* of the leg: 0 direct, 1 by the sea */
    Vec right, up;
    int n, fine; /* pieces before it; cells along a side of the grid */
    int *which;
    double *box; /* (n, 5): low and high of both directions, and the nearest distance */
    double low[2], scale[2];
    int *begin, *member; /* of cells */
    int *stamp, now;
    signed char *seen; /* of each piece of the scene: as of `Seen` */
    Store kept;
    int *shadow, *part; /* places there: of an occluder's `shadow_sides`; of what `remember` says of a piece */
    int *telling, told; /* what took something out of the latest piece that was `seen_by` this view */
    int hider;          /* what hid the latest piece that was hidden, -1: nothing */
} View;

enum Seen { BACK = 0, HIDDEN, UNKNOWN, PARTLY, WHOLE };

/* What was gathered for the result. */
typedef struct {
    double wavenumber, wavelength, longest, wide, bend; /* longest, wide, bend: as of `PlaneAspect` */
    int64_t level, room, count;                         /* level: whether the polarization is "h" */
    double *position, *ends;
    Complex *amplitude;
    int64_t *ways, *surfaces;
} Output;

typedef struct {
    const Scene *scene;
    const struct Walls *walls;
    Tree tree;
    View view[WAYS];
    int legs, bounces;
    Output out;
    double skip, bounce_skip, wave; /* wave: 2 sqrt(pi) / lambda, field over surface */
    int *near_list, *from_first, *from_second;
    Regions lit, kept;
    int64_t most_work; /* cuts and pairs of pieces that are tried: a mesh whose surfaces cross each other everywhere has no end */
} Aspect;

static inline int is_worn_out(const Aspect *a) { return a->lit.work + a->kept.work > a->most_work; }

/* ------------------------------------------------------------------------------------------------------------------- boxes */

static void include(Vec *low, Vec *high, Vec least, Vec most) {
    *low = vec(smaller(low->x, least.x), smaller(low->y, least.y), smaller(low->z, least.z));
    *high = vec(larger(high->x, most.x), larger(high->y, most.y), larger(high->z, most.z));
}

static int grow_tree(Tree *t, const Scene *scene) {
    size_t every = (size_t)scene->n + FAN;
    Vec *low = malloc(every * sizeof *low), *high = malloc(every * sizeof *high), edge = vec(INFINITY, INFINITY, INFINITY);
    const double middle[3] = {scene->middle.x, scene->middle.y, scene->middle.z}, slack = ROUNDED * scene->radius;
    int n = scene->n, sound = low && high;
    t->levels = 0;
    t->plane = calloc(4 * every, sizeof *t->plane);
    sound = sound && t->plane;
    for (int i = 0; sound && i < n; i++) {
        Plane plane = scene->plane[i];
        const double at[4] = {plane.normal.x, plane.normal.y, plane.normal.z, -height_over(plane, scene->middle)};
        for (int k = 0; k < 4; k++) t->plane[(4 * (i / FAN) + k) * FAN + i % FAN] = (float)at[k];
        low[i] = edge;
        high[i] = vscale(edge, -1.0);
        for (int k = scene->first[i]; k < scene->first[i + 1]; k++) include(low + i, high + i, scene->corner[k], scene->corner[k]);
    }
    while (sound && t->levels < LEVELS) {
        int groups = n > 0 ? (n + FAN - 1) / FAN : 1;
        float *box = t->box[t->levels++] = malloc(sizeof(float) * 6 * FAN * (size_t)groups);
        sound = box != NULL;
        for (int g = 0; sound && g < groups; g++, box += 6 * FAN) {
            Vec least = edge, most = vscale(edge, -1.0);
            for (int i = 0; i < FAN; i++) {
                int member = FAN * g + i, empty = member >= n || low[member].x > high[member].x;
                double ends[2][3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
                if (!empty) {
                    memcpy(ends[0], low + member, sizeof ends[0]);
                    memcpy(ends[1], high + member, sizeof ends[1]);
                    include(&least, &most, low[member], high[member]);
                }
                for (int axis = 0; axis < 3; axis++) {
                    box[axis * FAN + i] = empty ? 0.0f : (float)(0.5 * (ends[0][axis] + ends[1][axis]) - middle[axis]);
                    box[(3 + axis) * FAN + i] = empty ? -1e30f : (float)(0.5 * (ends[1][axis] - ends[0][axis]) + slack);
                }
            }
            low[g] = least;
            high[g] = most;
        }
        if (groups == 1) break;
        n = groups;
    }
    free(low);
    free(high);
    return sound;
}

static void free_tree(Tree *t) {
    for (int l = 0; l < t->levels; l++) free(t->box[l]);
    free(t->plane);
}

/* The planes through an eye and the edges of a window, and others: a beam lies above them all. */
typedef struct {
    int n;
    Plane at[MOST + 2];
    Vec eye;
    const Polygon *window;
} Beam;

static Beam beam_through(const Polygon *window, Vec eye, Plane beyond) {
    Beam beam;
    beam.eye = eye;
    beam.window = window;
    beam.at[0] = beyond;
    beam.n = add_planes_of_edges(window->at, window->n, eye, middle_of(window), beam.at, 1);
    return beam;
}

/* Whether a plane through the eye and an edge of a convex polygon that faces it has a beam's window beyond, clearly. */
static int passes_by(const Beam *beam, const Vec *corner, int corners) {
    for (int i = 0; i < corners; i++) {
        Vec next = corner[i + 1 == corners ? 0 : i + 1], out = vcross(vsub(corner[i], beam->eye), vsub(next, corner[i]));
        double slack = 10.0 * THIN * (fabs(out.x) + fabs(out.y) + fabs(out.z));
        int apart = 1;
        for (int k = 0; k < beam->window->n && apart; k++) apart = vdot(out, vsub(beam->window->at[k], beam->eye)) > slack;
        if (apart) return 1;
    }
    return 0;
}

/* A plane from the middle of a scene: its normal, the sizes of that, its offset; each FAN times. */
typedef struct {
    Row at[7];
} Side;

/* Pieces that may face its eye and whose boxes a beam may meet in a group of the tree, added to `found` from `count` on. sides:
 * n, and one that has the eye in place of a normal. */
static int gather_beam(const Tree *t, int level, int group, const Side *sides, int n, int *found, int count) {
    const Row *box = (const Row *)t->box[level] + (size_t)group * 6;
    Mask alive = (Mask)(box[3] > -1.0f);
    for (int k = 0; k < n; k++) { /* few tell alone: no branch */
        const Row *s = sides[k].at;
        Row middle = box[0] * s[0] + box[1] * s[1] + box[2] * s[2], half = box[3] * s[3] + box[4] * s[4] + box[5] * s[5];
        alive &= (Mask)(middle + half > s[6]);
    }
    if (!level) {
        const Row *plane = (const Row *)t->plane + (size_t)group * 4, *eye = sides[n].at;
        alive &= (Mask)(plane[0] * eye[0] + plane[1] * eye[1] + plane[2] * eye[2] - plane[3] > eye[6]);
    }
    for (int i = 0; i < FAN; i++) {
        if (level) {
            if (alive[i]) count = gather_beam(t, level - 1, FAN * group + i, sides, n, found, count);
        } else {
            found[count] = FAN * group + i;
            count -= alive[i];
        }
    }
    return count;
}

/* All pieces that a beam may meet, in their order. */
static int all_in_beam(const Tree *t, const Scene *scene, const Beam *beam, int *found) {
    Side sides[MOST + 3];
    Vec eye = vsub(beam->eye, scene->middle);
    for (int k = 0; k <= beam->n; k++) {
        Vec n = k < beam->n ? beam->at[k].normal : eye;
        double over = k < beam->n ? -height_over(beam->at[k], scene->middle) : -ROUNDED * (scene->radius + size_of(eye));
        double at[7] = {n.x, n.y, n.z, fabs(n.x), fabs(n.y), fabs(n.z), over};
        for (int i = 0; i < 7; i++) sides[k].at[i] = (Row){0.0f} + (float)at[i];
    }
    return gather_beam(t, t->levels - 1, 0, sides, beam->n, found, 0);
}

/* -------------------------------------------------------------------------------------------------------------------- views */

static Polygon piece_of(const Scene *scene, int i) {
    Polygon p;
    p.n = scene->first[i + 1] - scene->first[i];
    memcpy(p.at, scene->corner + scene->first[i], (size_t)p.n * sizeof(Vec));
    return p;
}

/* Low and high of a polygon in both directions across a view, the nearest and the farthest distance along it. What reaches behind
 * the eye has no bounds. */
static void box_in(const View *view, const Polygon *p, double box[6]) {
    box[0] = box[2] = box[4] = INFINITY;
    box[1] = box[3] = box[5] = -INFINITY;
    for (int i = 0; i < p->n; i++) {
        Vec r = vsub(p->at[i], view->leg.eye);
        double along = vdot(r, view->leg.ahead), u = vdot(r, view->right) / along, v = vdot(r, view->up) / along;
        if (along < 1e-3) {
            box[0] = box[2] = box[4] = -INFINITY;
            box[1] = box[3] = box[5] = INFINITY;
            return;
        }
        box[0] = smaller(box[0], u);
        box[1] = larger(box[1], u);
        box[2] = smaller(box[2], v);
        box[3] = larger(box[3], v);
        box[4] = smaller(box[4], along);
        box[5] = larger(box[5], along);
    }
}

/* The occluder of a number in a leg's view: a piece, from n on the image in the sea of one, or a screen; its plane too. */
static Polygon occluder_of(const Scene *scene, const Leg *leg, int number, double water, Plane *plane) {
    Polygon p; /* one, which is made where it is wanted */
    if (number >= 2 * scene->n) {
        p.n = 3;
        memcpy(p.at, leg->screen + 3 * (number - 2 * scene->n), 3 * sizeof(Vec));
        plane->normal = unit_of(vcross(vsub(p.at[1], p.at[0]), vsub(p.at[2], p.at[0])));
        plane->offset = vdot(plane->normal, p.at[0]);
        return p;
    }
    int i = number < scene->n ? number : number - scene->n;
    p.n = scene->first[i + 1] - scene->first[i];
    memcpy(p.at, scene->corner + scene->first[i], (size_t)p.n * sizeof(Vec));
    *plane = scene->plane[i];
    if (number >= scene->n) {
        for (int k = 0; k < p.n; k++) p.at[k].z = 2.0 * water - p.at[k].z;
        plane->normal.z = -plane->normal.z;
        plane->offset = vdot(plane->normal, p.at[0]);
    }
    return p;
}

static inline void cells_of(const View *view, const double *box, int cell[4]) {
    for (int side = 0; side < 4; side++) {
        double at = (box[side] - view->low[side / 2]) * view->scale[side / 2];
        cell[side] = at > 0.0 ? at < view->fine ? (int)at : view->fine - 1 : 0; /* what is not a number: 0 */
    }
}

static int look(View *view, const Scene *scene, const Leg *leg, int level, double water) {
    int most = 2 * scene->n + leg->screens;
    Vec other = fabs(leg->ahead.z) < 0.9 ? vec(0.0, 0.0, 1.0) : vec(1.0, 0.0, 0.0);
    memset(view, 0, sizeof *view);
    view->leg = *leg;
    view->level = level;
    view->right = unit_of(vcross(leg->ahead, other));
    view->up = vcross(view->right, leg->ahead);
    view->which = malloc(sizeof(int) * (size_t)(most + 1));
    view->box = malloc(sizeof(double) * 5 * (size_t)(most + 1));
    view->stamp = calloc((size_t)(most + 1), sizeof(int));
    view->seen = malloc((size_t)(scene->n + 1));
    view->shadow = calloc((size_t)(most + 1), sizeof(int));
    view->part = calloc((size_t)(scene->n + 1), sizeof(int));
    view->telling = malloc(sizeof(int) * (size_t)(most + 1));
    view->hider = -1;
    if (!view->which || !view->box || !view->stamp || !view->seen || !view->shadow || !view->part || !view->telling) return 0;
    double high[2] = {-INFINITY, -INFINITY};
    view->low[0] = view->low[1] = INFINITY;
    for (int number = 0; number < most; number++) {
        int image = number >= scene->n && number < 2 * scene->n, piece = image ? number - scene->n : number;
        Plane plane;
        int empty = number < 2 * scene->n && scene->first[piece] == scene->first[piece + 1];
        if (number < scene->n) view->seen[piece] = !empty && height_over(scene->plane[piece], leg->eye) > THIN ? UNKNOWN : BACK;
        if (empty || (image && !level)) continue;
        if (number < scene->n && view->seen[piece] == BACK) continue;
        Polygon p = occluder_of(scene, leg, number, water, &plane);
        if (image && height_over(plane, leg->eye) <= THIN) continue;
        double box[6];
        box_in(view, &p, box);
        memcpy(view->box + 5 * view->n, box, 5 * sizeof(double));
        view->which[view->n++] = number;
        for (int axis = 0; axis < 2; axis++) {
            if (isinf(box[2 * axis])) continue;
            view->low[axis] = smaller(view->low[axis], box[2 * axis]);
            high[axis] = larger(high[axis], box[2 * axis + 1]);
        }
    }
    view->fine = (int)sqrt((double)view->n / 2.0);
    if (view->fine > CELLS) view->fine = CELLS;
    if (view->fine < 1) view->fine = 1;
    int cells = view->fine * view->fine, cell[4];
    for (int axis = 0; axis < 2; axis++) {
        double span = high[axis] - view->low[axis];
        view->scale[axis] = span > 0.0 && isfinite(span) ? view->fine / span : 0.0;
        if (!isfinite(view->low[axis])) view->low[axis] = 0.0;
    }
    view->begin = calloc((size_t)cells + 1, sizeof(int));
    if (!view->begin) return 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int f = 0; f < view->n; f++) {
            cells_of(view, view->box + 5 * f, cell);
            for (int v = cell[2]; v <= cell[3]; v++)
                for (int u = cell[0]; u <= cell[1]; u++) {
                    if (pass)
                        view->member[--view->begin[v * view->fine + u]] = f;
                    else
                        view->begin[v * view->fine + u]++;
                }
        }
        if (pass) break;
        for (int c = 0; c < cells; c++) view->begin[c + 1] += view->begin[c];
        view->member = malloc(sizeof(int) * (size_t)(view->begin[cells] + 1));
        if (!view->member) return 0;
    }
    return 1;
}

static void free_view(View *view) {
    free(view->which);
    free(view->box);
    free(view->stamp);
    free(view->seen);
    free(view->shadow);
    free(view->part);
    free(view->telling);
    free(view->kept.at);
    free(view->begin);
    free(view->member);
}

/* A path so far: pieces in a row from the antenna, the images of the eye in them, and the leg out. */
typedef struct {
    int n, chain[2], leg;
    Vec eye[3];
} Path;

/* Shades regions on a piece from an occluder that lies before it, mirrored in the last `from` pieces of a path. */
static void shade_by(const Scene *scene, Regions *list, Polygon *occluder, Plane plane, const Path *path, int from) {
    Plane sides[MOST + 1];
    for (int k = from; k < path->n; k++) {
        Plane mirror = scene->plane[path->chain[k]];
        for (int i = 0; i < occluder->n; i++) occluder->at[i] = mirrored(occluder->at[i], mirror);
        plane.normal = reflected(plane.normal, mirror.normal);
    }
    plane.offset = vdot(plane.normal, occluder->at[0]);
    shade(list, sides, shadow_sides(occluder, path->eye[path->n], plane, sides), 0);
}

/* The `shadow_sides` of an occluder of a view, kept where there is room, else in `scratch`. */
static const Plane *sides_in(const Scene *scene, View *view, int f, double water, Plane *scratch, int *count) {
    if (!view->shadow[f]) {
        Plane plane;
        Polygon occluder = occluder_of(scene, &view->leg, view->which[f], water, &plane);
        *count = shadow_sides(&occluder, view->leg.eye, plane, scratch);
        view->shadow[f] = keep(&view->kept, 1 + 4 * (int64_t)*count);
        if (!view->shadow[f]) return scratch;
        view->kept.at[view->shadow[f]] = *count;
        memcpy(view->kept.at + view->shadow[f] + 1, scratch, (size_t)*count * sizeof(Plane));
    }
    *count = (int)view->kept.at[view->shadow[f]];
    return (const Plane *)(view->kept.at + view->shadow[f] + 1);
}

static inline int may_hide(const Scene *scene, int number, int own) {
    return number != own && (number >= scene->n || scene->patch[number] != scene->patch[own]);
}

/* Shades regions by an occluder of a view, where the boxes of both meet; returns whether anything changes. */
static int shade_by_view(Aspect *a, Regions *list, View *view, int f, const double *box, int own, const Path *path, double water) {
    const double *other = view->box + 5 * f;
    int number = view->which[f];
    if (other[0] >= box[1] || other[1] <= box[0] || other[2] >= box[3] || other[3] <= box[2] || other[4] >= box[5]) return 0;
    if (!may_hide(a->scene, number, own)) return 0;
    if (path) {
        Plane plane;
        Polygon occluder = occluder_of(a->scene, &view->leg, number, water, &plane);
        if (keep_before(&occluder, a->scene->plane[own])) shade_by(a->scene, list, &occluder, plane, path, 0);
        return 1;
    }
    Plane scratch[MOST + 1];
    int count;
    const Plane *sides = sides_in(a->scene, view, f, water, scratch, &count);
    return shade(list, sides, count, number < own);
}

/* Whether the latest hider of a view covers a piece, so that nothing of it is left. */
static int is_covered(const Aspect *a, View *view, const Polygon *whole, int own, double water) {
    Plane scratch[MOST + 1];
    int count;
    if (view->hider < 0 || !may_hide(a->scene, view->which[view->hider], own)) return 0;
    const Plane *sides = sides_in(a->scene, view, view->hider, water, scratch, &count);
    for (int s = 0; s < count; s++)
        for (int i = 0; i < whole->n; i++)
            if (height_over(sides[s], whole->at[i]) < THIN) return 0;
    return count > 0;
}

/* Takes out of regions what is hidden from a view: of piece `own`, or of what is lit along a path that begins there. `window`: as
 * the view has them on piece `own`. Of a piece seen in part before, those that told then are enough. */
static void hide(Aspect *a, Regions *list, View *view, const Polygon *window, int own, const Path *path, double water) {
    double box[6];
    int cell[4], known = view->part[own];
    box_in(view, window, box);
    for (int k = 1; known && k <= (int)view->kept.at[known] && list->n && !is_worn_out(a); k++)
        shade_by_view(a, list, view, (int)view->kept.at[known + k], box, own, path, water);
    cells_of(view, box, cell);
    view->now++;
    view->told = 0;
    for (int v = cell[2]; !known && v <= cell[3] && list->n; v++)
        for (int u = cell[0]; u <= cell[1] && list->n && !is_worn_out(a); u++) {
            int first = view->begin[v * view->fine + u], last = view->begin[v * view->fine + u + 1];
            list->work += (last - first) / 8; /* the quick ones */
            for (int m = first; m < last && list->n; m++) {
                int f = view->member[m];
                if (view->stamp[f] == view->now) continue;
                view->stamp[f] = view->now;
                if (shade_by_view(a, list, view, f, box, own, path, water)) view->telling[view->told++] = f;
            }
        }
    if (is_worn_out(a)) list->n = 0;
}

/* Keeps what a view has of a piece that it sees in part: how many occluders told, these, how many regions there are, and of each
 * its corners. */
static void remember(View *view, int piece, const Regions *seen) {
    int64_t count = 2 + view->told;
    for (int64_t k = 0; k < seen->n; k++) count += 1 + 3 * seen->at[k].n;
    int place = keep(&view->kept, count);
    if (!place) return;
    double *to = view->kept.at + place;
    view->part[piece] = place;
    *to++ = view->told;
    for (int k = 0; k < view->told; k++) *to++ = view->telling[k];
    *to++ = (double)seen->n;
    for (int64_t k = 0; k < seen->n; k++) {
        *to++ = seen->at[k].n;
        memcpy(to, seen->at[k].at, (size_t)seen->at[k].n * sizeof(Vec));
        to += 3 * seen->at[k].n;
    }
}

/* The regions of a piece that a view sees in part. */
static void parts_of(Aspect *a, Regions *list, View *view, const Polygon *whole, int piece, double water) {
    const double *from = view->kept.at + view->part[piece];
    list->n = 0;
    if (!view->part[piece]) {
        add_region(list, whole);
        hide(a, list, view, whole, piece, NULL, water);
        return;
    }
    from += 1 + (int)*from;
    for (int left = (int)*from++; left > 0; left--) {
        Polygon *region = new_region(list);
        if (!region) return;
        region->n = (int)*from++;
        memcpy(region->at, from, (size_t)region->n * sizeof(Vec));
        from += 3 * region->n;
    }
}

/* Takes out of regions what is hidden on the way from piece `from` to piece `to`. there: the window on `to`. eye: the image that
 * lights it from `from`; path: whose end the regions lie on, if that is one piece further on, else NULL. */
static void hide_between(Aspect *a, Regions *list, int from, int to, const Polygon *there, Vec eye, const Path *path) {
    const Scene *scene = a->scene;
    Beam beam = beam_through(there, eye, scene->plane[from]);
    beam.at[beam.n++] = scene->plane[to];
    int found = all_in_beam(&a->tree, scene, &beam, a->near_list);
    for (int k = 0; k < found && list->n && !is_worn_out(a); k++) {
        int c = a->near_list[k];
        if (c == from || c == to || scene->patch[c] == scene->patch[to] || height_over(scene->plane[c], eye) <= THIN) continue;
        if (passes_by(&beam, scene->corner + scene->first[c], scene->first[c + 1] - scene->first[c])) continue;
        Polygon occluder = piece_of(scene, c);
        if (!keep_before(&occluder, scene->plane[from]) || (path && !keep_before(&occluder, scene->plane[to]))) continue;
        if (path) {
            shade_by(scene, list, &occluder, scene->plane[c], path, path->n - 1);
        } else {
            Plane sides[MOST + 1];
            shade(list, sides, shadow_sides(&occluder, eye, scene->plane[c], sides), c < to);
        }
    }
    if (is_worn_out(a)) list->n = 0;
}

#endif
