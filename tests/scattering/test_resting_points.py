"""Points of land by cells of the map, against all points one by one."""

import numpy as np
import pytest

from radar_service.numerics.ragged import spans
from radar_service.scattering.fixed_scatterers import DiffuseScattering
from radar_service.scattering.model import BearingWedge
from radar_service.scattering.resting_points import MapCells
from radar_service.scattering.scatterer_set import build_scatterers
from tests.scattering.test_fixed_scatterers import context
from tests.scenes import scene

SLAB = {"shape": "box", "length_m": 600, "width_m": 500, "height_m": 3, "material": "land", "heading_deg": 30}


@pytest.mark.parametrize("antenna", [(0.0, 0.0), (-3000.0, 450.0), (700.0, 5000.0)])
def test_cells_miss_no_point_of_a_wedge(antenna: tuple[float, float]) -> None:
    """And of the points that they hold a tenth at most lies farther from the wedge than the diagonal of a cell, 181 m."""
    rng = np.random.default_rng(7)
    position = np.column_stack([rng.uniform(-4000, 4000, (20_000, 2)), np.zeros(20_000)])
    cells, order = MapCells.of(position)
    assert np.array_equal(np.sort(order), np.arange(20_000))
    position = position[order]
    for middle in (0.1, 2.0, 4.5):
        wedge = BearingWedge(np.array([*antenna, 15.0]), middle, 0.1, 300.0)
        chosen = spans(*cells.within(wedge))[1]
        assert len(np.unique(chosen)) == len(chosen)
        assert set(np.flatnonzero(wedge.contains(position)).tolist()) <= set(chosen.tolist())
        assert wedge.contains(position[chosen], 182.0).all()


def test_points_at_rest_are_those_of_the_model() -> None:
    """Sum of the strengths squared: gamma times the area of the box, 2 x (600 x 500 + 3 x 1100) m^2 or what lies over the sea."""
    made = scene([{**SLAB, "name": "a", "position_m": [900, 0, 0]}, {**SLAB, "name": "b", "position_m": [-900, 0, 0]}])
    model = DiffuseScattering.build(made.bodies, np.arange(2), context(made))
    points = model.resting_points()
    assert len(points) == model.scatterers.sum() and np.bincount(points.body).tolist() == model.scatterers.tolist()
    area = 2 * (600 * 500 + 3 * 1100)
    energy = np.sum(np.abs(points.strength) ** 2, where=points.body == 1)
    assert energy == pytest.approx(made.bodies[1].material.gamma * area, rel=0.01)  # each triangle to within one point
    away = points.position - np.where(points.body == 0, 900.0, -900.0)[:, None] * [1.0, 0.0, 0.0]
    assert np.linalg.norm(away, axis=1).max() < 391.0  # half the diagonal of the box


def test_joined_sets_have_the_bodies_of_both_in_order() -> None:
    made = scene([{**SLAB, "name": f"b{k}", "position_m": [900 * k, 500, 0]} for k in range(3)])
    outer, inner = (build_scatterers([made.bodies[k] for k in keys], keys, context(made)) for keys in ([0, 2], [1]))
    both, one = inner.joined(outer), build_scatterers(made.bodies, [0, 1, 2], context(made))
    assert [body.name for body in both.bodies] == ["b0", "b1", "b2"] and both.key.tolist() == [0, 1, 2]
    assert both.scatterers.tolist() == one.scatterers.tolist()
