"""Walls of vessels that echo as no ship does, as `check` reports them: upright over a reflecting sea, or facing few aspects."""

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.world.body import Body
from radar_service.world.environment import Environment
from radar_service.world.materials import power_reflectivity

STEEPEST = 0.5  # of a wall's normal, its rise: flatter surfaces are decks and roofs, which waves graze
UPRIGHT = np.deg2rad(0.1)  # off upright: a wall 10 m high then leans by half a wavelength of X band
MOST_UPRIGHT = 0.2  # of the area of walls: plain hulls and shipped meshes have 0.27 to 0.84, other hull types 0.04 to 0.13
FACING = np.deg2rad(5.0)  # off a wall's normal: farther off the echo of a flat wall is 50 dB below its flash
MOST_DARK = 0.5  # of all aspects: plain hulls have 0.55 to 0.71, shipped meshes 0.04 to 0.36, other hull types 0.01 to 0.2
METAL = 0.5  # power reflectivity above which a wall is metal
ASPECTS = 720


def vessel_remarks(body: Body, environment: Environment) -> list[str]:
    """Sentences about the walls of a vessel; none about other bodies."""
    if not body.is_vessel or body.mesh is None:
        return []
    normal, area = normals_and_areas(body.mesh)
    dry = body.mesh.vertices[body.mesh.faces][:, :, 2].max(axis=1) + float(body.motion.position[0, 2]) > 0.0
    walls = dry & (np.abs(normal[:, 2]) < STEEPEST)
    if not walls.any():
        return []
    return _upright(body, environment, normal[walls], area[walls]) + _dark(normal[walls])


def _upright(body: Body, environment: Environment, normal: Floats, area: Floats) -> list[str]:
    share = upright_share(normal, area)
    metal = power_reflectivity(body.material.name) > METAL
    if not (environment.multipath and metal and body.motion.sway is None and share > MOST_UPRIGHT):
        return []
    return [
        f"{body.material.name}, upright, over a reflecting sea: {100.0 * share:.0f} % of its walls make right corners with the "
        "sea, which lifts its echo by some 10 dB at all aspects; add seaway = true to [environment], or list_deg and trim_deg"
    ]


def _dark(normal: Floats) -> list[str]:
    share = dark_share(normal)
    if share <= MOST_DARK:
        return []
    return [
        f"flat plates: echo at broadside alone; no wall faces {100.0 * share:.0f} % of the aspects within "
        f"{np.rad2deg(FACING):.0f} degrees: take a hull_type, model masts and rails, or declare rcs_dbsm"
    ]


def upright_share(normal: Floats, area: Floats) -> float:
    """The share of the area of walls that is upright. normal: (F, 3) unit normals; area: (F,) [m^2]."""
    return float(area[np.abs(normal[:, 2]) < np.sin(UPRIGHT)].sum() / area.sum())


def dark_share(normal: Floats) -> float:
    """The share of all aspects that no wall faces within FACING. normal: (F, 3) of walls."""
    faced = np.unique(np.round(np.arctan2(normal[:, 0], normal[:, 1]), 4))
    aspect = 2.0 * np.pi * np.arange(ASPECTS) / ASPECTS
    gaps = np.diff(np.concatenate([faced, faced[:1] + 2.0 * np.pi]))
    number = np.searchsorted(faced, np.mod(aspect - faced[0], 2.0 * np.pi) + faced[0], side="right") - 1
    past = np.mod(aspect - faced[number], 2.0 * np.pi)
    return float((np.minimum(past, gaps[number] - past) > FACING).mean())
