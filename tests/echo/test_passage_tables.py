"""Tables of a passage: the rows of spokes are those of nodes that are spread one by one."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.passage_tables import PassageTable, joined
from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes
from tests.scenes import scene

HULL = {"shape": "box", "scattering": "optics", "length_m": 9.0, "width_m": 4.0, "height_m": 3.0, "speed_kn": 9.0}
BODIES = [
    {"name": "far", **HULL, "position_m": [0.0, 500.0, 0.0], "course_deg": 70.0},
    {"name": "near", **HULL, "height_m": 1.5, "position_m": [20.4, 438.0, 0.0], "course_deg": 250.0},
    {"name": "aside", **HULL, "position_m": [9.0, 150.0, 0.0], "course_deg": 90.0, "speed_kn": 30.0},
]
SINGLE = 3e-6  # of the peak: rounding of some hundred phases and sums in single precision


def test_a_passage_has_the_fields_of_its_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same nodes with a table of them all, and as echoes of their own with the weights of each node."""
    made = scene(BODIES, radar={"azimuths": 1024, "range_max_m": 700, "beamwidth_deg": 3}, environment={"multipath": True})
    tables = prepare(made, PRESETS["balanced"], 1)
    assert all(len(tables.moving.passages.nodes(n, tables.moving.passages.crossing(n, 1.0))) > 3 for n in (0, 2))
    crossing = tables.moving.passages.crossing(0, 1.0)
    assert (np.diff(tables.moving.passages.nodes(0, crossing)) == 1).all()  # every spoke that the shadow asks for
    azimuths = [tile_azimuths(tables, 1, number * tables.tile) for number in (0, 1)]
    expected = np.concatenate([profiles(tables, each) for each in azimuths])

    def one_by_one(table: PassageTable, weights: np.ndarray) -> ObservedEchoes:
        nodes = [replace(table.echoes, amplitude=column.astype(np.complex128)) for column in table.amplitude.T]
        position = np.tile(table.position, (len(nodes), 1))
        return ObservedEchoes(BodyEchoes.joined(nodes), position, np.repeat(weights, len(table.position), axis=0))

    monkeypatch.setattr(PassageTable, "observed", one_by_one)
    nodes = prepare(made, PRESETS["balanced"], 1)
    each = np.concatenate([profiles(nodes, block) for block in azimuths])
    peak = np.abs(expected).max()
    assert 0.0 < np.abs(each - expected).max() < SINGLE * peak  # not the same sums


def test_a_table_is_a_sum_over_nodes_and_only_of_those_that_count() -> None:
    draw = np.random.default_rng(2)
    echoes = BodyEchoes.of_points(draw.normal(size=(3, 3)), np.zeros(3, dtype=np.complex128), np.zeros(3, dtype=np.int64))
    amplitude = draw.normal(size=(3, 4)) + 1j * draw.normal(size=(3, 4))
    amplitude[:, 1] = np.inf
    table = PassageTable.of(echoes, amplitude, 7, np.zeros((3, 3)))
    weights = np.array([[0.125, 0.0], [0.0, 0.0], [0.5, 1.0], [0.375, 0.0]], dtype=np.float32)
    observed = table.observed(weights)
    expected = np.column_stack([amplitude[:, [0, 2, 3]] @ [0.125, 0.5, 0.375], amplitude[:, 2]])
    np.testing.assert_allclose(observed.fade, expected, rtol=1e-6)  # single precision
    assert observed.echoes.body.tolist() == [7, 7, 7] and (observed.echoes.amplitude == 1.0).all()


def test_nothing_is_joined_of_nothing() -> None:
    one = ObservedEchoes(BodyEchoes.joined([]), np.zeros((0, 3)), np.zeros((0, 2), dtype=np.float32))
    assert joined([]) == [] and joined([one])[0] is one
    assert joined([one, one])[0].fade.shape == (0, 2)  # type: ignore[union-attr]
