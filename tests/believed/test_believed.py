"""The short modules of believed, each under its name."""

from pathlib import Path
from typing import Any

import pytest

from radar_service.believed import tracking
from radar_service.believed.published import TABLE, TableError, published_rows
from radar_service.believed.run import NotExpressed, Run
from radar_service.believed.sea import MEASUREMENTS, reflectivity, seen_in_clutter, wave_heights
from radar_service.believed.targets import X

# published: the table of published figures, and what is refused of it.
TEXT = TABLE.read_text(encoding="utf-8")
LINE = next(line for line in TEXT.splitlines() if line.startswith("| P06 |"))


def test_the_table_has_its_78_rows_and_says_which_count() -> None:
    rows = published_rows(TEXT)
    kinds = {kind: sum(row.kind == kind for row in rows) for kind in ("measured", "standard", "manual", "model")}
    assert len(rows) == 78 and kinds == {"measured": 28, "standard": 22, "manual": 18, "model": 10}
    assert {row.id for row in rows if row.seen == "R"} == {"K01", "K03", "K06", "L04", "L06", "H01"}
    assert {row.id for row in rows if row.uncounted and row.kind != "model" and row.seen != "R"} == {
        "G01", "K04", "K08", "W01", "F04", "B08"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LINE.replace("2 %: definition", ""), "row P06 has no tolerance"),
        (LINE.replace("| manual |", "| rumour |"), "row P06: kind rumour"),
        (LINE.replace("| S |", ""), "row P06: 7 columns, not 8"),
        (f"{LINE}\n{LINE}", "row P06 stands twice"),
    ],
)
def test_a_faulty_row_is_named(text: str, message: str) -> None:
    with pytest.raises(TableError, match=message):
        published_rows(text)


# sea: the reflectivity that is measured is the engine's law, whatever beam, pulse and power.
@pytest.mark.parametrize(("state", "published"), [(1, -56.55), (3, -43.74)])
def test_sigma0_is_that_of_the_law(tmp_path: Path, state: int, published: float) -> None:
    """NRL 2012 at 9.41 GHz, HH, 1 degree (docs/accuracy.md); 0.1 dB of speckle."""
    assert reflectivity(Run(tmp_path), 9.41e9, "h", 1.0, state) == pytest.approx(published, abs=0.1)


def test_wave_heights_are_those_of_the_scale(tmp_path: Path) -> None:
    """Within 5 %, as two hours of 64 waves scatter."""
    assert wave_heights(Run(tmp_path), (3, 5)) == pytest.approx([1.04, 2.98], rel=0.05)


@pytest.mark.study
def test_a_larger_target_is_seen_more_often_in_clutter(tmp_path: Path) -> None:
    small, large = (seen_in_clutter(Run(tmp_path), X, section, 1296.0, 2.0, 2) for section in (1.0, 1e3))
    assert small < 0.7 < large


def test_wave_age_is_not_expressed(tmp_path: Path) -> None:
    with pytest.raises(NotExpressed, match="wind and waves of different ages"):
        MEASUREMENTS["W02"](Run(tmp_path))


# tracking: rows of tracking: what the bench's report gives, without its runs, and plots of vessels.
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
