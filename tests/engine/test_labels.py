"""Labels against separately run sources: each source of the scene by itself, in an engine in which all others are silent."""

import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.labels import LabellingEngine
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import prepare
from radar_service.engine.source_numbers import BODY, INTERFERENCE, NOISE, RAIN, SEA, SECOND_TIME_AROUND, source_numbers
from radar_service.fidelity import PRESETS
from tests.alone import agreement, powers_alone
from tests.scenes import everything, point, scene

Labels = NDArray[np.uint32]
SHARE = 0.999  # of the cells where the strongest source leads by 3 dB
MAX_COST = 1.5  # of the plain run, with 20 visible bodies


def labels_of(made: rs.Scene, scan: int, seed: int = 0) -> Labels:
    engine = LabellingEngine(prepare(made, PRESETS["balanced"], seed))
    return np.concatenate([labels for _, _, _, labels in engine.labelled_tiles(scan)])


def crowded(moves: bool, **environment: Any) -> rs.Scene:
    """Land, metal, wood, points that fluctuate, one in the blind sector, two beyond the unambiguous range, all effects on."""
    quay = {"name": "quay", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 8, "position_m": [0, 500, 0]}
    ship = {"name": "ship", "shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "position_m": [0, 350, 0]}
    far = {"name": "far rock", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 30, "position_m": [-900, 1200, 0]}
    corner = {"name": "corner", "shape": "trihedral", "edge_m": 0.5, "position_m": [300, 200, 5], "heading_deg": 240}
    bodies = [
        {**quay, "material": "concrete"}, {**ship, "material": "wood", "speed_kn": 12, "course_deg": 70},
        {**corner, "scattering": "optics"}, {**far, "material": "rock"}, point("steady", 400, -500),
        point("slow", -300, 50, rcs_dbsm=20, swerling=1), point("fast", 300, -60, swerling=4),
        point("blind", 40, -500, speed_kn=0.5), point("far point", 1300, 100, 30, rcs_dbsm=60, speed_kn=0.5),
        point("blind under way", -211, -453),
    ]  # fmt: skip
    return scene(
        bodies,
        radar={
            "range_max_m": 800, "azimuths": 72, "beamwidth_deg": 8, "pulse_s": 1e-6, "power_w": 0.05, "prf_hz": 150e3,
            "second_time_around": True, "blind_sectors_deg": [[170, 180]],
        },
        environment={"noise": True, "multipath": True, "sea_state": 2, "rain_mm_h": 0.5} | environment,
        interference=[{"bearing_deg": 250, "level_db": 60, "prf_hz": 40e3, "beamwidth_deg": 60}],
        own_ship={"speed_kn": 8, "course_deg": 30, "roll_deg": 4} if moves else {},
    )  # fmt: skip


@pytest.mark.parametrize(("moves", "scan"), [(False, 0), (False, 3000), (True, 0), (True, 30)])
def test_labels_are_the_strongest_of_separately_run_sources(moves: bool, scan: int) -> None:
    made = crowded(moves)
    labels, powers = labels_of(made, scan), powers_alone(made, scan)
    assert {NOISE, SEA, RAIN, INTERFERENCE, SECOND_TIME_AROUND} <= set(np.unique(labels).tolist())
    agreed, leading = agreement(labels, powers)
    assert leading > 0.5 and agreed >= SHARE
    boresight, time_of = made.radar.schedule(scan * made.radar.azimuths + np.arange(made.radar.azimuths))
    assert set(np.unique(labels[made.blind(time_of, boresight)]).tolist()) <= {NOISE, INTERFERENCE}
    if not scan:
        assert set(source_numbers(made)[[0, 1, 2, 4, 5]].tolist()) <= set(np.unique(labels).tolist())


@pytest.mark.parametrize("moves", [False, True], ids=["at rest", "own ship under way"])
def test_without_noise_every_cell_with_any_echo_has_its_source(moves: bool) -> None:
    made = crowded(moves, noise=False, sea_state=0, rain_mm_h=0.0)
    labels = labels_of(made, 2)
    agreed, _ = agreement(labels, powers_alone(made, 2))
    assert agreed >= SHARE


def test_labels_hold_where_moving_metal_shadows_a_coast_in_rough_sea() -> None:
    made = everything()
    agreed, leading = agreement(labels_of(made, 3), powers_alone(made, 3))
    assert leading > 0.5 and agreed >= SHARE


def test_a_ship_that_passes_takes_the_labels_of_the_coast_behind_her() -> None:
    """The coast rests, so its labels are kept, but for the azimuths in her shadow: there they are those of noise or the ship."""
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
    agreed, leading = agreement(shadowed, powers_alone(made, 2))
    assert leading > 0.5 and agreed >= SHARE


@pytest.mark.parametrize("radar", [{"eclipsing": True}, {"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 15e6}])
def test_labels_hold_for_other_pulses(radar: dict[str, Any]) -> None:
    made = crowded(False)
    settings = scene(radar={"range_max_m": 800, "azimuths": 72, "beamwidth_deg": 8, "pulse_s": 1e-6, **radar}).radar
    made = replace(made, radar=settings)
    agreed, leading = agreement(labels_of(made, 1), powers_alone(made, 1))
    assert leading > 0.5 and agreed >= SHARE


def test_the_order_of_bodies_changes_no_name() -> None:
    """Where two sources are equally strong rounding may decide, so a few cells of 28,872 may differ."""
    made = crowded(False)
    turned = made.with_world(bodies=made.bodies[::-1])
    first, second = labels_of(made, 1), labels_of(turned, 1)
    count = len(made.bodies)
    as_first = np.where(second >= BODY, BODY + (count - 1) - (second - BODY), second)
    assert np.mean(first == as_first) > SHARE


def test_field_and_power_keep_their_bytes() -> None:
    prepared = prepare(everything(), PRESETS["balanced"], 4)
    plain = [(field.tobytes(), power.tobytes()) for _, field, power in Engine(prepared).tiles(2)]
    labelled = list(LabellingEngine(prepared, threads=2).labelled_tiles(2))
    assert plain == [(field.tobytes(), power.tobytes()) for _, field, power, _ in labelled]
    assert [labels.dtype for *_, labels in labelled] == [np.uint32] * len(labelled)


def test_labels_cost_at_most_half_a_run() -> None:
    """Twenty ships under way at sea. Scans alternate, so both kinds fill their caches."""
    rng = np.random.default_rng(5)
    ships = [
        {"name": f"ship {k}", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "speed_kn": 10, "material": "wood",
         "course_deg": float(rng.uniform(0, 360)), "position_m": [r * np.sin(a), r * np.cos(a), 0]}
        for k, (r, a) in enumerate(zip(rng.uniform(500, 4500, 20), rng.uniform(0, 2 * np.pi, 20), strict=True))
    ]  # fmt: skip
    engine = LabellingEngine(prepare(scene(ships, environment={"noise": True, "sea_state": 3}), PRESETS["balanced"], 0))
    spent: dict[bool, list[float]] = {False: [], True: []}
    for scan in range(10):
        labelled = scan % 2 == 1
        before = time.process_time()
        for _ in engine.labelled_tiles(scan) if labelled else engine.tiles(scan):
            pass
        spent[labelled].append(time.process_time() - before)
    assert min(spent[True]) < MAX_COST * min(spent[False])  # the least disturbed of each kind
