/* Legs at points of a body, direct or by the sea: as scattering/physical_optics/body_legs.py asks for them; in numpy tests/reference/legs.py. */

#include "geometry.h"

static const double TINY = 1e-12; /* m */

/* Of one point: distance along the earth [m], horizontal unit vector on the map, height above the sea [m]. */
typedef struct {
    double distance, east, north, height;
} Plan;

static inline Plan plan_of(const double *point, const double *position, double cosine, double sine, const double *antenna) {
    double x = point[0] * cosine + point[1] * sine + position[0] - antenna[0];
    double y = point[1] * cosine - point[0] * sine + position[1] - antenna[1];
    double distance = sqrt(x * x + y * y), over = larger(distance, TINY);
    Plan plan = {distance, x / over, y / over, point[2] + position[2]};
    return plan;
}

/* `reflected_ray` of tests/reference/legs.py: lengths before and beyond the sea, rise over it, sine of the grazing angle. */
typedef struct {
    double first, second, rise, grazing_sine;
} SeaRay;

static inline SeaRay sea_ray(Plan plan, double antenna_height, double earth_radius) {
    double height = larger(plan.height, 0.0), d = plan.distance;
    double x = reflection_distance(d, height, antenna_height, earth_radius), bulge = x * x / (2.0 * earth_radius);
    double rise = height - d * d / (2.0 * earth_radius) + bulge, fall = antenna_height - bulge, up = antenna_height + bulge;
    SeaRay ray = {sqrt(x * x + up * up), sqrt((d - x) * (d - x) + rise * rise), rise, fall / sqrt(x * x + fall * fall)};
    return ray;
}

/* Rays at points (M, 3) in the body's frame [m], M = count: lengths (M) of the leg [m], unit directions (M, 3) of travel in that
 * frame. position, antenna (3) on the map [m]; cosine, sine: of the heading. */
/* Arrays: points (count, 3); position, antenna (3); length (count); direction (count, 3) */
KERNEL int64_t leg_rays(int64_t count, int64_t by_sea, const double *points, const double *position, double cosine, double sine,
                        const double *antenna, double earth_radius, double *length, double *direction) {
    for (int64_t i = 0; i < count; i++) {
        Plan plan = plan_of(points + 3 * i, position, cosine, sine, antenna);
        double z = plan.height - antenna[2] - plan.distance * plan.distance / (2.0 * earth_radius);
        double way = larger(sqrt(plan.distance * plan.distance + z * z), TINY), rise = z / way;
        if (by_sea) {
            SeaRay ray = sea_ray(plan, antenna[2], earth_radius);
            way = ray.first + ray.second;
            rise = ray.rise / larger(ray.second, TINY);
        }
        double flat = sqrt(larger(1.0 - rise * rise, 0.0)), *to = direction + 3 * i;
        length[i] = way;
        to[0] = flat * (plan.east * cosine - plan.north * sine);
        to[1] = flat * (plan.east * sine + plan.north * cosine);
        to[2] = rise;
    }
    return count;
}

/* What the curved sea leaves of fields (M) that it reflects: `sea_divergence` of tests/reference/legs.py; arguments as of `leg_rays`. */
/* Arrays: points (count, 3); position, antenna (3); weight (count) */
KERNEL int64_t leg_weights(int64_t count, const double *points, const double *position, double cosine, double sine,
                           const double *antenna, double earth_radius, double *weight) {
    for (int64_t i = 0; i < count; i++) {
        SeaRay ray = sea_ray(plan_of(points + 3 * i, position, cosine, sine, antenna), antenna[2], earth_radius);
        double fall = earth_radius * (ray.first + ray.second) * larger(ray.grazing_sine, TINY);
        weight[i] = ray.grazing_sine > 0.0 ? 1.0 / sqrt(1.0 + 2.0 * ray.first * ray.second / fall) : 0.0;
    }
    return count;
}

/* Lengths (M) of the legs alone [m]; arguments as of `leg_rays`. */
/* Arrays: points (count, 3); position, antenna (3); length (count) */
KERNEL int64_t leg_lengths(int64_t count, int64_t by_sea, const double *points, const double *position, double cosine, double sine,
                           const double *antenna, double earth_radius, double *length) {
    for (int64_t i = 0; i < count; i++) {
        const double *point = points + 3 * i;
        double x = point[0] * cosine + point[1] * sine + position[0] - antenna[0];
        double y = point[1] * cosine - point[0] * sine + position[1] - antenna[1];
        double distance2 = x * x + y * y, height = point[2] + position[2];
        if (by_sea) {
            Plan plan = {sqrt(distance2), 0.0, 0.0, height};
            SeaRay ray = sea_ray(plan, antenna[2], earth_radius);
            length[i] = ray.first + ray.second;
        } else {
            double z = height - antenna[2] - distance2 / (2.0 * earth_radius);
            length[i] = sqrt(distance2 + z * z);
        }
    }
    return count;
}
