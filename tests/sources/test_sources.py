"""The short modules of sources, each under its name."""

import numpy as np
import pytest

from radar_service.echo.echoes import SECOND_TIME, BeamWeightedEchoes
from radar_service.engine.pipeline import Contributions, Engine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.types import Profiles
from radar_service.records.fidelity import PRESETS
from radar_service.sources.numbers import BODY, source_names, source_numbers
from radar_service.sources.rows import resting_fields, source_rows, spread_echoes
from radar_service.stages.registry import numbers_of
from radar_service.world.body import MATERIALS, is_land
from tests.alone import Alone
from tests.scenes import point, scene

# numbers: numbers and names of sources.
BOX = {"shape": "box", "length_m": 20, "width_m": 30, "height_m": 8}


def test_land_is_one_source_for_each_material_and_every_other_body_one_of_its_own() -> None:
    bodies = [
        {**BOX, "name": "quay", "position_m": [0, 500, 0], "material": "concrete"},
        {**BOX, "name": "ferry", "position_m": [0, 300, 0], "material": "steel"},
        {**BOX, "name": "pier", "position_m": [0, 700, 0], "material": "concrete"},
        {**BOX, "name": "floe", "position_m": [0, 900, 0], "material": "ice", "speed_kn": 1},
        point("stone", 500, 0, material="rock"),
    ]
    made = scene(bodies)
    assert [is_land(body) for body in made.bodies] == [True, False, True, False, False]
    assert source_numbers(made).tolist() == [20, BODY + 1, 20, BODY + 3, BODY + 4, 4]
    assert source_names(made) == {
        0: "noise", 1: "sea", 2: "rain", 3: "interference", 4: "second time around",
        9: "range sidelobes and faint parts", 20: "land: concrete",
        257: "ferry", 259: "floe", 260: "stone",
    }  # fmt: skip


def test_numbers_of_land_stay_below_those_of_bodies() -> None:
    assert 16 + len(MATERIALS) <= BODY


def test_answers_of_beacons_are_sources_of_their_own() -> None:
    """Scenes without beacons have no such names."""
    made = scene([point("tower", 0, 500, racon={"letter": "K"}), point("raft", 500, 0, sart={})])
    assert (source_names(made)[5], source_names(made)[6]) == ("racon", "sart")
    assert source_names(scene([point("raft", 500, 0, sart={})])).keys() == {0, 1, 2, 3, 4, 6, 9, 256}


def test_faint_parts_are_named_where_bodies_have_any() -> None:
    quay = {**BOX, "name": "quay", "position_m": [0, 500, 0], "material": "concrete"}
    assert 9 not in source_names(scene([quay]))
    assert 9 not in source_names(scene([point("p", 0, 500)], radar={"labels_within_db": "none"}))


def test_false_echoes_are_sources_of_their_own_where_a_scene_has_any() -> None:
    """Behind the bodies, in the order of effects; without them nothing changes."""
    structure = [{"bearing_deg": 0, "distance_m": 3, "width_m": 0.2}]
    radar = {"structure": structure, "multiple_echoes": {"own_rcs_dbsm": 30}}
    made = scene([point("p", 0, 500)], radar=radar)
    assert source_numbers(made).tolist() == [256, 7, 8, 4] and source_numbers(made)[SECOND_TIME] == 4
    assert (numbers_of(made, "structures"), numbers_of(made, "multiple")) == (
        ({"indirect": 7}, {"indirect": 1}), ({"multiple": 8}, {"multiple": 2})
    )  # fmt: skip
    assert (source_names(made)[7], source_names(made)[8]) == ("indirect", "multiple")
    only = scene([point("p", 0, 500)], radar={"multiple_echoes": {"own_rcs_dbsm": 30}})
    assert source_numbers(only).tolist() == [256, 8, 4] and 7 not in source_names(only)
    assert source_numbers(scene([point("p", 0, 500)])).tolist() == [256, 4]


# rows: the fields of sources at rest, each by itself.
RADAR = {"range_max_m": 1200, "azimuths": 64, "beamwidth_deg": 8, "pulse_s": 1e-6}
BODIES = [point("a", 100, 200), point("b", 10, 5, 3), point("c", -600, 900, rcs_dbsm=30)]


@pytest.mark.parametrize("eclipsing", [False, True])
def test_each_field_is_that_of_the_body_alone(eclipsing: bool) -> None:
    """To single precision of the strongest sample; b is so near that its kernel wraps."""
    made = scene(BODIES, radar=RADAR | {"eclipsing": eclipsing})
    prepared = prepare(made, PRESETS["balanced"], 0)
    fields = dict(resting_fields(prepared, source_numbers(made), 0.0))
    assert list(fields) == [256, 257, 258]
    total = np.zeros((64, made.radar.bins), dtype=np.complex64)
    separate = Alone(made)
    for k, (rows, field) in enumerate(fields.values()):
        alone = separate.bodies([k], 0)
        whole = np.zeros_like(alone)
        whole[rows] = field
        np.testing.assert_allclose(whole, alone, atol=2e-7 * np.abs(alone).max())
        total += whole
    together = np.concatenate([field for _, field, _ in Engine(prepared).tiles(0)])
    np.testing.assert_allclose(total, together, atol=1e-6 * np.abs(together).max())


def test_rows_below_the_floor_are_left_out() -> None:
    made = scene(BODIES[:1], radar=RADAR)
    prepared = prepare(made, PRESETS["balanced"], 0)
    power = np.abs(Alone(made).bodies([0], 0)).max(axis=1) ** 2
    floor = float(power.max()) * 1e-3
    ((_, kept),) = resting_fields(prepared, source_numbers(made), floor)
    assert kept.rows.tolist() == np.flatnonzero(power > floor).tolist() and 1 < len(kept.rows) < 20
    added = np.zeros((8, made.radar.bins), dtype=np.complex64)
    kept.add_to(added, int(kept.rows[1]))
    np.testing.assert_array_equal(added[0], kept.field[1])
    assert not added[len(kept.rows) - 1 :].any()


# rows: rows of each source against all echoes on one grid.
NUMBERS = np.array([256, 257, 20, 259, 260, 4])


def echoes(seed: int, azimuths: int, bodies: list[int], ranges: list[float]) -> BeamWeightedEchoes:
    rng = np.random.default_rng(seed)
    shape = len(bodies), azimuths
    amplitude = (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype(np.complex64)
    migration = rng.uniform(-1, 1, shape).astype(np.float32)
    return BeamWeightedEchoes(np.array(ranges), migration, amplitude, np.array(bodies))


def recorded(prepared: Prepared) -> tuple[Contributions, dict[int, Profiles]]:
    """A tile of five azimuths, the last one blind, and the rows of each source by itself.

    Bodies 0 and SECOND_TIME are wide and overlap, 3 and 4 are alone, 1 stands near range 0, and 2 is asked for as a whole.
    """
    blocks = [
        (0, 3, echoes(1, 3, [0, 3, 0, 1, SECOND_TIME, 2], [300.0, 600.0, 420.0, 3.0, 400.0, 700.0])),
        (3, 5, echoes(2, 2, [4, 3, 0, SECOND_TIME], [1000.0, 610.0, 310.0, 480.0])),
    ]
    size, sources = prepared.compression.size, {}
    for first, stop, each in blocks:
        for body in np.unique(each.body).tolist():
            rows = sources.setdefault(int(NUMBERS[body]), np.zeros((5, size), dtype=np.complex64))
            spread_echoes(prepared, rows[first:stop], each.chosen(np.flatnonzero(each.body == body)))
    for rows in sources.values():
        rows[4] = 0.0
    transmitting = np.array([True, True, True, True, False])
    return Contributions(transmitting, blocks, sum(sources.values()), None), sources


@pytest.mark.parametrize("eclipsing", [False, True], ids=["", "eclipsing"])
def test_each_source_has_the_rows_of_its_echoes_alone(eclipsing: bool) -> None:
    prepared = prepare(scene(radar=RADAR | {"eclipsing": eclipsing}), PRESETS["balanced"], 0)
    record, expected = recorded(prepared)
    rows = source_rows(prepared, record, NUMBERS, full_rows=[20])
    got = dict(rows.full_rows)
    for windows in rows.windows:
        assert (np.diff(windows.at) > 0).all()
        for number, begin, at, width in zip(windows.number, windows.begin, windows.at, windows.width, strict=True):
            assert number not in got and width < 110
            got[int(number)] = np.zeros_like(expected[20])
            got[int(number)][:, begin : begin + width] = windows.grid[:, at : at + width]
    assert set(got) == set(expected) == set(NUMBERS.tolist())
    for number in got:
        np.testing.assert_allclose(got[number], expected[number], atol=3e-3, err_msg=str(number))  # the kernel's tables
    assert set(rows.full_rows) == {20, 257}
    assert [set(windows.number.tolist()) for windows in rows.windows] == [{259, 260}, {4, 256}]
    assert rows.windows[0].grid is record.rows
    assert set(source_rows(prepared, record, NUMBERS, NUMBERS.tolist()).full_rows) == set(expected)


def test_columns_that_wrap_around_the_row_are_nobodys_alone() -> None:
    prepared = prepare(scene(radar=RADAR), PRESETS["balanced"], 0)
    size, step = prepared.compression.size, prepared.scene.radar.range_step
    first, last = echoes(1, 1, [0], [1.0]), echoes(2, 1, [3], [(size - 4.5) * step])
    for pair, alone in (([first, last], set()), ([last], {259})):
        rows = np.zeros((1, size), dtype=np.complex64)
        for each in pair:
            spread_echoes(prepared, rows, each)
        record = Contributions(np.ones(1, dtype=bool), [(0, 1, each) for each in pair], rows, None)
        made = source_rows(prepared, record, NUMBERS)
        assert set(made.windows[0].number.tolist()) == alone


def test_no_echoes_have_no_rows() -> None:
    prepared = prepare(scene(radar=RADAR), PRESETS["balanced"], 0)
    rows = source_rows(prepared, Contributions(), NUMBERS)
    assert not rows.full_rows and not rows.windows
