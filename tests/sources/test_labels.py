"""Labels against separately run sources: each source of the scene by itself, in an engine in which all others are silent."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from radar_service.sources.labels import LabellingEngine, unlabelled
from radar_service.sources.numbers import BODY, FAINT, NOISE, SECOND_TIME_AROUND, source_numbers
from radar_service.stages.clutter.clutter import ClutterRows
from radar_service.stages.clutter.effect import RAIN, SEA
from tests.alone import Alone, agreement, crowded, crowded_alone
from tests.scenes import everything, scene

Labels = NDArray[np.uint32]
SHARE = 0.999  # of the cells where the strongest source leads by 3 dB


def labels_of(made: rs.Scene, scan: int, seed: int = 0) -> Labels:
    engine = LabellingEngine(prepare(made, PRESETS["balanced"], seed))
    return np.concatenate([labels for _, _, _, labels in engine.labelled_tiles(scan)])


@pytest.mark.parametrize(("moves", "scan"), [(False, 0), (True, 30)])
def test_labels_are_the_strongest_of_separately_run_sources(moves: bool, scan: int) -> None:
    made = crowded(moves)
    labels, powers = labels_of(made, scan), crowded_alone(moves).powers(scan)
    assert {NOISE, SEA, RAIN, 3, SECOND_TIME_AROUND} <= set(np.unique(labels).tolist())
    agreed, leading = agreement(labels, powers)
    assert leading > 0.5 and agreed >= SHARE
    boresight, time_of = made.radar.schedule(scan * made.radar.azimuths + np.arange(made.radar.azimuths))
    assert set(np.unique(labels[made.blind(time_of, boresight)]).tolist()) <= {NOISE, 3}
    if not moves:
        assert set(source_numbers(made)[[0, 1, 2, 4, 5]].tolist()) <= set(np.unique(labels).tolist())


@pytest.mark.parametrize("moves", [False, True], ids=["at rest", "own ship under way"])
def test_without_noise_every_cell_with_any_echo_has_its_source(moves: bool) -> None:
    calm = {"noise": False, "sea_state": 0, "rain_mm_h": 0.0}
    labels = labels_of(crowded(moves, **calm), 2)
    agreed, _ = agreement(labels, crowded_alone(moves, **calm).powers(2))
    assert agreed >= SHARE


@pytest.mark.parametrize("within_db", [13.0, 50.0, "none"])
@pytest.mark.parametrize("modulation", ["lfm", "none"])
def test_a_body_is_labelled_down_to_a_level_below_its_own_peak(within_db: float | str, modulation: str) -> None:
    """Two ships, under way and at rest, whose ranges overlap; the witness has the power of each by itself."""
    long = {"shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "material": "wood", "scattering": "optics"}
    bodies = [{**long, "name": "moored", "position_m": [0, 300, 0], "heading_deg": 80},
              {**long, "name": "under way", "position_m": [-20, 380, 0], "speed_kn": 9, "course_deg": 70}]  # fmt: skip
    radar = {"range_max_m": 800, "azimuths": 72, "beamwidth_deg": 8, "pulse_s": 1e-6, "modulation": modulation}
    made = scene(bodies, radar={**radar, "labels_within_db": within_db}, environment={"noise": True})
    labels, powers = labels_of(made, 1), Alone(made).powers(1)
    reach_db = np.inf if within_db == "none" else float(within_db)
    agreed, leading = agreement(labels, powers, reach_db)
    assert leading > 0.5 and agreed >= SHARE
    assert (FAINT in labels) == (within_db != "none")
    for body in (BODY, BODY + 1):
        alone = powers[body]
        lowest = alone.max(axis=1, keepdims=True) * 10.0 ** (-reach_db / 10.0)
        assert body in labels and (alone >= 0.999 * lowest)[labels == body].all()  # a float32 power to a part in 2**14


def test_labels_depend_on_no_tile_and_no_scan_before() -> None:
    """Tiles of 5 and 7 azimuths; bodies move, shadow, and one rests."""
    prepared = prepare(everything(), PRESETS["balanced"], 4)
    engines = [LabellingEngine(replace(prepared, tile=tile)) for tile in (5, 7)]
    list(engines[0].labelled_tiles(2))
    first, second = (np.concatenate([labels for *_, labels in engine.labelled_tiles(3)]) for engine in engines)
    assert FAINT in first
    np.testing.assert_array_equal(first == FAINT, second == FAINT)


def assert_strongest(made: rs.Scene, scan: int) -> None:
    agreed, leading = agreement(labels_of(made, scan), Alone(made).powers(scan))
    assert leading > 0.5 and agreed >= SHARE


def test_labels_hold_where_moving_metal_shadows_a_coast_in_rough_sea() -> None:
    assert_strongest(everything(), 3)


def test_a_ship_that_passes_takes_the_labels_of_the_coast_behind_it() -> None:
    """The coast rests, so its labels are kept, but for azimuths in the shadow: these have labels of noise or the ship."""
    coast = {"name": "coast", "shape": "box", "length_m": 20, "width_m": 500, "height_m": 8, "position_m": [0, 600, 0]}
    ship = {"name": "ship", "shape": "box", "length_m": 90, "width_m": 15, "height_m": 30, "position_m": [-20, 250, 0]}
    made = scene(
        [{**coast, "material": "concrete"}, {**ship, "material": "wood", "speed_kn": 10, "course_deg": 90, "heading_deg": 90}],
        radar={"range_max_m": 800, "azimuths": 120, "beamwidth_deg": 4, "pulse_s": 1e-6, "power_w": 1.0},
        environment={"noise": True},
    )  # fmt: skip
    alone = made.with_world(bodies=made.bodies[:1])
    shadowed, free = labels_of(made, 2), labels_of(alone, 2)
    land = int(source_numbers(made)[0])
    assert np.sum((free == land) & (shadowed == NOISE)) > 100
    assert_strongest(made, 2)


@pytest.mark.parametrize("radar", [{"eclipsing": True}, {"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 15e6}])
def test_labels_hold_for_other_pulses(radar: dict[str, Any]) -> None:
    settings = scene(radar={"range_max_m": 800, "azimuths": 72, "beamwidth_deg": 8, "pulse_s": 1e-6, **radar}).radar
    made = crowded(False)
    assert_strongest(replace(made.with_world(bodies=made.bodies[:5]), radar=settings), 1)


def test_the_order_of_bodies_changes_no_name() -> None:
    """Where two sources are equally strong rounding may decide, so a few cells of 28,872 may differ."""
    made = crowded(False)
    turned = made.with_world(bodies=made.bodies[::-1])
    first, second = labels_of(made, 1), labels_of(turned, 1)
    count = len(made.bodies)
    as_first = np.where(second >= BODY, BODY + (count - 1) - (second - BODY), second)
    assert np.mean(first == as_first) > SHARE


HIGHEST = 300  # 9 bits, which leave 14 for the power: a part in 16,384


def powers(*rows: list[float]) -> np.ndarray:
    return np.array(rows, dtype=np.float32)


def test_a_source_takes_the_cells_in_which_it_is_stronger() -> None:
    strongest = unlabelled(2, 4, 1.0, HIGHEST)
    strongest.offer(7, powers([2, 0, 0.9, 3], [0, 0, 0, 0]))
    strongest.offer(9, powers([4, 4]), np.array([0]), first=2)
    strongest.offer(300, powers([5], [0.5]), slice(0, 2), first=0)
    assert strongest.labels.tolist() == [[300, 0, 9, 9], [0, 0, 0, 0]] and strongest.labels.dtype == np.uint32
    strongest.offer(8, powers([5.01, 0, 4.01, 3.99], [1.001, 0.999, -0.0, -1.0]))
    assert strongest.labels.tolist() == [[8, 0, 8, 9], [8, 0, 0, 0]]


def test_a_difference_of_a_thousandth_of_a_decibel_decides_among_thousands_of_sources() -> None:
    rng = np.random.default_rng(0)
    power = (rng.exponential(size=(1, 1000)) * 10.0 ** rng.uniform(-30, 5, (1, 1000))).astype(np.float32)
    for first, second in ((4000, 256), (256, 4000)):
        strongest = unlabelled(1, 1000, 0.0, 4000)
        strongest.offer(first, power.copy())
        strongest.offer(second, power * np.float32(1.0015))  # 0.0065 dB: 12 bits of the number leave a part in 2048
        assert (strongest.labels == second).all()


@pytest.mark.parametrize(("number", "faint"), [(300, FAINT), (BODY, FAINT), (BODY - 1, BODY - 1), (SECOND_TIME_AROUND, 4)])
def test_only_bodies_have_faint_cells(number: int, faint: int) -> None:
    """Each row has a peak of its own; one that stays below the noise of 1 W has no cell at all."""
    strongest = unlabelled(3, 4, 1.0, HIGHEST, 1e-3)
    strongest.offer(number, powers([5000.0, 5.01, 4.99, 6.0], [8.0, 8.0, 0.004, 2.0], [0.9, 0.9, 0.9, 0.9]))
    assert strongest.labels.tolist() == [[number, number, faint, number], [number, number, NOISE, number], [NOISE] * 4]


def test_a_faint_part_that_is_the_strongest_source_stays_so() -> None:
    strongest = unlabelled(1, 2, 1.0, HIGHEST, 1e-3)
    strongest.offer(300, powers([1e4, 5.0]))
    strongest.offer(299, powers([4.0, 4.0]))
    assert strongest.labels.tolist() == [[300, FAINT]]


def test_without_noise_cells_without_power_have_no_source() -> None:
    strongest = unlabelled(1, 4, 0.0, HIGHEST)
    strongest.offer(300, powers([0.0, 1e-37, -0.0, 0.0]))
    assert strongest.labels.tolist() == [[0, 300, 0, 0]]


def test_a_part_is_a_copy_and_cleared_rows_have_noise_alone() -> None:
    strongest = unlabelled(4, 2, 1.0, HIGHEST)
    strongest.offer(5, powers([2.0, 0.0], [3.0, 4.0]), np.array([2, 3]))
    part = strongest.part(1, 2)
    assert part.labels.tolist() == [[0, 0], [5, 0]]
    part.offer(6, powers([9.0, 9.0]), np.array([1]))
    part.clear(np.array([1]))
    part.offer(7, powers([0.9, 1.1]), np.array([1]))
    assert part.labels.tolist() == [[0, 0], [0, 7]]
    assert strongest.labels.tolist() == [[0, 0], [0, 0], [5, 0], [5, 5]]


def test_clutter_is_divided_by_the_local_means_of_sea_and_rain() -> None:
    """Local means of rain 1, 4, 0 W and of the sea 3, 1, 2 W; the speckle has 2, 2 and 0 times these."""
    mean = powers([4, 5, 2])
    field = (np.sqrt(mean) * np.sqrt(powers([2, 2, 0]))).astype(np.complex64)
    clutter = ClutterRows(field, np.sqrt(mean), np.array([1, 4], dtype=np.float32))
    np.testing.assert_allclose(clutter.rain_share, [[0.25, 0.8, 0.0]], rtol=1e-6)
    strongest = unlabelled(1, 4, 1.0, HIGHEST)
    for number, power in clutter.powers().items():
        strongest.offer(number, power)
    assert strongest.labels.tolist() == [[SEA, RAIN, 0, 0]]
    strongest.offer(9, powers([5.99, 7.99, 0, 0]))
    assert strongest.labels.tolist() == [[SEA, RAIN, 0, 0]]  # the sea has 6 W, the rain 8
    strongest.offer(9, powers([6.01, 8.01, 0, 0]))
    assert strongest.labels.tolist() == [[9, 9, 0, 0]]


def test_rain_alone_leaves_nothing_to_the_sea() -> None:
    """Not even what rounding leaves of the square of a root."""
    rain = np.linspace(0.1, 10.0, 999, dtype=np.float32)
    clutter = ClutterRows(np.zeros((1, 999), dtype=np.complex64), np.sqrt(rain)[None], rain)
    assert (clutter.rain_share == 1.0).all()
