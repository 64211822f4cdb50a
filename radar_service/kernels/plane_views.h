/* What eyes see of convex planar pieces, for plane_echoes.c: pieces above the water, boxes about them, and what hides what. */

#ifndef PLANE_VIEWS_H
#define PLANE_VIEWS_H

#include "phasors.h"
#include "polygons.h"

enum { WAYS = 2, LEVELS = 12, FAN = 8, CELLS = 128 };

/* Adds the planes through an eye and the edges of a convex polygon, its middle above them, to the `count` that are there. */
static int add_planes_of_edges(const Vec *corner, int corners, Vec eye, Vec middle, Plane *planes, int count) {
    for (int i = 0; i < corners; i++) {
        Vec next = corner[i + 1 == corners ? 0 : i + 1], normal = vcross(vsub(corner[i], eye), vsub(next, corner[i]));
        double size = size_of(normal);
        if (size < 1e-12) continue;
        Plane side = {vscale(normal, 1.0 / size), 0.0};
        side.offset = vdot(side.normal, eye);
        if (height_over(side, middle) < 0.0) {
            side.normal = vscale(side.normal, -1.0);
            side.offset = -side.offset;
        }
        planes[count++] = side;
    }
    return count;
}

/* Takes out of regions the shadow that a convex occluder, with its plane, throws from an eye; `first`: also of regions that lie in
 * this plane, so that of two layers in one place one counts. What no shadow meets stays as it is. */
static void shade(Regions *list, const Vec *occluder, int corners, Vec eye, Plane plane, int first) {
    Plane sides[MOST + 1];
    int count = 0;
    double toward = height_over(plane, eye);
    if (fabs(toward) < THIN) return;
    Vec middle = vec(0.0, 0.0, 0.0);
    for (int i = 0; i < corners; i++) middle = vadd(middle, occluder[i]);
    middle = vscale(middle, 1.0 / corners);
    sides[count].normal = vscale(plane.normal, toward > 0.0 ? -1.0 : 1.0); /* the eye is below, the shadow above */
    sides[count++].offset = (toward > 0.0 ? -plane.offset : plane.offset) - (first ? 2.0 * THIN : 0.0);
    count = add_planes_of_edges(occluder, corners, eye, middle, sides, count);
    int64_t before = list->n;
    list->work += before;
    for (int64_t k = 0; k < before && !list->failed; k++) {
        int met = 1;
        for (int s = 0; s < count && met; s++) {
            const Polygon *p = list->at + k;
            double most = -1.0;
            for (int i = 0; i < p->n; i++) {
                double height = height_over(sides[s], p->at[i]);
                most = height > most ? height : most;
            }
            met = most > THIN;
        }
        if (!met) continue;
        halve_if_large(list, k, count);
        if (list->failed) return;
        Polygon rest, inside, outside[MOST + 1];
        int lit = 0, gone = 0;
        copy_polygon(&rest, list->at + k);
        for (int s = 0; s < count && !gone; s++) {
            double height[MOST];
            heights_over(sides[s], &rest, height);
            int part = cut_polygon(&rest, height, &inside, outside + lit);
            if (part == PART) {
                if (outside[lit].n > 2 && area_of(outside + lit) > SPECK) lit++;
                copy_polygon(&rest, &inside);
            }
            gone = part == NOTHING || rest.n < 3;
        }
        if (gone || area_of(&rest) < SPECK) continue;
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

/* Boxes about pieces, and about FAN of these in a row, and so on; middle and half of the sides. An empty one has a negative half. */
typedef struct {
    int levels, count[LEVELS];
    Vec *middle[LEVELS], *half[LEVELS];
} Tree;

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

static int grow_tree(Tree *t, const Scene *scene) {
    int n = scene->n;
    memset(t, 0, sizeof *t);
    for (t->levels = 0; t->levels < LEVELS; t->levels++) {
        int l = t->levels;
        t->count[l] = n;
        t->middle[l] = malloc(sizeof(Vec) * (size_t)(n + 1));
        t->half[l] = malloc(sizeof(Vec) * (size_t)(n + 1));
        if (!t->middle[l] || !t->half[l]) return 0;
        for (int i = 0; i < n; i++) {
            Vec low = vec(INFINITY, INFINITY, INFINITY), high = vec(-INFINITY, -INFINITY, -INFINITY);
            int begin = l ? FAN * i : scene->first[i], end = l ? FAN * i + FAN : scene->first[i + 1];
            if (l && end > t->count[l - 1]) end = t->count[l - 1];
            for (int k = begin; k < end; k++) {
                Vec middle = l ? t->middle[l - 1][k] : scene->corner[k], half = l ? t->half[l - 1][k] : vec(0.0, 0.0, 0.0);
                if (half.x < 0.0) continue;
                low = vec(smaller(low.x, middle.x - half.x), smaller(low.y, middle.y - half.y), smaller(low.z, middle.z - half.z));
                high = vec(larger(high.x, middle.x + half.x), larger(high.y, middle.y + half.y), larger(high.z, middle.z + half.z));
            }
            int empty = low.x > high.x;
            t->middle[l][i] = empty ? vec(0.0, 0.0, 0.0) : vscale(vadd(low, high), 0.5);
            t->half[l][i] = empty ? vec(-1.0, -1.0, -1.0) : vscale(vsub(high, low), 0.5);
        }
        if (n <= FAN) {
            t->levels++;
            return 1;
        }
        n = (n + FAN - 1) / FAN;
    }
    return 1;
}

static void free_tree(Tree *t) {
    for (int l = 0; l < LEVELS; l++) {
        free(t->middle[l]);
        free(t->half[l]);
    }
}

/* The planes through an eye and the edges of a window, and the window's own: a beam lies above them all. last: the plane that last
 * had something below it, and often has the next one too. */
typedef struct {
    int n, last;
    Plane at[MOST + 1];
} Beam;

static Beam beam_through(const Polygon *window, Vec eye, Plane beyond) {
    Beam beam;
    Vec middle = middle_of(window);
    beam.n = beam.last = 0;
    beam.at[beam.n++] = beyond;
    beam.n = add_planes_of_edges(window->at, window->n, eye, middle, beam.at, beam.n);
    return beam;
}

static inline int is_below(Plane plane, Vec middle, Vec half) {
    Vec n = plane.normal;
    return height_over(plane, middle) + fabs(n.x) * half.x + fabs(n.y) * half.y + fabs(n.z) * half.z <= THIN;
}

static inline int in_beam(Vec middle, Vec half, Beam *beam) {
    if (half.x < 0.0 || is_below(beam->at[beam->last], middle, half)) return 0;
    for (int k = beam->n - 1; k >= 0; k--) { /* the sides first: a beam is narrow */
        if (!is_below(beam->at[k], middle, half)) continue;
        beam->last = k;
        return 0;
    }
    return 1;
}

/* Pieces whose boxes a beam meets below a node of the tree, added to `found` from `count` on. */
static int gather_beam(const Tree *t, int level, int node, Beam *beam, int *found, int count) {
    if (!in_beam(t->middle[level][node], t->half[level][node], beam)) return count;
    if (!level) {
        found[count++] = node;
        return count;
    }
    int end = FAN * node + FAN < t->count[level - 1] ? FAN * node + FAN : t->count[level - 1];
    for (int i = FAN * node; i < end; i++) count = gather_beam(t, level - 1, i, beam, found, count);
    return count;
}

static int all_in_beam(const Tree *t, Beam *beam, int *found) {
    int count = 0, top = t->levels - 1;
    for (int i = 0; i < t->count[top]; i++) count = gather_beam(t, top, i, beam, found, count);
    return count;
}

static int gather_box(const Tree *t, int level, int node, Vec middle, Vec half, int *found, int count) {
    Vec m = t->middle[level][node], h = t->half[level][node];
    if (h.x < 0.0 || fabs(m.x - middle.x) >= h.x + half.x || fabs(m.y - middle.y) >= h.y + half.y || fabs(m.z - middle.z) >= h.z + half.z)
        return count;
    if (!level) {
        found[count++] = node;
        return count;
    }
    int end = FAN * node + FAN < t->count[level - 1] ? FAN * node + FAN : t->count[level - 1];
    for (int i = FAN * node; i < end; i++) count = gather_box(t, level - 1, i, middle, half, found, count);
    return count;
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
    if (number >= 2 * scene->n) {
        Polygon screen;
        screen.n = 3;
        memcpy(screen.at, leg->screen + 3 * (number - 2 * scene->n), 3 * sizeof(Vec));
        plane->normal = unit_of(vcross(vsub(screen.at[1], screen.at[0]), vsub(screen.at[2], screen.at[0])));
        plane->offset = vdot(plane->normal, screen.at[0]);
        return screen;
    }
    int i = number < scene->n ? number : number - scene->n;
    Polygon p = piece_of(scene, i);
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
    if (!view->which || !view->box || !view->stamp || !view->seen) return 0;
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
    free(view->begin);
    free(view->member);
}

/* A path so far: pieces in a row from the antenna, the images of the eye in them, and the leg out. */
typedef struct {
    int n, chain[2], leg;
    Vec eye[3];
} Path;

/* Shades a region on a piece from an occluder that lies before it, mirrored in the last `from` pieces of a path. */
static void shade_by(const Scene *scene, Regions *list, Polygon *occluder, Plane plane, const Path *path, int from, Vec eye, int first) {
    for (int k = from; k < path->n; k++) {
        Plane mirror = scene->plane[path->chain[k]];
        for (int i = 0; i < occluder->n; i++) occluder->at[i] = mirrored(occluder->at[i], mirror);
        plane.normal = reflected(plane.normal, mirror.normal);
    }
    plane.offset = vdot(plane.normal, occluder->at[0]);
    shade(list, occluder->at, occluder->n, eye, plane, first);
}

static inline void shade_by_view(Aspect *a, Regions *list, const View *view, int f, int own, const Path *path, Vec eye, double water) {
    const Scene *scene = a->scene;
    int number = view->which[f];
    if (number == own || (number < scene->n && scene->patch[number] == scene->patch[own])) return;
    Plane plane;
    Polygon occluder = occluder_of(scene, &view->leg, number, water, &plane);
    if (path && !keep_before(&occluder, scene->plane[own])) return;
    Path none = {0, {0, 0}, 0, {eye, eye, eye}};
    shade_by(scene, list, &occluder, plane, path ? path : &none, 0, eye, number < own);
}

/* Takes out of regions what is hidden from a view. `window`: as the view has it on piece `own`; with a path, the regions lie on its
 * next piece, mirrored. */
static void hide(Aspect *a, Regions *list, View *view, const Polygon *window, int own, const Path *path, Vec eye, double water) {
    double box[6];
    int cell[4];
    box_in(view, window, box);
    cells_of(view, box, cell);
    view->now++;
    for (int v = cell[2]; v <= cell[3] && list->n; v++)
        for (int u = cell[0]; u <= cell[1] && list->n && !is_worn_out(a); u++) {
            list->work += (view->begin[v * view->fine + u + 1] - view->begin[v * view->fine + u]) / 8; /* the quick ones */
            for (int m = view->begin[v * view->fine + u]; m < view->begin[v * view->fine + u + 1] && list->n; m++) {
                int f = view->member[m];
                const double *other = view->box + 5 * f;
                if (view->stamp[f] == view->now) continue;
                view->stamp[f] = view->now;
                if (other[0] >= box[1] || other[1] <= box[0] || other[2] >= box[3] || other[3] <= box[2] || other[4] >= box[5]) continue;
                shade_by_view(a, list, view, f, own, path, eye, water);
            }
        }
    if (is_worn_out(a)) list->n = 0;
}

/* Takes out of regions on piece `to` what is hidden on the way from a window on piece `from`. eye: the image that lights it from
 * there; last: of the path, if the regions lie one piece further on, else NULL. */
static void hide_between(Aspect *a, Regions *list, int from, int to, const Polygon *window, const Polygon *there, Vec eye,
                         const Path *last, Vec last_eye) {
    const Scene *scene = a->scene;
    Vec low = window->at[0], high = low;
    for (int i = 0; i < window->n + there->n; i++) {
        Vec p = i < window->n ? window->at[i] : there->at[i - window->n];
        low = vec(smaller(low.x, p.x), smaller(low.y, p.y), smaller(low.z, p.z));
        high = vec(larger(high.x, p.x), larger(high.y, p.y), larger(high.z, p.z));
    }
    int found = 0, top = a->tree.levels - 1;
    for (int i = 0; i < a->tree.count[top]; i++)
        found = gather_box(&a->tree, top, i, vscale(vadd(low, high), 0.5), vscale(vsub(high, low), 0.5), a->near_list, found);
    for (int k = 0; k < found && list->n && !is_worn_out(a); k++) {
        int c = a->near_list[k];
        if (c == from || c == to || scene->patch[c] == scene->patch[to] || height_over(scene->plane[c], eye) <= THIN) continue;
        Polygon occluder = piece_of(scene, c);
        if (!keep_before(&occluder, scene->plane[from])) continue;
        if (last) {
            if (!keep_before(&occluder, scene->plane[to])) continue;
            shade_by(scene, list, &occluder, scene->plane[c], last, last->n - 1, last_eye, 0);
        } else {
            shade(list, occluder.at, occluder.n, eye, scene->plane[c], c < to);
        }
    }
    if (is_worn_out(a)) list->n = 0;
}

#endif
