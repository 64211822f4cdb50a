"""Land under way for tests: a coast of a few thousand points, and single points in place of it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.echoes import AzimuthTimes
from radar_service.engine import land_rows
from radar_service.engine.pipeline import profiles
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.types import Floats, Profiles
from radar_service.records.fidelity import PRESETS, Fidelity
from radar_service.scattering.resting_points import MapCells
from radar_service.trace import land_mask

RADAR: dict[str, Any] = {"azimuths": 1024, "beamwidth_deg": 2.0, "range_max_m": 1500, "rpm": 24, "pulse_s": 1e-6}
FINE: dict[str, Any] = {"azimuths": 2048, "beamwidth_deg": 1.2, "range_max_m": 5600, "rpm": 24, "pulse_s": 1e-6}
SIZE = {"shape": "box", "length_m": 9, "width_m": 9, "height_m": 2}
SLAB: dict[str, Any] = {"name": "slab", **SIZE, "position_m": [0, 3000, 0], "material": "land"}
OWN_SHIP: dict[str, Any] = {"course_deg": 200.0, "speed_kn": 8.0}
FEW = replace(PRESETS["balanced"], scatterers_per_cell=1.0)  # points, so that tests are quick


def coast(folder: Path, own_ship: dict[str, Any] = OWN_SHIP, bay: float = 100.0, **more: Any) -> rs.Scene:
    """Islands of 1 to 5 m about a bay [m], with multipath over a calm sea."""
    rng = np.random.default_rng(3)
    east, north = np.meshgrid(np.linspace(-1400, 1400, 57), np.linspace(1400, -1400, 57))
    heights = np.where(rng.random(east.shape) < 0.4, rng.uniform(1, 5, east.shape), -1.0)
    heights[np.hypot(east, north) < bay] = -1.0
    np.save(folder / "coast.npy", heights.astype(np.float32))
    land = {"name": "coast", "heightmap": "coast.npy", "extent_m": [2800.0, 2800.0], "material": "land"}
    bodies = [land, *more.pop("bodies", [])]
    radar = RADAR | more.pop("radar", {})
    environment = {"multipath": True, **more.pop("environment", {})}
    table = {"name": "coast", "radar": radar, "own_ship": own_ship, "environment": environment, "body": bodies, **more}
    return rs.load_scene(table, folder=folder)


@contextmanager
def always_on_grid() -> Iterator[None]:
    """Puts land on the grid, however little it is. Its mask has few cells, so that it is soon made."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(land_rows, "ROW_SECONDS", 0.0)
        patch.setattr(land_mask, "CELLS", 2**14)
        yield


@always_on_grid()
def on_grid(made: rs.Scene, fidelity: Fidelity = FEW) -> Prepared:
    """A scene prepared with its land on the grid."""
    return prepare(made, fidelity, 1)


def with_points(prepared: Prepared, position: Floats, antenna: Floats) -> Prepared:
    """The same scene with points of 1 m^2 that face an antenna (3,), at positions (E, 3) on the map [m], in place of its land."""
    assert prepared.land is not None
    passages, count = prepared.land.passages, len(position)
    cells, order = MapCells.of(position)
    some = np.zeros(count, dtype=np.int64)
    changes: dict[str, Any] = {name: getattr(passages.points, name)[some] for name in ("triangle", "body", "lift", "span")}
    toward = (antenna - position[order]) / np.linalg.norm(antenna - position[order], axis=1)[:, None]
    changes |= {"lift": 0.0 * changes["lift"], "span": 0.0 * changes["span"], "triangle": changes["triangle"] * 0 - 1}
    changes |= {"normal": toward.astype(np.float32), "strength": np.ones(count, dtype=np.complex64)}
    passages.points = replace(
        passages.points, cells=cells, position=position[order], one_sided=np.zeros(count, dtype=np.bool_), **changes
    )
    return prepared


def azimuths_of(made: rs.Scene, first: int, count: int = 32) -> AzimuthTimes:
    """Consecutive azimuths by number."""
    number = np.arange(first, first + count)
    return AzimuthTimes(number, *made.radar.schedule(number))


def fields(prepared: Prepared, first: int, tiles: int, apart: int = 32) -> Profiles:
    """Compressed profiles (tiles 32, bins) of some tiles of 32 azimuths, without noise."""
    parts = []
    for start in range(first, first + tiles * apart, apart):
        parts.append(profiles(prepared, azimuths_of(prepared.scene, start)))
    return np.concatenate(parts)
