"""Ships in a seaway whose aspects share what was traced: against each aspect traced by itself, and against a finer trace."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.passage_traces import TraceRun
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import fidelity_from_name
from radar_service.scattering.physical_optics import optical_body, tube_tracing
from tests.reference.legs import leg_length

BALANCED = fidelity_from_name("balanced")
SCENES = Path(__file__).parents[1] / "scenes"
SHIPS = ("coaster.obj", "ferry.obj", "freighter.obj", "tanker.obj")
EARTH = 4.0 / 3.0 * 6_371_000.0
CELL = 3.0  # m of range
SEA = -0.9  # reflection coefficient of one way


def at_sea(mesh: str, distance: float, rng: np.random.Generator, azimuths: int = 2048) -> rs.Scene:
    """A ship at 10 kn on a drawn course that rolls by 5 degrees, pitches and heaves, in sea state 3."""
    body = {
        "name": "ship", "mesh": mesh, "scattering": "optics", "position_m": [0, distance, 0], "speed_kn": 10.0,
        "course_deg": float(rng.uniform(0, 360)), "roll_deg": 5.0, "roll_period_s": 10.0,
        "roll_phase_deg": float(rng.uniform(0, 360)), "pitch_deg": 1.0, "heave_m": 0.3,
    }  # fmt: skip
    radar = {"height_m": 15, "range_max_m": 2000, "azimuths": azimuths}
    table = {"radar": radar, "environment": {"multipath": True, "sea_state": 3, "noise": False}, "body": [body]}
    return rs.load_scene(table, folder=SCENES)


def field(made: rs.Scene, spoke: int, observed: ObservedEchoes) -> NDArray[np.complex128]:
    """Sums in cells of range of what was evaluated at a spoke."""
    antenna = made.antenna(float(made.radar.time_of_spokes(float(spoke))))[0]
    direct, by_sea = (leg_length(observed.position, antenna, EARTH, way) for way in (False, True))
    ways = observed.echoes.path
    length = np.where(ways < 1, direct, by_sea) + np.where(ways < 2, direct, by_sea)
    result = np.zeros(2000, dtype=complex)
    phasor = np.exp(-2j * np.pi * length / made.radar.wavelength) * SEA**ways
    np.add.at(result, np.floor(direct / CELL).astype(int), observed.echoes.amplitude * phasor)
    return result


def nodes_of_a_passage(made: rs.Scene) -> Iterator[tuple[float, NDArray[np.complex128], NDArray[np.complex128]]]:
    """Of the nodes of the passage in the second scan that share a trace: one-way gain, and the field of each with what it shares
    and traced by itself."""
    passages = prepare(made, BALANCED, 3).moving.passages
    crossing, (body,) = passages.crossing(0, 1.0), made.bodies
    half_angle = float(np.arcsin(min(1.0, body.radius / np.hypot(*body.middle_at(made.radar.rotation_period)[:2]))))
    for node, run in passages.runs(0, crossing).items():
        off = max(0.0, abs(node - crossing) * made.radar.azimuth_step - half_angle)
        kept, anew = (field(made, node, passages.evaluated(0, node, 0.0, each)) for each in (run, None))
        yield float(made.radar.azimuth_gain(np.array([off]))[0]), kept, anew


@pytest.mark.parametrize(
    ("mesh", "distance", "passages"),
    [
        ("coaster.obj", 545.0, 1),
        *(
            pytest.param(mesh, distance, count, marks=pytest.mark.study)
            for mesh in SHIPS
            for distance, count in ((150, 1), (250, 2), (545, 4), (1000, 6))
        ),
    ],
)
def test_aspects_of_a_passage_that_share_a_trace(mesh: str, distance: float, passages: int) -> None:
    """Weighted by what the beam receives. Which tubes are divided hangs on centimetres, so that a trace of the same aspect errs
    by 0.2 to 0.6 (the test below). The field differs from it by 0.2 at most, its power by 0.8 dB; measured 0.02 to 0.2."""
    rng = np.random.default_rng(7)
    wrong, power, decibels = 0.0, 0.0, list[tuple[float, float]]()
    for _ in range(passages):
        for gain, kept, anew in nodes_of_a_passage(at_sea(mesh, distance, rng)):
            weight = gain**2
            wrong += weight * float(np.linalg.norm(kept - anew) ** 2)
            power += weight * float(np.linalg.norm(anew) ** 2)
            decibels.append((weight, 20.0 * np.log10(np.linalg.norm(kept) / np.linalg.norm(anew))))
    assert len(decibels) >= 4 * passages
    weights, apart = np.array(decibels).T
    assert np.sqrt(wrong / power) < 0.2
    assert np.sqrt((weights * apart**2).sum() / weights.sum()) < 0.8


@pytest.mark.study
@pytest.mark.parametrize("mesh", SHIPS)
def test_what_is_kept_over_a_tenth_of_a_degree_errs_no_more_than_what_is_traced(
    mesh: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against tubes of a quarter of the size, 40 aspects: at most 1.10 times what a trace of the same aspect errs, rms."""
    rng = np.random.default_rng(5)
    errors = []
    for _ in range(40):
        made, start = at_sea(mesh, float(rng.choice([250, 545, 1000])), rng), int(rng.integers(8000))
        passages, spokes = prepare(made, BALANCED, 3).moving.passages, start + np.arange(800)
        now = int(np.interp(np.deg2rad(0.1), passages.turned(0, spokes), spokes))
        kept, anew = (field(made, now, passages.evaluated(0, now, 0.0, run)) for run in (TraceRun(start, (now,)), None))
        with monkeypatch.context() as finer:
            finer.setattr(optical_body, "TUBES_ACROSS", 96)
            finer.setattr(optical_body, "SHORTEST", 1.0 / 12.0)
            finer.setattr(tube_tracing, "MAX_DIVIDED", (16_000, 8_000))
            finer.setattr(tube_tracing, "MAX_HALVINGS", 12)
            exact = field(made, now, passages.evaluated(0, now, 0.0))
        errors.append([np.linalg.norm(some - exact) / np.linalg.norm(exact) for some in (kept, anew)])
    of_kept, of_anew = np.sqrt(np.mean(np.square(errors), axis=0))
    assert of_kept < 1.10 * of_anew


@pytest.mark.study
@pytest.mark.parametrize("mesh", SHIPS)
@pytest.mark.parametrize("distance", [150.0, 545.0])
def test_from_spoke_to_spoke_no_more_jumps_than_where_each_aspect_is_traced(mesh: str, distance: float) -> None:
    """Third differences along 4096 azimuths, of the peak: a run that is traced beside another one must not jump."""
    made = at_sea(mesh, distance, np.random.default_rng(11), 4096)
    jumps = []
    for fidelity in (BALANCED, replace(BALANCED, trace_step_deg=0.0)):
        field = np.concatenate([part for _, part, _ in Engine(prepare(made, fidelity, 3)).tiles(1)])
        jumps.append(np.abs(np.diff(field, n=3, axis=0)).max() / np.abs(field).max())
    assert jumps[0] < 1.1 * jumps[1]
