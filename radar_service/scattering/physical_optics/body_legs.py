"""Legs in the frame of a body: direct or by the sea, with their rays, their lengths, and what hides the body on the way.

Where diffraction counts, a profile over height is the field at a body. Where both rays reach it, the ray by the sea is changed by
the ratio; where they come as one, and behind the horizon, one leg stands for all paths, times F for each way (`echo.sea_paths`
has both from azimuth to azimuth).
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Complexes, Floats, body_rotation, map_from_body
from radar_service.propagation import ABOVE_LAND, MAX_HEIGHT, LandBefore, diffraction_height, radar_two_rays
from radar_service.radar import Radar
from radar_service.scattering.physical_optics.cast_shadows import CastShadows
from radar_service.trace import OcclusionScene
from radar_service.world import BodyPose, Environment

HEIGHTS = 40.0  # in a natural height (4.8 m in X band): linear in between, the field errs by 0.1 % of the direct one
FLATTEST = 1.5  # m of height that a cell may have over the sea: 0.5 rad of 2 k h1 dz dR / R^2 at 300 m after 5 m of way
ONE_LEG = 0.5  # m sin(grazing) at the foot of a body below which one leg stands for all paths; there, in natural heights,
FLATTEST_SHARE = 0.3  # is what a cell may have: F^2 turns by 0.6 rad over it at most,
LONGEST, SHORTEST = 0.1, 0.02  # and the edges of pieces: linear over one, F^2 errs by 1 % of the direct ray's; in between,
EDGES = 12.0  # so many are in the height of a body: linear over one, the square of the height has 1 % too much


def ground_before(radar: Radar, environment: Environment, scene: OcclusionScene, antenna: Floats, box: Floats) -> float:
    """Height [m] of the land that reflects to the middle of a box (8, 3) on the map [m]; 0 where the sea does, or nothing."""
    if not environment.multipath or scene.land is None:
        return 0.0
    land = LandBefore(scene, antenna, box.mean(axis=0)[None] - antenna)
    level = float(np.max(radar_two_rays(radar, environment, *land.site, land=land).level))
    return level + ABOVE_LAND if level else 0.0


@dataclass(frozen=True)
class SeaField:
    """The field at one distance.

    height: (N,) above the sea, rising from 0 [m].
    field: (N,) over that of the direct ray, one way; of all paths, or of the way by the sea without its own phase.
    all_paths: which of both.
    natural: natural height [m].
    top: of the body above the sea [m].
    """

    height: Floats
    field: Complexes
    all_paths: bool
    natural: float
    top: float

    @classmethod
    def at_body(
        cls, radar: Radar, environment: Environment, distances: tuple[float, float], top: float, antenna_height: float
    ) -> Self | None:
        """The field at a body up to `top` above the sea; None where the two rays alone reach all of it.

        distances: along the earth to its middle and to its far end; antenna_height: as it sways, all in [m].
        """
        if not environment.diffraction:
            return None
        foot = radar_two_rays(radar, environment, np.array([distances[1]]), np.zeros(1), antenna_height)
        if foot.share[0] == 1.0:
            return None
        natural = diffraction_height(radar, environment) / MAX_HEIGHT
        wavenumber = 2.0 * np.pi / radar.wavelength
        all_paths = bool(
            wavenumber * natural * np.sin(foot.geometry.grazing[0]) < ONE_LEG
        )  # m is k times the natural height
        ceiling = top + FLATTEST  # the highest scattering centres lie above the body
        height = np.linspace(0.0, ceiling, int(HEIGHTS * ceiling / natural) + 2)
        rays = radar_two_rays(radar, environment, np.full(len(height), distances[0]), height, antenna_height)
        if not all_paths:
            return cls(height, rays.ratio, False, natural, top)
        phase = np.exp(-1j * wavenumber * rays.geometry.excess)
        return cls(height, np.where(rays.arrives, 1.0 + rays.ratio * phase, 0.0), True, natural, top)

    @property
    def flattest(self) -> float:
        """The height that cells may have where a leg stands for all paths [m]."""
        return min(FLATTEST, FLATTEST_SHARE * self.natural)

    @property
    def longest(self) -> float:
        """The longest edge of pieces there [m], in half octaves."""
        longest = np.clip(self.top / EDGES, SHORTEST * self.natural, LONGEST * self.natural)
        return float(2.0 ** (np.floor(2.0 * np.log2(longest)) / 2.0))

    def at(self, height: Floats) -> Complexes:
        """The field (M,) at heights above the sea (M,) [m]."""
        return np.asarray(np.interp(height, self.height, self.field))


@dataclass(frozen=True)
class BodyLeg:
    """One leg between the antenna and a body.

    by_sea: whether the sea reflects it.
    pose: of the body.
    antenna: (3,) on the map [m].
    earth_radius: effective, inf for flat [m].
    sea: the field of this leg where diffraction counts; of all paths where it stands for them; None: that of a ray.
    others: what other bodies hide; None: nothing.
    """

    by_sea: bool
    pose: BodyPose
    antenna: Floats
    earth_radius: float
    sea: SeaField | None = None
    others: CastShadows | None = None

    def eye(self, middle: Floats) -> Floats:
        """The point (3,) in the body's frame from which straight lines run as the leg does about the middle (3,) of the body
        [m]."""
        length, direction = np.empty(1), np.empty(3)
        KERNELS.leg_rays(1, self.by_sea, *self._to(middle[None]), length, direction[None])
        return np.asarray(middle - length * direction / np.linalg.norm(direction))

    def screens(self, middle: Floats, eye: Floats) -> Floats:
        """The triangles (T, 3, 3) of other bodies that hide parts of this one, as the eye has them in the body's frame [m];
        middle, eye: as of `eye`."""
        if self.others is None or not len(self.others):
            return np.zeros((0, 3, 3))
        flipped = np.array([1.0, 1.0, -1.0 if self.by_sea else 1.0])

        def turned(virtual: Floats) -> Floats:
            return np.asarray(virtual * flipped @ body_rotation(self.pose.heading))

        ahead, seen = middle - eye, turned(self.others.picture.virtual(self.on_map(middle)))
        level = ahead[:2] / max(np.hypot(*ahead[:2]), 1e-9)
        lift = np.arctan2(ahead[2], ahead[:2] @ level) - np.arctan2(seen[2], seen[:2] @ level)
        corners = turned(self.others.corners)
        along, up = corners[..., :2] @ level, corners[..., 2]
        farther = along * (np.cos(lift) - 1.0) - up * np.sin(lift)
        corners[..., :2] += farther[..., None] * level
        corners[..., 2] = along * np.sin(lift) + up * np.cos(lift)
        return np.asarray(eye + corners)

    def on_map(self, points: Floats) -> Floats:
        """Points (..., 3) of the body's frame on the map [m]."""
        return map_from_body(points, self.pose.position, self.pose.heading)

    def length(self, points: Floats) -> Floats:
        """Lengths (M,) of the leg to points (M, 3) in the body's frame [m]."""
        length = np.empty(len(points))
        KERNELS.leg_lengths(len(points), self.by_sea, *self._to(points), length)
        return length

    def weight(self, points: Floats) -> Complexes | Floats:
        """What fields at points (M, 3) in the body's frame [m] are multiplied by (M,), besides their way: 1 of the direct leg,
        what the curved sea leaves of the one by it, or what `sea` says."""
        if self.sea is not None:
            return self.sea.at(points[:, 2] + float(self.pose.position[2]))
        if not self.by_sea:
            return np.ones(len(points))
        weight = np.empty(len(points))
        KERNELS.leg_weights(len(points), *self._to(points), weight)
        return weight

    def _to(self, points: Floats) -> tuple[Floats, Floats, float, float, Floats, float]:
        """What kernels take of the leg to points (M, 3) in the body's frame [m]."""
        pose, heading = self.pose, self.pose.heading
        return (
            np.ascontiguousarray(points), np.ascontiguousarray(pose.position), math.cos(heading), math.sin(heading),
            np.ascontiguousarray(self.antenna), self.earth_radius,
        )  # fmt: skip
