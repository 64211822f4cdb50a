/* Which hulls of points may stand before a body in the antenna's picture: scattering/physical_optics/picture.py, cast_shadows.py. */

#include "geometry.h"
#include "shadows.h"

static const double AROUND = 1.5, ROUNDING = 1e-9, PI = 3.141592653589793; /* of picture.py; PI of numpy */

/* The lowest and the highest slope between heights: `_slopes`. */
static void slopes(Window *window, double bottom, double top, double antenna_height, double earth_radius, int by_sea) {
    window->low = INFINITY;
    window->high = -INFINITY;
    if (!(top > 0.0)) return;
    bottom = larger(bottom, 0.0);
    double near = window->nearest, far = window->farthest;
    double raised = virtual_height(near, top, antenna_height, earth_radius, by_sea);
    double sunk = virtual_height(far, bottom, antenna_height, earth_radius, by_sea);
    if (by_sea) {
        window->low = raised / near;
        window->high = sunk / far;
    } else {
        window->low = sunk < 0.0 ? sunk / near : sunk / far;
        window->high = raised > 0.0 ? raised / near : raised / far;
    }
}

/* The window of a hull of points (P, 3), P = corners, in a frame: `Windows.of`, but for its slopes; the lowest and highest point. */
static Window plan_window(const double *points, int64_t corners, const double *matrix, const double *position,
                          const double *antenna, double *bottom, double *top) {
    double east[8], north[8], to_east = 0.0, to_north = 0.0, ahead_most = INFINITY;
    Window window = {0.0, 0.0, INFINITY, -INFINITY, 0.0, 0.0};
    *bottom = INFINITY;
    *top = -INFINITY;
    for (int64_t i = 0; i < corners; i++) {
        const double *point = points + 3 * i;
        double z = dot(matrix + 6, point) + position[2];
        east[i] = dot(matrix, point) + position[0] - antenna[0];
        north[i] = dot(matrix + 3, point) + position[1] - antenna[1];
        to_east += east[i];
        to_north += north[i];
        *bottom = smaller(*bottom, z);
        *top = larger(*top, z);
        window.farthest = larger(window.farthest, sqrt(east[i] * east[i] + north[i] * north[i]));
    }
    to_east /= (double)corners;
    to_north /= (double)corners;
    double scale = larger(sqrt(to_east * to_east + to_north * to_north), NEAREST * NEAREST);
    double widest_aside = 0.0, widest_ahead = 1.0; /* of the corner farthest off the middle in angle */
    for (int64_t i = 0; i < corners; i++) {
        double ahead = (east[i] * to_east + north[i] * to_north) / scale, aside = fabs(east[i] * to_north - north[i] * to_east) / scale;
        double turn = aside * widest_ahead - ahead * widest_aside;
        if (turn > 0.0 || (ahead < 0.0 && widest_ahead >= 0.0)) {
            widest_aside = aside;
            widest_ahead = ahead;
        }
        ahead_most = smaller(ahead_most, ahead);
    }
    double half = atan2(widest_aside, widest_ahead);
    int around = half > AROUND || scale < NEAREST;
    window.nearest = larger(around ? 0.0 : ahead_most, NEAREST);
    window.half = around ? PI : half;
    window.middle = atan2(to_east, to_north);
    return window;
}

static Window widened(Window window, double by) {
    double angle = 2.0 * by / window.nearest;
    Window result = {window.middle, window.half + angle, window.low - angle, window.high + angle,
                     larger(window.nearest - by, NEAREST), window.farthest + by};
    return result;
}

static int before(const Window *window, const Window *other) {
    double turns = (window->middle - other->middle) / (2.0 * PI), aside = fabs(turns - rint(turns)) * 2.0 * PI;
    return aside <= window->half + other->half + ROUNDING && window->nearest < other->farthest;
}

static int overlap(const Window *window, const Window *other) {
    return before(window, other) && !(window->low > other->high + ROUNDING || window->high < other->low - ROUNDING);
}

/* Which hulls of points (N, P, 3), N = count, P = corners of up to 8, may stand before a body along a leg: stand_before.
 *
 * matrix (3, 3), position (3): from the frame of the points to the map. moved: how far they may be from there [m]. own (L, 6), L =
 * legs: windows of the body, directly and by the sea. */
/* Arrays: corners from 1 < 9; legs from 1 < 3; points (count, corners, 3); matrix (3, 3); position, antenna (3); own (legs, 6); stand (count) */
KERNEL int64_t stand_before(int64_t count, int64_t corners, int64_t legs, const double *points, const double *matrix,
                            const double *position, const double *antenna, double earth_radius, double moved, const double *own,
                            uint8_t *stand) {
    Window others[2];
    for (int64_t leg = 0; leg < legs; leg++) {
        const double *at = own + WINDOW_SIZES * leg;
        others[leg] = (Window){at[0], at[1], at[2], at[3], at[4], at[5]};
    }
    for (int64_t i = 0; i < count; i++) {
        double bottom, top;
        Window plan = plan_window(points + 3 * corners * i, corners, matrix, position, antenna, &bottom, &top);
        Window wide = widened(plan, moved);
        int aside = 1;
        for (int64_t leg = 0; leg < legs; leg++) aside &= !before(&wide, &others[leg]);
        stand[i] = 0;
        for (int by_sea = 0; by_sea < legs && !aside && !stand[i]; by_sea++) {
            Window seen = plan;
            slopes(&seen, bottom, top, antenna[2], earth_radius, by_sea);
            wide = widened(seen, moved);
            for (int64_t leg = by_sea; leg < legs; leg++) stand[i] |= (uint8_t)overlap(&wide, &others[leg]);
        }
    }
    return count;
}

/* The window of the hull of points (P, 3) on the map, P = corners of up to 8, in the picture of a leg: `Windows.of`. */
Window window_of(const double *points, int64_t corners, const double *antenna, double earth_radius, int by_sea) {
    static const double matrix[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, position[3] = {0.0, 0.0, 0.0};
    double bottom, top;
    Window window = plan_window(points, corners, matrix, position, antenna, &bottom, &top);
    slopes(&window, bottom, top, antenna[2], earth_radius, by_sea);
    return window;
}
