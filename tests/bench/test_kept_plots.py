"""Plots and truth that are kept: the same as if made anew, and made anew where anything has changed that they are made of."""

import math
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from radar_service.bench import kept_plots
from radar_service.bench.kept_plots import bench_digest, makes_plots, observed_run, plots_digest, source_files
from radar_service.bench.run import observed
from radar_service.bench.scenario import Limit, PlotErrors, PlotSettings, Scenario
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.terminal import progress_bar
from tests.bench.test_scenario import SMALL

SCENARIO = Scenario(**{**SMALL, "scans": 3, "plot_errors": {"range_sd_m": 3.0, "bearing_sd_deg": 0.1}})


def changed(**changes: object) -> Scenario:
    return Scenario(**{**SCENARIO.model_dump(), **changes})


@pytest.mark.same_bytes
def test_what_is_kept_is_what_was_made(tmp_path: Path) -> None:
    """To the bit, for the first tracker and for the next one."""
    made = list(observed(SCENARIO, 1))
    assert list(observed_run(tmp_path, SCENARIO, 1).results) == made == list(observed_run(tmp_path, SCENARIO, 1).results)
    assert made[1].given.plots and made[1].truths


@pytest.mark.parametrize(
    "change",
    [
        lambda: {"scans": 4}, lambda: {"plots": PlotSettings(pfa=1e-5)}, lambda: {"plot_errors": PlotErrors(range_sd_m=1.0)},
        lambda: {"plot_errors": None}, lambda: {"fidelity": "realtime"}, lambda: {"targets": ("other",)},
        lambda: {"scene": {**SMALL["scene"], "environment": {"noise": False}}},
    ],
    ids=["scans", "plots", "errors", "no errors", "fidelity", "targets", "scene"],
)  # fmt: skip
def test_a_change_of_what_plots_are_made_of_has_another_digest(change: Callable[[], dict[str, object]]) -> None:
    assert plots_digest(changed(**change()), 1) != plots_digest(SCENARIO, 1) != plots_digest(SCENARIO, 2)


def test_limits_and_the_tuning_of_a_tracker_leave_plots_as_they_are() -> None:
    limit = Limit(metric="held", minimum=1.0, source="this test")
    assert plots_digest(changed(limit=(limit,), question="??"), 1) == plots_digest(SCENARIO, 1)


@pytest.mark.parametrize("what", ["source_digest", "arithmetic"])
def test_another_program_or_arithmetic_has_another_digest(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before = plots_digest(SCENARIO, 1)
    monkeypatch.setattr(kept_plots, what, lambda: "another")
    assert plots_digest(SCENARIO, 1) != before


def test_a_changed_mesh_has_another_digest(tmp_path: Path) -> None:
    body = {"name": "m", "mesh": "m.obj", "position_m": [0, 500, 0]}
    scenario = Scenario(**{**SMALL, "scene": {**SMALL["scene"], "body": [body]}, "folder": tmp_path})
    (tmp_path / "m.obj").write_text("v 0 0 0")
    before = plots_digest(scenario, 0)
    (tmp_path / "m.obj").write_text("v 0 0 1")
    assert plots_digest(scenario, 0) != before


def test_the_source_of_the_engine_counts_and_that_of_the_service_does_not() -> None:
    """The digest is that of files with a part in plots."""
    for parts in (("echo", "beam_passage.py"), ("plots", "extractor.py"), ("bench", "run.py")):
        assert makes_plots(parts)
    assert not makes_plots(("service", "hub.py")) and not makes_plots(("bench", "scores", "scoring.py"))
    assert {"lattice.c", "phasors.h", "library.py"} < {path.name for path in source_files()}


@pytest.mark.parametrize("broken", [b"", b"no gzip", b"\x1f\x8b\x08\x00cut"])
def test_a_broken_file_is_made_anew(broken: bytes, tmp_path: Path) -> None:
    first = observed_run(tmp_path, SCENARIO, 1)
    (path,) = tmp_path.iterdir()
    path.write_bytes(broken)
    assert observed_run(tmp_path, SCENARIO, 1) == first and len(path.read_bytes()) > 100


def test_a_changed_reference_tracker_has_another_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(kept_plots.PACKAGE / "bench", tmp_path / "bench")
    monkeypatch.setattr(kept_plots, "PACKAGE", tmp_path)
    before = bench_digest.__wrapped__()
    (tmp_path / "bench" / "report.html").write_text("no source")
    assert bench_digest.__wrapped__() == before
    with (tmp_path / "bench" / "trackers" / "stone_soup.py").open("a") as file:
        file.write("# changed")
    assert bench_digest.__wrapped__() != before


def test_the_first_flood_of_the_first_seed_is_told_after_its_scan(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sea = changed(
        scene={**SMALL["scene"], "environment": {"noise": True, "sea_state": 5}}, plots=PlotSettings(threshold="known")
    )
    told: list[str] = []

    def watched(*arguments: Any) -> Iterator[ScanResult]:
        for result in observed(*arguments):
            yield result
            told.append(capsys.readouterr().err)

    monkeypatch.setattr(kept_plots, "observed", watched)
    monkeypatch.setattr(progress_bar, "SECONDS", math.inf)  # a slow machine says how far it is
    observed_run(tmp_path, sea, 0)
    assert told[0].startswith("small, seed 0: scan 0: ") and 'set threshold to "marine"' in told[0] and told[1:] == ["", ""]
    told.clear()
    observed_run(tmp_path, sea, 1)
    assert told == ["", "", ""]


def test_a_long_run_says_how_far_its_plots_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress_bar, "SECONDS", 0.0)
    observed_run(tmp_path, SCENARIO, 1)
    assert capsys.readouterr().err.startswith("small, seed 1: plots: 1 of 3 scans, ")
