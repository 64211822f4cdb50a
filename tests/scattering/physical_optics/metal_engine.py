"""The engine's answer to the draws of `tests.reference.metal_draws`: amplitudes at an instant, and spokes."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.plan.culling import cull
from radar_service.records.fidelity import fidelity_from_name
from radar_service.simulation.engine_set_up import chosen_fidelity
from tests.reference.metal_draws import BANDWIDTH, CELL, GAIN, KNOT, PERIOD, POWER, Draw
from tests.reference.metal_on_water import Screen

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

COARSE = {"azimuths": 8, "beamwidth_deg": 60.0, "bandwidth_hz": 50e6}  # where only echoes at rest are looked at
LOUD_DBSM = 60.0  # of moving points, far above sea clutter


def write_mesh(path: Path, polygons: list[Floats]) -> None:
    """OBJ text of convex polygons to a nanometre, cut into triangles about their first corners."""
    lines, count = [], 0
    for corners in polygons:
        lines += [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in corners]
        lines += [f"f {count + 1} {count + k + 1} {count + k + 2}" for k in range(1, len(corners) - 1)]
        count += len(corners)
    path.write_text("\n".join(lines))


def write_track(path: Path, draw: Draw) -> None:
    """The motion of a draw from the start to the end of the scan that is compared."""
    lines = ["time_s,east_m,north_m,up_m,heading_deg"]
    for time in (0.0, (draw.scan + 1) * PERIOD + 1.0):
        heading = np.rad2deg(draw.heading + draw.turn * (time - draw.time)) % 360.0
        lines.append(f"{time},{','.join(f'{x:.9f}' for x in draw.position(time))},{heading:.9f}")
    path.write_text("\n".join(lines) + "\n")


def wall_table(folder: Path, screen: Screen) -> dict[str, Any]:
    """A wall that is as good as silent."""
    a, b, c = np.zeros(3), screen.one, screen.other
    write_mesh(folder / "wall.obj", [np.array([a, b, b + c, c])])
    corner = [float(x) for x in screen.corner]
    return {"name": "wall", "mesh": "wall.obj", "position_m": corner, "rcs_dbsm": -100.0}


def body_table(folder: Path, draw: Draw, moving: bool) -> dict[str, Any]:
    """The body of a draw."""
    made: dict[str, Any] = {"name": "metal"}
    if draw.faces:
        write_mesh(folder / "metal.obj", [face.corners for face in draw.faces])
        made |= {"mesh": "metal.obj", "scattering": "optics"}
    else:
        made |= {"shape": "point", "rcs_dbsm": LOUD_DBSM}
    if moving and (draw.turn or draw.faces):
        write_track(folder / "metal.csv", draw)
        return made | {"track": "metal.csv"}
    start = draw.position(0.0 if moving else draw.time)
    made |= {"position_m": [float(x) for x in start], "heading_deg": float(np.rad2deg(draw.heading) % 360.0)}
    if moving:
        speed = float(np.hypot(*draw.velocity[:2]))
        made |= {"speed_kn": speed / KNOT, "course_deg": float(np.rad2deg(np.arctan2(*draw.velocity[:2])) % 360.0)}
    return made


def scene_of(draw: Draw, folder: Path, moving: bool, **radar: Any) -> rs.Scene:
    """The scene of a draw; moving: as it moves, else as it stands when the beam crosses it; radar: settings."""
    setting = draw.setting
    settings = {
        "height_m": setting.antenna_height,
        "polarization": setting.polarization,
        "beamwidth_el_deg": float(np.rad2deg(setting.beamwidth_el or np.pi)),
        "range_max_m": draw.distance * 1.05 + 6.0 * CELL,
        "bandwidth_hz": BANDWIDTH,
        "power_w": POWER,
        "gain_dbi": 10 * np.log10(GAIN),
        **radar,
    }
    environment = {
        "multipath": setting.sea,
        "sea_state": setting.sea_state if setting.sea else 0,
        "sea_texture_shape": 1.0,  # of clutter, which is not compared: one shape for all ranges is made quickly
        "earth": "flat" if np.isinf(setting.earth_radius) else "4/3",
    }
    bodies = [body_table(folder, draw, moving), *(wall_table(folder, screen) for screen in draw.screens)]
    return rs.load_scene({"radar": settings, "environment": environment, "body": bodies}, folder=folder)


def one_square_metre(draw: Draw) -> float:
    """Amplitude [sqrt(W)] of 1 m^2 in free space at the body's slant range, on boresight (Skolnik 2001, eq. 1.7)."""
    return float(np.sqrt(POWER * GAIN**2 * draw.setting.wavelength**2 / (4 * np.pi) ** 3)) / draw.slant**2


def amplitude(draw: Draw, folder: Path, fidelity: str) -> float:
    """The engine's |a| [m]: the sum of the echoes of the scene at rest over the echo of 1 m^2 in free space."""
    prepared = prepare(scene_of(draw, folder, False, **COARSE), fidelity_from_name(fidelity), 0)
    return float(abs(prepared.resting.echoes.amplitude.sum())) / one_square_metre(draw)


def spokes(made: rs.Scene, fidelity: str, scan: int, wanted: NDArray[np.int64]) -> Complexes:
    """Fields (K, N) of spokes `wanted` (K,) of a scan, computed as `rs.Simulator` does, without the rest of the turn."""
    settings = chosen_fidelity(made, fidelity)
    culled = cull(made, settings)
    prepared = prepare(made, settings, 0, culled, [key for key in culled if not culled[key].occludes])
    starts = {int(start) for start in wanted // prepared.tile * prepared.tile}
    tiles = {start: profiles(prepared, tile_azimuths(prepared, scan, start)) for start in starts}
    return np.array([tiles[int(k) // prepared.tile * prepared.tile][int(k) % prepared.tile] for k in wanted])


def spokes_across(draw: Draw, azimuths: int = 720, beamwidths: float = 0.5) -> NDArray[np.int64]:
    """Indices of the spokes within so many beamwidths (of 3.9 degrees) of the body in its scan."""
    boresight = 2.0 * np.pi * np.arange(azimuths) / azimuths
    off = np.angle(np.exp(1j * (boresight - draw.bearing)))
    return np.flatnonzero(np.abs(off) <= np.deg2rad(3.9) * beamwidths)


def at_rest(draw: Draw) -> Draw:
    """The same body, standing as it does when the beam crosses it, in scan 0."""
    return replace(draw, velocity=np.zeros(3), turn=0.0)
