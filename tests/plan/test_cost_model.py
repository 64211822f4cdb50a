"""Counts of prepared engines by hand; costs of tiles by a clock that the test moves: each stage takes a known time."""

import time
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.engine.preparation import Prepared, prepare
from radar_service.plan import cost_model
from radar_service.plan.cost_model import (
    MAX_SECONDS,
    MIN_TILES,
    STRETCHES,
    SetUp,
    counts_per_body,
    engine_counts,
    engine_statistics,
    first_visibility_update,
    timed_costs,
)
from radar_service.plan.culling import CulledBody
from radar_service.records.fidelity import PRESETS
from radar_service.trace.embree import RayCount
from tests.scenes import point, scene

SMALL = {"azimuths": 960, "beamwidth_deg": 1.5, "range_max_m": 1500, "pulse_s": 2e-6, "rpm": 24}
MOVING = point("c", -300, 300, speed_kn=12, course_deg=90)
OTHER = {"bearing_deg": 40, "prf_hz": 2000.0, "rpm": 30, "level_db": 60, "beamwidth_deg": 2}


def prepared_from(*bodies: dict[str, Any], rays: RayCount | None = None, **sections: Any) -> Prepared:
    made: rs.Scene = scene(list(bodies), radar=SMALL, **sections)
    return prepare(made, PRESETS["balanced"], 0, rays=rays)


PLATE = {"name": "plate", "shape": "plate", "width_m": 20, "height_m": 20, "position_m": [0, 600, 8], "heading_deg": 180,
         "rcs_dbsm": 20, "speed_kn": 12, "course_deg": 90}  # fmt: skip


def test_resting_and_moving_points_are_counted() -> None:
    """12 kn for 2.5 s in steps of 5 m: 3.087 visibility updates per scan."""
    prepared = prepared_from(point("a", 0, 500), point("b", 700, 0), MOVING | {"position_m": [0, 300, 15]})
    counts = engine_counts(SetUp(prepared, {}, 17, 4))
    assert (counts.resting_echoes, counts.moving_echoes, counts.shadowed_echoes, counts.scatterers) == (2, 1, 0, 3)
    assert (counts.set_up_rays, counts.look_rays) == (17, 4)
    assert counts.looks_per_scan == pytest.approx(12 * 1852 / 3600 * 2.5 / 5.0)
    assert counts.transform_samples == 2 * prepared.compression.size
    per_body = counts_per_body(prepared)
    assert per_body.scatterers.tolist() == per_body.echoes.tolist() == [1, 1, 1]


def test_a_passing_plate_shadows_the_point_behind_it() -> None:
    prepared = prepared_from(point("behind", 0, 900, 10.0), PLATE)
    assert engine_counts(SetUp(prepared, {}, 0, 0)).shadowed_echoes == 1


def test_the_first_visibility_update_is_cached() -> None:
    rays = RayCount()
    prepared = prepared_from(point("behind", 0, 900, 10.0), PLATE, rays=rays)
    cast = rays.rays
    first_visibility_update(prepared)
    update = rays.rays
    assert update > cast
    first_visibility_update(prepared)
    assert rays.rays == update


def test_statistics_have_counts_costs_and_what_was_culled() -> None:
    culled = {0: CulledBody("always out of range", 0.0, occludes=False)}
    statistics = engine_statistics(SetUp(prepared_from(point("t", 0, 500)), culled, 0, 0))
    assert statistics.culled is culled and statistics.counts is not None and statistics.costs is not None
    assert statistics.bodies is not None and statistics.bodies.echoes.tolist() == [1]


class Clock:
    """CPU time that moves only in the stages of tiles, by what each of them takes; it notes the tiles."""

    def __init__(self, patch: pytest.MonkeyPatch, **seconds: float) -> None:
        self.now, self.tiles = 0.0, list[int]()
        patch.setattr(time, "thread_time", lambda: self.now)
        for stage in ("moving_rows", "receive", "add_stages", "add_resting"):
            patch.setattr(cost_model, stage, self._slow(stage, seconds.get(stage, 0.0)))

    def _slow(self, stage: str, seconds: float) -> Any:
        original = getattr(cost_model, stage)

        def slow(prepared: Prepared, *given: Any, **named: Any) -> Any:
            self.now += seconds
            if stage == "add_stages":
                self.tiles.append(int(given[0].azimuths.number[0]) // prepared.tile)
            return original(prepared, *given, **named)

        return slow


def test_each_stage_has_its_own_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scan of 30 tiles that takes less than a second is timed tile by tile, in order, after the end of the first scan."""
    prepared = prepared_from(MOVING, environment={"noise": True, "sea_state": 3}, interference=[OTHER])
    stages = {"moving_rows": 0.002, "receive": 0.003, "add_stages": 0.005, "add_resting": 0.006}
    clock = Clock(monkeypatch, **stages)
    costs, each = timed_costs(prepared), 1e6 / prepared.tile
    assert (costs.moving, costs.receiver, costs.effects["clutter"], costs.profiles) == pytest.approx(
        [seconds * each for seconds in stages.values()]
    )
    tiles = 960 // prepared.tile
    assert clock.tiles[-tiles:] == list(range(tiles, 2 * tiles)) and set(clock.tiles[:-tiles]) == {tiles - 2, tiles - 1}


def slow_updates(monkeypatch: pytest.MonkeyPatch, prepared: Prepared) -> None:
    """Each visibility update takes 0.1 s of the clock."""
    clock, update = Clock(monkeypatch), prepared.shadows.computed

    def slow(*step: Any) -> Any:
        clock.now += 0.1
        return update(*step)

    monkeypatch.setattr(prepared.shadows, "computed", slow)


def test_visibility_updates_cost_their_mean_as_often_as_they_occur(monkeypatch: pytest.MonkeyPatch) -> None:
    """12 kn for 2.5 s in steps of 5 m: 3.087 updates per scan, of 0.1 s each."""
    prepared = prepared_from(MOVING)
    slow_updates(monkeypatch, prepared)
    costs = timed_costs(prepared)
    assert costs.looks == pytest.approx(3.087 * 0.1e6 / 960, rel=1e-3)
    assert costs.total == pytest.approx(costs.looks)


def test_the_first_visibility_update_is_cached_and_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body at 1 kn needs one update a scan, of 0.1 s; that of the first scan is known before."""
    prepared = prepared_from(MOVING | {"speed_kn": 1.0})
    prepared.shadows.at(0)
    slow_updates(monkeypatch, prepared)
    assert timed_costs(prepared).looks == pytest.approx(0.1e6 / 960)


def test_a_slow_scan_is_timed_in_stretches_all_round_until_the_time_is_spent(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepared_from(MOVING)
    clock = Clock(monkeypatch, receive=0.06)
    assert timed_costs(prepared).receiver == pytest.approx(0.06 * 1e6 / prepared.tile)
    assert clock.now < MAX_SECONDS + 0.06 * (1 + 960 / prepared.tile / STRETCHES) + 0.12
    quarters = (np.array(clock.tiles) % (960 // prepared.tile)) * 4 // (960 // prepared.tile)
    assert set(quarters.tolist()) == {0, 1, 2, 3}


def test_a_very_slow_scan_has_few_tiles_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each tile takes ten seconds: two stretches and the tiles before them."""
    prepared = prepared_from(MOVING)
    clock = Clock(monkeypatch, receive=10.0)
    assert timed_costs(prepared).receiver == pytest.approx(10.0 * 1e6 / prepared.tile)
    assert len(clock.tiles) <= 2 + 2 * (MIN_TILES + 1)


@pytest.mark.parametrize("azimuths", [8, 40, 100])
def test_a_scan_of_one_or_two_tiles_is_timed_too(azimuths: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """And none before the start of the simulation."""
    radar = SMALL | {"azimuths": azimuths, "beamwidth_deg": 60}
    prepared = prepare(scene([MOVING], radar=radar), PRESETS["balanced"], 0)
    clock = Clock(monkeypatch, receive=2.0)
    assert timed_costs(prepared).receiver > 0.0
    assert min(clock.tiles) >= 0


def test_physical_optics_has_its_own_cost_and_bodies_without_it_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each evaluation of a plate takes 10 ms; it passes the beam once a scan with two nodes or more."""
    plate = {"name": "p", "shape": "plate", "width_m": 3, "height_m": 2, "scattering": "optics", "position_m": [-300, 300, 0],
             "speed_kn": 12, "course_deg": 90}  # fmt: skip
    prepared = prepared_from(plate)
    clock, evaluated = Clock(monkeypatch), BeamPassages.evaluated

    def slow(passages: BeamPassages, *node: Any) -> Any:
        clock.now += 0.01
        return evaluated(passages, *node)

    monkeypatch.setattr(BeamPassages, "evaluated", slow)
    costs = timed_costs(prepared)
    assert costs.aspects >= 0.01 * 1e6 / 960 and costs.moving == 0.0
    assert costs.total == pytest.approx(costs.aspects)
    assert timed_costs(prepared_from(MOVING)).aspects == 0.0
