"""Recorded scenarios: what a tracker gets of the set of Trondheim, and recordings that are cut."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from radar_service.bench.recorded import UNKNOWN_DB, read_recording, recorded_scans
from radar_service.bench.run import observed
from radar_service.bench.scenario import ScenarioError, load_scenario, scenarios, with_profile

REAL = [name for name in scenarios() if name.startswith("real/")]
# Share of scans with a plot within 25 m of each vessel, counted from the set by others (row M01 of the published figures).
COUNTED = {"real/autoferry-2": (0.94, 0.94), "real/autoferry-4": (0.99, 1.0), "real/autoferry-16": (0.96, 0.90)}


def test_the_even_encounters_are_shipped() -> None:
    assert sorted(int(name.rpartition("-")[2]) for name in REAL) == [2, 4, 6, 16, 22]


@pytest.mark.parametrize("name", sorted(COUNTED))
def test_plots_stand_by_the_vessels_as_often_as_counted(name: str) -> None:
    """Within 0.07: gates of others differ."""
    scans = list(recorded_scans(load_scenario(name)))
    for k, share in enumerate(COUNTED[name]):
        near = []
        for scan in scans:
            east, north = scan.truths[k].position
            near.append(min((np.hypot(p.east - east, p.north - north) for p in scan.given.plots), default=99.0))
        assert np.mean(np.array(near) < 25.0) == pytest.approx(share, abs=0.07)


@pytest.mark.parametrize("name", REAL)
def test_scans_are_in_order_and_velocities_are_those_of_positions(name: str) -> None:
    scenario = load_scenario(name)
    scans = list(observed(scenario, 0))
    times = np.array([scan.given.time for scan in scans])
    assert len(scans) == scenario.scans and (np.diff(times) > 0).all() and times[0] == pytest.approx(1.68)
    for k in range(2):
        place, velocity = (np.array([getattr(scan.truths[k], what) for scan in scans]) for what in ("position", "velocity"))
        np.testing.assert_allclose((velocity[:-1] * np.diff(times)[:, None]).sum(axis=0), place[-1] - place[0], atol=12.0)
    for plot in scans[5].given.plots:
        assert (plot.snr_db, plot.cells) == (UNKNOWN_DB, 1)
        along = np.array([plot.east - scans[5].given.east, plot.north - scans[5].given.north])
        np.testing.assert_allclose(along, plot.range * np.array([np.sin(plot.bearing), np.cos(plot.bearing)]), atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text[: len(text) // 2], "it is no whole JSON file"),
        (lambda text: text.replace('"plots"', '"pots"', 1), "lacks 'plots'"),
        (
            lambda text: json.dumps(json.loads(text) | {"scans": json.loads(text)["scans"][:-1]}),
            "rows of truth for 58 scans",
        ),
        (lambda text: text.replace('"plots":[[', '"plots":[[1],[', 1), "half a plot"),
        (lambda text: text.replace('"time":1.68', '"time":99', 1), "its times do not rise"),
    ],
)
def test_a_recording_that_is_cut_is_named(change: Callable[[str], str], message: str, tmp_path: Path) -> None:
    scenario = load_scenario("real/autoferry-4")
    assert scenario.folder is not None
    path = tmp_path / "cut.json"
    path.write_text(change((scenario.folder / str(scenario.recorded)).read_text()))
    with pytest.raises(ScenarioError, match=f"cut.json: .*{message}"):
        read_recording(path)


def test_a_profile_is_for_simulated_plots() -> None:
    assert with_profile(load_scenario("fading"), "inland").plot_errors is not None
    with pytest.raises(ScenarioError, match="real/autoferry-2: its plots are recorded; leave --profile out"):
        with_profile(load_scenario("real/autoferry-2"), "inland")
