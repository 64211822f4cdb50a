"""Verdicts of rows, and the page and picture of them."""

import math
from pathlib import Path

import pytest

from radar_service.believed import verdicts
from radar_service.believed.published import TABLE, TableError, published_rows
from radar_service.believed.run import Figure, NotExpressed, Run
from radar_service.believed.verdicts import MEASUREMENTS, REASONS, chosen_rows, measured, page, row_text, write_picture

INSIDE, OUTSIDE = Figure.within("a", 1.0, 1.0, 0.5, "dB"), Figure.least("b", 2.0, 3.0, "NM")


def cannot(run: Run) -> list[Figure]:
    raise NotExpressed("no such thing")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measurements of four rows: inside, outside, not expressed, and none."""
    rows = {"P06": lambda run: [INSIDE], "P04": lambda run: [INSIDE, OUTSIDE], "W02": cannot}
    monkeypatch.setattr(verdicts, "MEASUREMENTS", rows)
    monkeypatch.setattr(verdicts, "REASONS", {"P04": "it is so"})


@pytest.mark.usefixtures("few")
def test_misses_come_first_and_each_says_why(tmp_path: Path) -> None:
    found = list(measured(chosen_rows(["P06", "P04", "W02", "T07", "N12"]), tmp_path))
    assert [each.word for each in found] == ["inside", "outside", "outside", "outside", "shown"]
    assert [each.reason for each in found[1:4]] == ["it is so", "no such thing", verdicts.NOT_COMPUTED]
    text = page(found)
    assert "**1 of 4 rows are inside.** 1 are shown." in text and "**b 2 NM (3 or more)**" in text
    places = [
        text.index(part)
        for part in ("## Outside", "| P04 |", "| W02 |", "## Inside", "| P06 |", "## Shown", "| N12 |", "## Shown: video")
    ]
    assert places == sorted(places)
    assert "source: JRC JMA-9922" in row_text(found[1], tmp_path) and "why: it is so" in row_text(found[1], tmp_path)
    write_picture(found, tmp_path / "believed.png")
    assert (tmp_path / "believed.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_row_is_named() -> None:
    with pytest.raises(TableError, match="no row Z99, P6; there are C01, C02"):
        chosen_rows(["P06", "Z99", "P6"])


def test_every_row_that_counts_has_a_measurement() -> None:
    rows = published_rows(TABLE.read_text(encoding="utf-8"))
    assert {row.id for row in rows if not row.uncounted} <= {*MEASUREMENTS} <= {row.id for row in rows}
    assert {*REASONS} <= {*MEASUREMENTS} and not math.isnan(INSIDE.computed)
