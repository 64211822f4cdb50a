"""Paths of echoes by the sea: ranges and factors of echoes of one path, and of those that stand for all paths (`BodyEchoes`).

An echo that goes p of its two ways by the sea has the range R + p (R' - R) / 2, R' the length by the sea, and the p-th power of
the field by the sea over the direct one. An echo of all paths has the range R and F^2.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.echo.range_history import Parabola
from radar_service.numerics import Complexes, Flags, Floats, Indices, Polar, Profiles, Singles
from radar_service.propagation import (
    LandBefore,
    Site,
    TwoRays,
    attenuation,
    elevation_gain,
    mean_square_factor,
    moved_excess,
    radar_two_rays,
    turned_back,
)
from radar_service.radar import Radar
from radar_service.world import Environment

MAX_PHASE = 5e-4  # rad over half a block: F^2 held over less errs by -69 dB (0.67 of it, rms)
MAX_ELEVATION = 1e-3  # of the vertical beamwidth: roots of gains held over less err by 1.3e-3 of boresight, -62 dB rms
MAX_RISE = 1e-3  # of a height over half a block: a diffracted F^2 held over less errs by -60 dB (0.5 of 2e-3, rms)
NULL = 1e-6  # of boresight: lower gains count as this one where a ratio of gains follows the sway


class Paths(NamedTuple):
    """What echoes (E,) stand for, as in `BodyEchoes`: path (E,), and height_span (E,) [m]."""

    path: Indices
    height_span: Floats

    @property
    def by_sea(self) -> Floats:
        """Share (E,) of an echo's way that goes by the sea: 0, 1/2 or 1; 0 for echoes of all paths."""
        return np.asarray(np.maximum(self.path, 0) / 2.0)

    def chosen(self, which: Indices | slice) -> "Paths":
        """The paths of echoes `which`, indices (N,) or a slice."""
        return Paths(self.path[which], self.height_span[which])

    def factor(
        self, ratio: Complexes | Profiles, phase: Floats | Singles, phase_span: Floats | Singles
    ) -> Complexes | Profiles:
        """Factors (E, ...) beside the direct ray: F^2, its mean over a height, or the ratio by the path.

        ratio: (E, ...) of `TwoRays`; phase: (E, ...) k times the excess [rad]; phase_span: (E,) what `mean_square_factor` takes.
        """
        factor: Complexes | Profiles = np.ones(phase.shape, dtype=ratio.dtype)
        points = np.flatnonzero((self.path < 0) & (self.height_span <= 0.0))
        if len(points):
            factor[points] = np.square(1.0 + ratio[points] * turned_back(phase[points]))
        for path in (1, 2):
            single = np.flatnonzero(self.path == path)
            if len(single):
                factor[single] = ratio[single] ** path
        extended = np.flatnonzero((self.path < 0) & (self.height_span > 0.0))
        if len(extended):
            which = slice(None) if len(extended) == len(factor) else extended  # no copies
            span = phase_span[which].reshape(-1, *[1] * (ratio.ndim - 1))
            factor[which] = mean_square_factor(ratio[which], phase[which], span)
        return factor


@dataclass(frozen=True)
class SeaPaths:
    """Both rays to echoes (E,) at one instant, and what the echoes stand for."""

    rays: TwoRays
    paths: Paths
    wavenumber: float

    @property
    def phase_span(self) -> Floats:
        """How far the phase between both rays runs over the height that each echo stands for [rad]."""
        return self.wavenumber * self.rays.geometry.excess_slope * self.paths.height_span * self.rays.share

    def factor(self) -> Complexes:
        """Two-way factor (E,) of elevation gain and paths at this instant; 0 beyond the horizon where nothing diffracts."""
        phase = self.wavenumber * self.rays.geometry.excess
        return np.asarray(self.rays.arrives * self.rays.gain * self.paths.factor(self.rays.ratio, phase, self.phase_span))

    def rises(self, sites: list[Site]) -> Flags:
        """Which diffracted echoes change their height, or the antenna's, by more than MAX_RISE of it between three nodes."""
        if not (self.rays.share < 1.0).any():
            return np.zeros(len(self.rays.share), dtype=np.bool_)
        changed = [
            np.abs(sites[n][part] - sites[1][part]) > MAX_RISE * np.abs(sites[1][part]) for n in (0, 2) for part in (1, 2)
        ]
        return np.asarray((self.rays.share < 1.0) & np.any(np.broadcast_arrays(*changed), axis=0))

    def steep(self, radar: Radar, range_migration: Singles, distance: Floats) -> Flags:
        """Which echoes change the elevation of their reflected ray by more than MAX_ELEVATION within a block.

        range_migration: (E, K) since the middle, where ranges are `distance` (E,) [m].
        """
        moved = np.maximum(np.abs(range_migration[:, 0]), np.abs(range_migration[:, -1]))
        turned = moved * np.abs(self.rays.geometry.elevation_reflected)
        return np.asarray(turned > MAX_ELEVATION * radar.beamwidth_el * distance)


@dataclass
class SeaHistory:
    """How the paths of echoes (E,) change over K azimuths.

    middle: at the middle.
    excess_change: (E, K) of R' - R since the middle [m].
    ratio: (E, K) of `TwoRays` at each azimuth; None where it stays that at the middle.
    changing: (E,) whether the factor is formed at each azimuth.
    rising: (E,) diffracted echoes whose height, or the antenna's, changes too much for a field held over the block.
    """

    middle: SeaPaths
    excess_change: Singles
    ratio: Profiles | None
    changing: Flags
    rising: Flags

    @classmethod
    def interpolated(cls, middle: SeaPaths, sites: list[Site], earth_radius: float, over: Parabola) -> "SeaHistory":
        """By parabolas through three nodes, at which the targets are at `sites`; earth_radius: effective [m]."""
        geometry, level = middle.rays.geometry, middle.rays.level
        above = [(distance, height - level, antenna - level) for distance, height, antenna in sites]
        first, last = (moved_excess(geometry, above[1], above[n], earth_radius) - geometry.excess for n in (0, 2))
        rays = middle.rays.share == 1.0  # a diffracted field is held over the block (where it does not rise)
        first, last = first * rays, last * rays
        changing = np.maximum(np.abs(first), np.abs(last)) * middle.wavenumber > MAX_PHASE
        return cls(middle, over.change(first, last), None, changing & (middle.paths.path < 0), middle.rises(sites))

    def sway(self, radar: Radar, tilt_errors: list[Floats], over: Parabola) -> None:
        """Adds the change of the gains of both rays, for errors of tilt (E,) at the three nodes [rad]."""
        geometry = self.middle.rays.geometry
        directions = geometry.elevation_direct, geometry.elevation_reflected
        roots = []
        for tilt in tilt_errors:
            direct, reflected = (np.maximum(elevation_gain(radar, angle, tilt), NULL) for angle in directions)
            roots.append(np.sqrt(reflected / direct))
        rays = self.middle.rays.share == 1.0  # the series has the direct ray's gain alone
        change = over.change(rays * (roots[0] / roots[1] - 1.0), rays * (roots[2] / roots[1] - 1.0))
        self.ratio = self.middle.rays.ratio.astype(np.complex64)[:, None] * (change + np.float32(1.0))
        self.changing[:] = True

    def replace(self, which: Indices, exact: TwoRays) -> Singles:
        """Takes the rays (K, W) at each azimuth of echoes `which` (W,); returns their direct gains (W, K) over the middle's."""
        rays = self.middle.rays
        self.excess_change[which] = (exact.geometry.excess - rays.geometry.excess[which]).T
        if self.ratio is None:
            self.ratio = np.repeat(rays.ratio.astype(np.complex64)[:, None], self.excess_change.shape[1], axis=1)
        self.ratio[which] = exact.ratio.T
        self.changing[which] = True
        gains: Singles = (exact.gain / rays.gain[which]).T.astype(np.float32)
        return gains

    def add_excess(self, distance: Floats, range_migration: Singles) -> Floats:
        """Adds the excess of paths by the sea to changes of range (E, K) in place; returns ranges (E,) [m] at the middle."""
        share = self.middle.paths.by_sea
        if not share.any():
            return distance
        range_migration += share.astype(np.float32)[:, None] * self.excess_change
        return distance + share * self.middle.rays.geometry.excess

    def held_factor(self) -> Complexes | Floats:
        """Factors (E,) of gain and paths; of changing echoes those of the gain alone."""
        gain = self.middle.rays.gain * self.middle.rays.arrives
        return gain if self.changing.all() else np.where(self.changing, gain, self.middle.factor())

    def apply(self, amplitude: Profiles) -> None:
        """Multiplies amplitudes (E, K) of changing echoes by the factors of their paths at each azimuth."""
        if not self.changing.any():
            return
        which = slice(None) if self.changing.all() else np.flatnonzero(self.changing)
        middle, rays = self.middle, self.middle.rays
        ratio = rays.ratio[which].astype(np.complex64)[:, None] if self.ratio is None else self.ratio[which]
        wavenumber = np.float32(middle.wavenumber)
        phase = wavenumber * self.excess_change[which]
        phase += (middle.wavenumber * rays.geometry.excess[which] % (2.0 * np.pi)).astype(np.float32)[:, None]
        span = middle.phase_span[which].astype(np.float32)
        amplitude[which] *= middle.paths.chosen(which).factor(ratio, phase, span)


def sea_paths(
    radar: Radar, environment: Environment, site: Site, paths: Paths, tilt_error: Floats | float = 0.0,
    land: LandBefore | None = None,
) -> SeaPaths:  # fmt: skip
    """Both rays to the targets at a site; tilt_error: added to elevations in the beam [rad]; land: before the targets."""
    rays = radar_two_rays(radar, environment, *site, tilt_error, land)
    return SeaPaths(rays, paths, 2.0 * np.pi / radar.wavelength)


def range_and_factor(
    radar: Radar,
    environment: Environment,
    polar: Polar,
    height: Floats,
    antenna_height: Floats,
    paths: Paths,
    tilt_error: Floats | float = 0.0,
    land: LandBefore | None = None,
) -> tuple[Floats, Complexes]:
    """Ranges (E,) [m] of echoes at rest and their factors (E,): elevation gain, gas and rain, and paths.

    height: of the targets above the sea (E,) [m]; tilt_error: added to elevations in the beam [rad]; land: before the targets.
    """
    loss = attenuation(radar, environment, polar.range)
    if not environment.multipath:
        return polar.range, (elevation_gain(radar, polar.elevation, tilt_error) * loss).astype(np.complex128)
    sea = sea_paths(radar, environment, (polar.distance, height, antenna_height), paths, tilt_error, land)
    return polar.range + paths.by_sea * sea.rays.geometry.excess, sea.factor() * loss
