"""Small convex bodies at many instants at once. Their kernel is compared with numpy in `tests.kernels.test_convex_fields`."""

from typing import Any

import numpy as np
import pytest

from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.types import Complexes, Floats
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes, Instant
from radar_service.scattering.physical_optics import model
from radar_service.scattering.physical_optics.convex_bodies import Centres
from tests.scenes import scene

HULL = {"shape": "box", "scattering": "optics", "length_m": 9.0, "width_m": 4.0, "height_m": 3.0}
RADAR = {"range_max_m": 3000, "azimuths": 2048, "height_m": 15}
TIMES = 2.5 + np.arange(-6, 7, 2) * 2.5 / 2048


def hull(north: float, east: float = 0.0, **more: Any) -> dict[str, Any]:
    return {**HULL, "position_m": [east, north, 0.0], "speed_kn": 8.0, "course_deg": 70.0, **more}


def prepared_for(*bodies: dict[str, Any], environment: dict[str, Any] | None = None, **radar: Any) -> Prepared:
    named = [{"name": f"hull {number}", **body} for number, body in enumerate(bodies)]
    return prepare(scene(named, radar=RADAR | radar, environment=environment or {"multipath": True}), PRESETS["balanced"], 1)


def evaluated(ready: Prepared, times: Floats = TIMES, max_range: float = 3000.0) -> tuple[BodyEchoes, Complexes] | None:
    """What the model has of the first body at once."""
    optics, _ = optics_and_sight(ready)
    instant = Instant(float(times[0]), ready.moving.visibility.line_of_sight, max_range)
    return optics.passage_echoes(0, ready.scene.antenna(times), times, instant)


def optics_and_sight(ready: Prepared) -> tuple[model.PhysicalOptics, Any]:
    (optics,) = ready.moving.visibility.scatterers.aspect_models
    assert isinstance(optics, model.PhysicalOptics)
    return optics, ready.moving.visibility.line_of_sight


BEFORE = [hull(700.0, 1.0, height_m=2.5, course_deg=160.0), hull(640.0, -2.5, height_m=1.0, course_deg=250.0)]


def test_a_hull_that_hangs_over_the_sea_has_its_own_rays() -> None:
    """The sea lights its bottom past what it hides of that itself, so each instant is computed as `body_echoes` has it."""
    afloat = hull(760.0) | {"position_m": [0.0, 760.0, 2.0]}
    ready = prepared_for(afloat, *BEFORE)
    result, (optics, sight) = evaluated(ready), optics_and_sight(ready)
    assert result is not None
    for number, time in enumerate(TIMES.tolist()):
        each = optics.body_echoes(0, ready.scene.antenna(time)[0], Instant(time, sight, 3000.0))
        np.testing.assert_allclose(np.linalg.norm(result[1][:, number]), np.linalg.norm(each.amplitude), rtol=1e-12)


OTHERS = {"concave": {"shape": "trihedral", "edge_m": 2.0}, "rolling": {**HULL, "roll_deg": 3.0, "roll_period_s": 6.0}}


@pytest.mark.parametrize("kind", OTHERS)
def test_bodies_that_roll_or_have_bounces_are_computed_node_by_node(kind: str) -> None:
    body = {"position_m": [0.0, 760.0, 0.0], "scattering": "optics", "speed_kn": 8.0, "course_deg": 70.0, **OTHERS[kind]}
    assert evaluated(prepared_for(body)) is None


def test_centres_of_parts_of_the_instants_stand_beside_each_other() -> None:
    first, second = (Centres(np.full((1, 3), value), np.array([0]), np.full((1, 2), value + 1j)) for value in (1.0, 2.0))
    both_parts = Centres.joined([first, second], [np.array([0, 2]), np.array([1, 3])])
    np.testing.assert_array_equal(both_parts.amplitude, [[1 + 1j, 0, 1 + 1j, 0], [0, 2 + 1j, 0, 2 + 1j]])


def test_centres_of_echoes_are_merged_where_place_and_path_agree() -> None:
    def echoes(places: list[float], path: list[int], amplitude: list[complex]) -> BodyEchoes:
        count = len(places)
        position = np.column_stack([places, np.zeros((count, 2))])
        return BodyEchoes(position, np.array(amplitude), np.zeros(count, dtype=np.int64), np.array(path), np.zeros(count))

    merged = Centres.of([echoes([1.0, 1.0], [0, 1], [1, 2]), echoes([3.0, 1.0], [0, 0], [4, 8j])])
    assert merged.position[:, 0].tolist() == [1.0, 1.0, 3.0] and merged.path.tolist() == [0, 1, 0]
    np.testing.assert_array_equal(merged.amplitude, [[1, 8j], [2, 0], [0, 4]])
