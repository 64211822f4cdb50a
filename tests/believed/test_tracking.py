"""Rows of tracking: what the bench's report gives, without its runs, and plots of vessels."""

from pathlib import Path
from typing import Any

import pytest

from radar_service.believed import tracking
from radar_service.believed.run import Run


def limit(metric: str, value: float, **bounds: float) -> dict[str, Any]:
    return {"metric": metric, "value_95": value, **bounds}


def test_accuracy_is_the_worst_of_four_geometries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = iter((0.2, 0.9, 0.1, 0.3))

    def fake_bench(scenarios: list[Any], seeds: int, tracker: str, folder: Path) -> tuple[dict[str, Any], None]:
        share = next(values)
        return {"scenarios": [{"verdicts": [limit(metric, share, maximum=1.0) for metric in tracking.TABLE_3]}]}, None

    monkeypatch.setattr(tracking, "bench", fake_bench)
    figures = tracking.accuracy(Run(tmp_path))
    assert [figure.computed for figure in figures] == [0.9] * 7 and len([*tmp_path.glob("msc192-table3-*.toml")]) == 4


def test_a_track_that_is_lost_is_outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdicts = [limit("held", 0.5), limit("velocity_kn_1min", 0.2)]
    monkeypatch.setattr(tracking, "bench", lambda *given: ({"scenarios": [{"verdicts": verdicts}]}, None))
    assert [figure.inside for figure in tracking.fading(Run(tmp_path))] == [False, True]


def test_plots_of_a_boat_stand_by_her(tmp_path: Path) -> None:
    """Of a jet boat of 8 m: errors in range are within her length, and most scans have her."""
    boats = {"jet boat": tracking.BOATS["jet boat"]}
    ((share, errors),) = tracking.plots_of_boats(Run(tmp_path), boats, scans=3).values()
    assert share > 0.8 and len(errors) and abs(errors).max() < 8.0
