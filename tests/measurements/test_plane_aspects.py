"""Processor time of an aspect by planar pieces, over the sea by four paths, and what it is of an aspect of today."""

import statistics
import time
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.scattering.physical_optics.patches import outward_side
from radar_service.scattering.physical_optics.path_fields import Wave
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
from radar_service.scattering.physical_optics.plane_echoes import PlaneOptics
from radar_service.world.hull_types import hull_mesh
from tests.scattering.physical_optics.meshes import write_obj
from tests.scattering.physical_optics.test_model import build, instant
from tests.scattering.physical_optics.test_plane_echoes import legs

HULLS = {
    "cargo": (150.0, 26.0, 20.0), "ferry": (100.0, 17.7, 14.1), "fishing": (30.0, 6.0, 6.3), "pilot": (12.0, 3.0, 4.3),
    "yacht": (15.0, 3.5, 4.7),
}  # fmt: skip


@pytest.mark.bench
@pytest.mark.parametrize("kind", HULLS)
def test_an_aspect_takes_less_than_half_of_todays(kind: str, tmp_path: Path) -> None:
    mesh = hull_mesh(kind, 1, *HULLS[kind])
    write_obj(tmp_path / "hull.obj", mesh.vertices[mesh.faces])
    body = PlaneOptics.of(PlanarPieces.of(mesh, outward_side(mesh)), Wave(0.0319, "h"), 3, 7.5)
    new: list[float] = []
    today: list[float] = []
    for azimuth in np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 6):
        antenna = 1500.0 * np.array([np.sin(azimuth), np.cos(azimuth), 0.01])
        ways = legs(antenna, 0.0)
        position = [-float(antenna[0]), -float(antenna[1]), 0.0]
        table = {"name": "hull", "mesh": "hull.obj", "scattering": "optics", "position_m": position}
        made = rs.load_scene(
            {"radar": {"range_max_m": 5000, "height_m": 15}, "environment": {"earth": "flat"}, "body": [table]},
            folder=tmp_path,
        )
        optics, at, when = build(made), made.antenna(0.0)[0], instant(made)
        for result, call in ((new, lambda: body.echoes(ways, 0.0, 2.0)), (today, lambda: optics.body_echoes(0, at, when))):  # noqa: B023
            call()
            begin = time.process_time()
            call()
            result.append(time.process_time() - begin)
    ours, theirs = 1e3 * statistics.median(new), 1e3 * statistics.median(today)
    print(f"{kind}: {ours:.1f} ms by planar pieces, {theirs:.1f} ms by facets and tubes")
    assert ours < 0.5 * theirs
