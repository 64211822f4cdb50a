"""Warns of settings outside the valid region of a method and of bodies in unusual positions; refuses powers that overflow.

The limits come from `radar-service stability`.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from radar_service.numerics import KNOT, Floats, Indices
from radar_service.radar import Radar, least_chirp_error_db, pulse_doppler_shift, remedies
from radar_service.scattering import highest_rcs
from radar_service.world import Body, Motion, Platform, SceneError, World, is_land, pose_at

MAX_CHIRP_ERROR_DB = -40.0  # of the field, what the samples fold: the default error budget
MAX_STATIC_EXTENT = 150_000.0  # m between bodies at rest: above, visibility is wrong on 1 % of a 1 m body's surface
MAX_DOPPLER_SHIFT = 0.5  # range cells c / 2B: the shift within the pulse is not modelled
MAX_POWER = 1e34  # W: transforms in single precision overflow at 3.4e38
TEST_POINTS = 16  # of a body, besides its highest: a body is under the ground if all of them are
PLUMB_LINE_OFFSET = np.array([1.7e-6, 2.3e-6])  # m: a line through a shared corner counts each of its triangles
TRIANGLES = 2**18  # at a time
ALL_SIDES = 15  # bits of a triangle with corners on either side of the plumb line both ways


def validity_warnings(world: World, radar: Radar, platform: Platform) -> Iterator[str]:
    """Yields a warning for each setting with which echoes may be inaccurate."""
    for pulse in radar.of_each_pulse:
        yield from _folding(pulse)
        yield from _doppler(world, pulse, platform)
    yield from _static_extent(world.bodies)


def check_echo_power(radar: Radar, bodies: Sequence[Body]) -> None:
    """Raises SceneError if an echo at radar.range_min_m could overflow single precision."""
    rcs = sum(body.rcs for body in bodies if body.rcs is not None)
    rcs += sum(highest_rcs(body.reflector, radar.wavelength) for body in bodies if body.reflector is not None)
    constant = radar.power * radar.gain**2 * radar.wavelength**2 / ((4.0 * np.pi) ** 3 * radar.loss)
    with np.errstate(over="ignore", divide="ignore"):
        maximum = float(np.float64(constant) * rcs / np.float64(radar.range_min) ** 4)
    if maximum > MAX_POWER:
        raise SceneError(
            f"radar.range_min_m: {radar.range_min:g} m, with this power and gain and {rcs:g} m2 of bodies, allows echoes of "
            f"{maximum:.0e} W; at most {MAX_POWER:.0e} W can be computed: raise range_min_m or lower gain_dbi or power_w"
        )


def check_antenna(radar: Radar, own_ship: Motion) -> None:
    """Raises SceneError if sway dips the antenna into the sea."""
    sway = own_ship.sway
    if sway is None:
        return
    lowest, heave = radar.height * float(np.prod(np.cos(sway.likely_values[:2]))), float(sway.likely_values[3])
    if heave >= lowest:
        raise SceneError(
            f"own_ship.heave_m: {heave:g} m dips the antenna into the sea; roll and pitch leave it {lowest:.1f} m up: "
            f"give less than {lowest:.1f} m, or raise radar.height_m"
        )


def _folding(radar: Radar) -> Iterator[str]:
    """Warns where a chirp's spectrum exceeds the sampled band so far that the field errs."""
    if radar.modulation == "none" or (error := least_chirp_error_db(radar)) <= MAX_CHIRP_ERROR_DB:
        return
    product, ratio = radar.bandwidth * radar.pulse, radar.sample_rate / radar.bandwidth
    helpful = remedies(radar, least_chirp_error_db, MAX_CHIRP_ERROR_DB) or "raise sample_rate_hz and lengthen pulse_s"
    yield (
        f"radar.sample_rate_hz: with bandwidth x pulse {product:.3g}, window {radar.window} and {ratio:.3g} x bandwidth, the "
        f"chirp's spectrum exceeds the sampled band: the field error is {error:.0f} dB, above {MAX_CHIRP_ERROR_DB:.0f} dB: "
        f"{helpful}"
    )


def _doppler(world: World, radar: Radar, platform: Platform) -> Iterator[str]:
    if radar.modulation == "none":
        return
    speed = platform.motion.top_speed + max((body.motion.top_speed for body in world.bodies), default=0.0)
    cells = pulse_doppler_shift(speed, radar.pulse, radar.wavelength, radar.chirp.doppler_coupling)
    if cells > MAX_DOPPLER_SHIFT:
        yield (
            f"radar.pulse_s: at {speed / KNOT:.0f} kn Doppler within a pulse of {radar.pulse:g} s moves echoes by {cells:.2g} "
            "range cells; the simulation models motion between spokes only: shorten the pulse for exact ranges"
        )


def _static_extent(bodies: Sequence[Body]) -> Iterator[str]:
    middles = [body.middle_at(0.0) for body in bodies if body.mesh is not None and body.motion.at_rest]
    if len(middles) < 2:
        return
    span = float(np.ptp(np.array(middles)[:, :2], axis=0).max())
    if span > MAX_STATIC_EXTENT:
        yield (
            f"body: bodies at rest are {span / 1000:.0f} km apart, so lines of sight are accurate to "
            f"{span / 2.0 * 2**-24:.2g} m only and small bodies may occlude themselves: remove bodies that stay out of range"
        )


def placement_warnings(
    world: World, radar: Radar, platform: Platform, terrain: Sequence[int] = (), *, is_afloat: bool = True
) -> tuple[str, ...]:
    """Returns a warning for each body in an unusual position at the start, with the effect on its echo.

    terrain: indices of the bodies that are height maps. is_afloat: whether the platform is a ship, below which no land may be.
    """
    antenna = platform.antenna(0.0, radar.height)[0]
    ground = [Ground(world.bodies[i]) for i in terrain if len(world.bodies) > len(terrain)]
    return tuple(
        warning
        for i, body in enumerate(world.bodies)
        if body.name != platform.body
        and (
            warning := _placement_warning(body, f"body[{i}]", antenna, radar.range_min, () if i in terrain else ground)
            or (_ground_below(body, f"body[{i}]", antenna, platform) if is_afloat and is_land(body) else "")
        )
    )


def _ground_below(body: Body, location: str, antenna: Floats, platform: Platform) -> str:
    """A warning where land rises from the sea below the antenna."""
    assert body.mesh is not None
    corners, sea = _corners_on_map(body), np.array([*antenna[:2], 0.0])
    if surfaces_above(corners, body.mesh.faces, sea) == surfaces_above(corners, body.mesh.faces, antenna):
        return ""
    return (
        f"{location}: {platform.body or 'own ship'} is on land, which {body.name} has below its antenna; move it to the water, "
        "or give the radar a platform of its own ashore"
    )


class Ground:
    """A height map that may cover other bodies. Its triangles are sorted by their western edge."""

    def __init__(self, body: Body) -> None:
        assert body.mesh is not None
        corners = _corners_on_map(body)[body.mesh.faces]
        west = corners[:, :, 0].min(axis=1)
        order = np.argsort(west)
        self.name, self._corners, self._west = body.name, corners[order], west[order]
        self._max_width = float(np.ptp(corners[:, :, 0], axis=1).max())

    def covers(self, points: Floats) -> bool:
        """Returns whether the map is above the highest of points (P, 3) [m] and above a sample of the others."""
        sample = points[:: max(1, len(points) // TEST_POINTS)]
        return all(self._covers(point) for point in (points[np.argmax(points[:, 2])], *sample))

    def _covers(self, point: Floats) -> bool:
        first, end = np.searchsorted(self._west, [point[0] - self._max_width - 1.0, point[0] + 1.0])
        near = self._corners[first:end].reshape(-1, 3)
        return len(near) > 0 and surfaces_above(near, np.arange(len(near)).reshape(-1, 3), point) > 0


def _corners_on_map(body: Body) -> Floats:
    """Returns the vertices (V, 3) [m] of a body at the start of the simulation, or the position (1, 3) of a point."""
    pose = pose_at(body, max(float(body.motion.time[0]), 0.0))
    points = np.zeros((1, 3)) if body.mesh is None else body.mesh.vertices
    return pose.map_from_frame(points)


def _placement_warning(body: Body, location: str, antenna: Floats, range_min: float, grounds: Sequence[Ground]) -> str:
    corners = _corners_on_map(body)
    if corners[:, 2].max() < 0.0:
        return f"{location}: {body.name} is entirely below the sea, so it has no echo; raise it"
    covering = [ground.name for ground in grounds if ground.covers(corners)]
    if covering:
        return f"{location}: {body.name} is under the ground of {covering[0]}, so it has no echo; raise it"
    if body.mesh is None:
        distance = float(np.linalg.norm(corners[0] - antenna))
        if distance >= range_min:
            return ""
        return (
            f"{location}: {body.name} is {distance:.3g} m from the antenna; its echo is computed at range_min_m, "
            f"{range_min:g} m"
        )
    if surfaces_above(corners, body.mesh.faces, antenna) % 2 == 0:
        return ""
    return f"{location}: the antenna is inside or under {body.name}, which occludes all other bodies; move one of the two"


def surfaces_above(vertices: Floats, faces: Indices, point: Floats) -> int:
    """Returns how many triangles, faces (F, 3) of vertices (V, 3) [m], the plumb line crosses above `point` (3,) [m]."""
    foot = point[:2] + PLUMB_LINE_OFFSET
    if (vertices[:, :2].min(axis=0) > foot).any() or (vertices[:, :2].max(axis=0) < foot).any():
        return 0
    side = np.zeros(len(vertices), dtype=np.uint8)  # a bit each for west, east, south, north: a byte is read fast
    for axis in (0, 1):
        side |= (vertices[:, axis] <= foot[axis]) * np.uint8(1 << 2 * axis)
        side |= (vertices[:, axis] >= foot[axis]) * np.uint8(2 << 2 * axis)
    sides = side.take(faces[:, 0])
    for corner in (1, 2):
        sides |= side.take(faces[:, corner])
    near = np.flatnonzero(sides == ALL_SIDES)
    e, n, up = (vertices[:, axis][faces[near]] - [*foot, 0.0][axis] for axis in range(3))
    # twice the signed areas into which the plumb line cuts the triangle: all of one sign inside
    share = np.stack([e[:, i] * n[:, j] - e[:, j] * n[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
    inside = (share > 0).all(axis=1) | (share < 0).all(axis=1)
    height = np.einsum("ij,ij->i", share[inside], up[inside]) / share[inside].sum(axis=1)
    return int(np.count_nonzero(height > point[2]))


def nearest_point(vertices: Floats, faces: Indices, point: Floats) -> Floats:
    """Returns the point (3,) [m] of triangles, faces (F, 3) of vertices (V, 3) [m], that is nearest to `point` (3,) in plan.

    Its height is that of `point`.
    """
    if surfaces_above(vertices, faces, np.array([*point[:2], -np.inf])):
        return point
    feet = []
    for first in range(0, len(faces), TRIANGLES):
        corners = vertices[faces[first : first + TRIANGLES], :2] - point[:2]
        along = np.roll(corners, -1, axis=1) - corners
        share = -(corners * along).sum(axis=2) / np.maximum((along**2).sum(axis=2), 1e-300)
        foot = (corners + np.clip(share, 0.0, 1.0)[..., None] * along).reshape(-1, 2)
        feet.append(foot[np.argmin((foot**2).sum(axis=1))])
    nearest = min(feet, key=lambda foot: float(np.hypot(*foot)))
    return np.array([*point[:2] + nearest, point[2]])
