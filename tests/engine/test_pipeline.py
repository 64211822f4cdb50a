"""The corrected engine against the closed form: range, phase, beam, level, at rest and moving."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.pipeline import (
    Contributions,
    Engine,
    blocks,
    contributions,
    profiles,
    tile_azimuths,
    visibility_steps,
)
from radar_service.engine.preparation import Prepared, prepare
from radar_service.records.fidelity import PRESETS
from tests.alone import crowded
from tests.reference import point_scene
from tests.scenes import everything, point, scene

COARSE = {"range_max_m": 1200, "pulse_s": 1e-6, "azimuths": 16, "beamwidth_deg": 40}  # for statistics over many scans
error_db = partial(point_scene.error_db, every=5)  # each place within a block in turn


def scattered(count: int, range_max: float, seed: int, **motion: Any) -> list[dict[str, Any]]:
    """Points all round, each about as strong as the others, so that every one of them counts in the error."""
    rng = np.random.default_rng(seed)
    bodies = []
    for i in range(count):
        r, azimuth, up = rng.uniform(60, range_max), rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 30)
        bodies.append(point(f"p{i}", r * np.sin(azimuth), r * np.cos(azimuth), up, 40 * np.log10(r / 100), **motion))
    return bodies


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    "radar",
    [
        {"range_max_m": 3000},
        {"range_max_m": 1500, "sample_rate_hz": 200e6},
        {"range_max_m": 1500, "beamwidth_deg": 0.9, "azimuths": 2048},
        {"range_max_m": 1500, "beamwidth_deg": 0.5, "azimuths": 361, "coarse_azimuths": True},
        {"range_max_m": 1500, "pulse_s": 0.4e-6, "window": "blackman"},
        {"range_max_m": 1500, "window": "none"},
        {"range_max_m": 12_000, "bandwidth_hz": 5e6, "frequency_hz": 3.05e9, "tilt_deg": 0},
    ],
    ids=["default", "200MSPS", "fine beam", "beam of half a step", "short pulse", "no window", "S band"],
)
def test_points_at_rest_meet_the_closed_form_under_the_full_beam(radar: dict[str, Any]) -> None:
    """Relative field error below -60 dB, 10 dB better than required: kernels err by -80, short pulses leave the band."""
    made = scene(scattered(6, 0.95 * radar["range_max_m"], seed=1), radar=radar)
    assert error_db(made, rs.Simulator(made).scan()) < -60


@pytest.mark.sample(3)
@pytest.mark.parametrize("knots", [0.1, 12.0, 40.0])
@pytest.mark.parametrize("moving", ["own ship", "bodies"])
def test_moving_points_meet_the_closed_form_at_every_instant(knots: float, moving: str) -> None:
    """-50 dB (required): the beam of moving echoes is cut at 12 beamwidths, which errs by -55 dB (docs/engine.md#errors)."""
    motion = {"speed_kn": knots, "course_deg": 30}
    bodies = scattered(6, 2800, seed=2, **(motion if moving == "bodies" else {}))
    made = scene(bodies, radar={"range_max_m": 3000}, own_ship=motion if moving == "own ship" else {})
    sim = rs.Simulator(made)
    sim.scan()
    assert error_db(made, sim.scan()) < -50


def test_a_target_at_the_very_end_and_one_under_the_antenna_do_not_wrap() -> None:
    """Sidelobes reach cT/2 past either end of the range; nothing of them may come out at the other end."""
    made = scene([point("far", 0, 2999.5, rcs_dbsm=50), point("near", 2.0, 2.0, 15, -70)], radar={"range_max_m": 3000})
    assert error_db(made, rs.Simulator(made).scan()) < -60


def test_a_target_beyond_the_range_still_leaves_its_sidelobes() -> None:
    """A strong target 200 m past the last bin: its range sidelobes are inside and exact to the kernel (-60 dB of the peak)."""
    made = scene([point("past", 0, 3200)], radar={"range_max_m": 3000})
    scan = rs.Simulator(made).scan()
    exact = point_scene.exact_field(made, scan)
    peak = np.sqrt(made.radar.power * made.radar.gain**2 * made.radar.wavelength**2 * 10 / (4 * np.pi) ** 3) / 3200**2
    assert np.abs(exact).max() > 1e-4 * peak
    assert np.abs(scan.field - exact).max() < 1e-4 * peak


def test_slow_fluctuation_holds_while_the_beam_passes_and_fast_does_not() -> None:
    """Swerling 1 keeps its draw over all azimuths of a crossing, north included; Swerling 2 draws each azimuth anew."""
    for case, same in ((1, True), (2, False)):
        made = scene([point("t", 0, 500, swerling=case)], radar={"range_max_m": 600})
        sim, steady = rs.Simulator(made), rs.Simulator(scene([point("t", 0, 500)], radar={"range_max_m": 600})).scan()
        first, second = sim.scan(), sim.scan()
        column = int(np.argmax(steady.power[0]))
        last = first.power[719, column] / steady.power[719, column]
        next_one = second.power[0, column] / steady.power[0, column]
        assert (abs(last / next_one - 1) < 1e-3) == same


def test_each_stage_adds_to_the_profiles() -> None:
    """Nothing rests, as the antenna moves. Without clutter or without interference the profiles of the first scan differ."""
    prepared = prepare(everything(), PRESETS["balanced"], 5)
    assert prepared.resting_profiles is None and len(prepared.moving) == 5

    def scan_of(changed: Prepared) -> bytes:
        return b"".join(field.tobytes() for _, field, _ in Engine(changed).tiles(0))

    whole = scan_of(prepared)
    assert scan_of(replace(prepared)) == whole
    assert prepared.stages.keys() == {"clutter", "interference"}
    for name in prepared.stages:
        assert scan_of(replace(prepared, stages={name: prepared.stages[name]})) != whole


def test_tiles_cover_a_scan_and_end_with_it() -> None:
    """The last tile of a scan is shorter; numbers go on across scans, boresights start again at north."""
    prepared = prepare(scene([point("t", 0, 500)], radar={"range_max_m": 600}), PRESETS["balanced"], 1)
    radar, tile = prepared.scene.radar, prepared.tile
    starts = range(0, radar.azimuths, tile)
    number = np.concatenate([tile_azimuths(prepared, 3, start).number for start in starts])
    np.testing.assert_array_equal(number, 3 * radar.azimuths + np.arange(radar.azimuths))
    first = tile_azimuths(prepared, 3, 0)
    assert first.boresight[0] == 0.0 and first.time[0] == pytest.approx(3 * radar.rotation_period, rel=1e-15)
    assert [start for start, _, _ in Engine(prepared).tiles(3)] == list(starts)


def test_a_block_lies_within_one_visibility_step() -> None:
    """12 kn in steps of 5 m: 0.81 s, so that steps end within tiles. Blocks cover every azimuth of a scan once, in order, and
    none has more azimuths than the fidelity says where echoes are near."""
    made = scene([point("t", 0, 50)], own_ship={"speed_kn": 12, "course_deg": 30})
    prepared, inner = prepare(made, PRESETS["balanced"], 0), 0
    for start in range(0, made.radar.azimuths, prepared.tile):
        azimuths = tile_azimuths(prepared, 1, start)
        steps, parts = visibility_steps(prepared, azimuths), list(blocks(prepared, azimuths))
        assert [n for first, stop in parts for n in range(first, stop)] == list(range(len(azimuths.time)))
        assert all(len(np.unique(steps[first:stop])) == 1 and stop - first <= 16 for first, stop in parts)
        inner += len(np.unique(steps)) - 1
    assert inner >= 3


def test_few_echoes_are_one_block_of_each_visibility_step() -> None:
    """One point 3 km off: the blocks of a tile are its visibility steps."""
    made = scene([point("t", 0, 3000)], own_ship={"speed_kn": 12, "course_deg": 30})
    prepared, counts = prepare(made, PRESETS["balanced"], 0), []
    for start in range(0, made.radar.azimuths, prepared.tile):
        azimuths = tile_azimuths(prepared, 1, start)
        counts.append(len(list(blocks(prepared, azimuths))))
        assert counts[-1] == len(np.unique(visibility_steps(prepared, azimuths)))
    assert set(counts) == {1, 2}


def test_contributions_without_profiles_are_those_that_profiles_are_made_of() -> None:
    """A scan with blind azimuths and interference in which everything moves."""
    prepared = prepare(crowded(True), PRESETS["balanced"], 0)
    blind, pulses = 0, 0
    for start in range(0, 72, prepared.tile):
        azimuths, expected = tile_azimuths(prepared, 1, start), Contributions()
        profiles(prepared, azimuths, expected)
        got = contributions(prepared, azimuths)
        assert expected.rows is not None and len(expected.added.fields) == len(got.added.fields) == 1
        assert not expected.rows[~expected.transmitting].any()
        np.testing.assert_array_equal(got.transmitting, expected.transmitting)
        np.testing.assert_array_equal(got.rows, expected.rows)
        np.testing.assert_array_equal(got.added.fields[0].field, expected.added.fields[0].field)
        assert [block[:2] for block in got.echoes] == [block[:2] for block in expected.echoes] != []
        rows = [{n: rows.keys() for n, rows in each.added.profiles.items()} for each in (got, expected)]
        assert rows[0] == rows[1]
        blind, pulses = blind + np.count_nonzero(~expected.transmitting), pulses + len(expected.added.profiles)
    assert blind and pulses
