"""Declared cross-sections: shared by what is visible, whole in a sector, and of small meshes."""

from typing import Any

import numpy as np
import pytest

from radar_service.scattering.declared_cells import cell_spacing
from radar_service.scattering.declared_scattering import DeclaredScattering
from radar_service.scattering.fixed_scatterers import DiffuseScattering, FixedScatterers
from radar_service.scattering.model import BearingWedge
from radar_service.world.poses import map_from_bodies
from tests.scattering.test_fixed_scatterers import FLAT, build, instant
from tests.scenes import scene


def test_visible_scatterers_share_a_declared_cross_section() -> None:
    """A hull half behind a wall still has all of its 20 dBsm, on the half that is seen; the key of the wall lies between. Energy
    relative to the middle's range: within what 30 m do to R^-4 at 600 m, 20 %, and neighbours overlap by 4 %."""
    hull = {"name": "h", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "position_m": [0, 600, 0],
            "heading_deg": 90, "rcs_dbsm": 20}  # fmt: skip
    wall = {"name": "w", "shape": "plate", "width_m": 30, "height_m": 60, "position_m": [15, 300, 20], "rcs_dbsm": 0,
            "heading_deg": 180}  # fmt: skip
    made = scene([hull, wall], environment=FLAT)
    model, antenna = build(DeclaredScattering, made), made.antenna(0.0)[0]
    echoes = model.echoes(antenna, instant(made))
    shares = np.bincount(echoes.body, np.abs(echoes.amplitude) ** 2, minlength=2)
    assert shares == pytest.approx([100.0, 1.0], rel=0.24)
    position = map_from_bodies(
        echoes.position, echoes.body, *(np.array([[0, 600, 0], [15, 300, 20.0]]), np.deg2rad([90, 180]))
    )
    assert position[echoes.body == 0, 0].max() < 0.0


def test_a_small_declared_mesh_stands_for_its_height_above_the_sea() -> None:
    """A buoy within a cell is one echo in the middle of what is above the water, as high as that."""
    buoy = {"name": "b", "shape": "cylinder", "radius_m": 0.5, "height_m": 4, "position_m": [0, 500, -1], "rcs_dbsm": 0}
    made = scene([buoy], environment=FLAT)
    (echo,) = [build(DeclaredScattering, made).echoes(made.antenna(0.0)[0], instant(made))]
    assert len(echo) == 1 and echo.height_span[0] == pytest.approx(3.0) and echo.position[0, 2] == pytest.approx(2.5)


@pytest.mark.parametrize(
    "model, more, seen", [(DiffuseScattering, {"material": "wood"}, 0), (DeclaredScattering, {"rcs_dbsm": 1}, 1)]
)
def test_a_declared_body_counts_where_its_echoes_may_lie_beside_its_scatterers(
    model: type[FixedScatterers], more: dict[str, Any], seen: int
) -> None:
    """A quay 0.6747 rad to each side, and sectors that begin half of a spacing of cells beside it, and two spacings."""
    quay = {"name": "q", "shape": "box", "length_m": 10, "width_m": 800, "height_m": 20, "position_m": [0, 500, 0]}
    made, antenna = scene([{**quay, **more}], environment=FLAT), np.array([0.0, 0.0, 15.0])
    source, begin, spacing = build(model, made), np.arctan2(400, 495), cell_spacing(made.radar).azimuth
    for off, count in ((0.5, seen), (2.0, 0)):
        sector = BearingWedge(antenna, begin + off * spacing + 0.3, 0.3, 1.0)
        assert bool(len(source.echoes(antenna, instant(made, wedge=sector)))) == count
