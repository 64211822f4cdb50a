"""The field over the sea at a body where diffraction counts: a profile over height.

Where both rays still reach the body, diffraction changes the ray by the sea: its field over the direct one is the ratio by which
both add up to the field F. Where they come at less than a milliradian from each other (X band), and behind the horizon, one leg
stands for all paths: a piece scatters as the direct ray has it, times F for each way.

Echoes have the ratio or F^2 at the scattering centres, from azimuth to azimuth (`echo.sea_paths`); the profile says what it is
between them.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from radar_service.numerics.types import Complexes, Floats
from radar_service.propagation.diffraction import MAX_HEIGHT, diffraction_height
from radar_service.propagation.land_reflection import ABOVE_LAND, LandBefore
from radar_service.propagation.radar_equation import radar_two_rays
from radar_service.radar.parameters import Radar
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.environment import Environment

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
