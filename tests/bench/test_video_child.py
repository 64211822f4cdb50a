"""The product's own extractor as a program under test."""

import io
import json
from collections.abc import Iterator
from typing import Any

import pytest

from radar_service.bench import video_child
from tests.bench.known_trackers import Imm
from tests.bench.trackers.test_stone_soup import given, plot

HEADER = {"type": "header", "video": {"address": "x"}}


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    def plots_of(video: Any, lines: Iterator[str]) -> Iterator[Any]:
        for number, _ in enumerate(lines):
            yield given(number, (plot(number * 2.5 + 1.0, 100.0, 200.0),))

    monkeypatch.setattr(video_child, "plots_of", plots_of)
    monkeypatch.setattr(video_child, "tracker_for", lambda name, header: Imm())
    return iter([json.dumps(HEADER), *["{}"] * 8])


def answers(tracker: str | None, lines: Iterator[str]) -> list[dict[str, Any]]:
    video_child.serve(tracker, lines, written := io.StringIO())
    return [json.loads(line) for line in written.getvalue().splitlines()]


def test_each_scan_is_answered_with_tracks(lines: Iterator[str]) -> None:
    made = answers("gnn", lines)
    assert [(line["type"], line["scan"]) for line in made] == [("tracks", scan) for scan in range(8)]
    (track,) = made[-1]["tracks"]
    assert (track["east"], track["north"]) == (pytest.approx(100.0), pytest.approx(200.0))


def test_without_a_tracker_with_plots(lines: Iterator[str]) -> None:
    assert [line["plots"][0]["east"] for line in answers(None, lines)] == [100.0] * 8
