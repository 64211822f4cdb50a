"""Walls of vessels that echo as no ship does, as `check` reports them: upright over a reflecting sea, or facing few aspects."""

from collections.abc import Sequence

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.world.body import Body
from radar_service.world.environment import Environment
from radar_service.world.large_mesh import mesh_sample
from radar_service.world.materials import is_metal

STEEPEST = 0.5  # of a wall's normal, its rise: flatter surfaces are decks and roofs, which waves graze
UPRIGHT = np.deg2rad(0.1)  # off upright: a wall 10 m high then leans by half a wavelength of X band
MOST_UPRIGHT = 0.2  # of the area of walls: plain hulls and shipped meshes have 0.27 to 0.84, other hull types 0.04 to 0.13
FACING = np.deg2rad(5.0)  # off a wall's normal: farther off the echo of a flat wall is 50 dB below its flash
MOST_DARK = 0.5  # of all aspects: plain hulls have 0.55 to 0.71, shipped meshes 0.04 to 0.36, other hull types 0.01 to 0.2
ASPECTS = 720
NAMED = 2  # bodies that a common sentence names


def vessel_remarks(body: Body) -> list[str]:
    """Sentences about the walls of a vessel; none about other bodies."""
    walls = _walls(body)
    share = 0.0 if walls is None else dark_share(walls[0])
    if share <= MOST_DARK:
        return []
    return [
        f"flat plates: echo at broadside alone; no wall faces {100.0 * share:.0f} % of the aspects within "
        f"{np.rad2deg(FACING):.0f} degrees: take a hull_type, model masts and rails, or declare rcs_dbsm"
    ]


def upright_warnings(bodies: Sequence[Body], environment: Environment) -> list[str]:
    """A sentence about those of bodies by physical optics that are metal vessels and stand upright over a reflecting sea."""
    if not environment.multipath:
        return []
    shares = {
        body.name: share
        for body in bodies
        if is_metal(body.material) and body.motion.sway is None
        if (walls := _walls(body)) is not None and (share := upright_share(*walls)) > MOST_UPRIGHT
    }
    if not shares:
        return []
    names, low, high = list(shares), *(f"{100.0 * end(shares.values()):.0f}" for end in (min, max))
    portion = low if low == high else f"{low} to {high}"
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return [
        f"{', '.join(names[:NAMED])}{more}: metal, upright, over a reflecting sea: {portion} % of walls "
        "make right corners with the sea, which lifts echoes by some 10 dB at all aspects; add seaway = true to "
        "[environment], or list_deg and trim_deg"
    ]


def _walls(body: Body) -> tuple[Floats, Floats] | None:
    """Unit normals (F, 3) and areas (F,) [m^2] of the walls of a vessel above the sea; None where there are none."""
    if not body.is_vessel or body.mesh is None:
        return None
    mesh = mesh_sample(body.mesh)
    normal, area = normals_and_areas(mesh)
    dry = mesh.vertices[:, 2][mesh.faces].max(axis=1) + float(body.motion.position[0, 2]) > 0.0
    walls = dry & (np.abs(normal[:, 2]) < STEEPEST)
    return (normal[walls], area[walls]) if walls.any() else None


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
