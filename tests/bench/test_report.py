"""The report of the bench as files and as a table."""

import base64
import json
import re
from pathlib import Path

import pytest

from radar_service.bench.bench import report
from radar_service.bench.report import (
    comparison,
    gravest_first,
    page,
    plot_table,
    summary_table,
    unit_of,
    verdict_table,
    write_report,
)
from radar_service.bench.scenario import Limit, Scenario
from tests.bench.test_scenario import SMALL

TARGET = {"body": "t <1>", "position": [0.0, 100.0], "track": None, "nearest": 3.2, "allowed": 15.0}
EVENT = {"kind": "break", "scan": 1, "last": 1, "body": "t <1>", "other": "", "what": "t <1> has no track"}
TRACK = {"track": "1", "time": 2.0, "east": 1.0, "north": 103.0, "velocity_east": 1.0, "velocity_north": 0.0}
RUN = {
    "seed": 0, "remark": None, "failure": None, "metrics": {"ospa_m": 3.0, "held": None}, "events": [EVENT],
    "scans": [{"scan": 0, "time": 2.5, "own": [0, 0], "plots": [[1.0, 100.0]], "tracks": [TRACK], "targets": [TARGET]},
              {"scan": 1, "time": 5.0, "own": [0, 0], "plots": [], "tracks": [], "targets": [TARGET]}],
}  # fmt: skip
LIMITS = (Limit(metric="ospa_m", maximum=10, source="a & b"), Limit(metric="held", minimum=1, source="c", decides=False))


def data(tracker: str = "gnn", ospa: float = 3.0) -> dict:
    run = {**RUN, "metrics": {**RUN["metrics"], "ospa_m": ospa}}
    return report({"small": Scenario(**{**SMALL, "limit": LIMITS, "judges": "plots"})}, {"small": [run]}, tracker)


def test_files_are_written_and_can_be_read(tmp_path: Path) -> None:
    write_report(data("<gnn>"), {"small": RUN}, tmp_path)
    assert json.loads((tmp_path / "report.json").read_text()) == data("<gnn>")
    page = (tmp_path / "report.html").read_text()
    assert "&lt;gnn&gt;" in page and "<gnn>" not in page and "a &amp; b" in page
    assert "ospa_m at most 10 m<" in page and "held at least 1" in page and "undecided" in page and ">shown<" in page
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert base64.b64decode(picture).startswith(b"\x89PNG")


def test_verdicts_are_a_table_with_values_limits_and_units() -> None:
    run = {**RUN, "metrics": {**RUN["metrics"], "ospa_m": 3.0}, "remark": "1 of 2 scans flood the plot extractor; <more>"}
    made = report({"small": Scenario(**{**SMALL, "limit": LIMITS, "judges": "plots"})}, {"small": [run]}, "gnn")
    lines = [line.split() for line in verdict_table(made).splitlines()]
    assert lines[0] == ["scenario", "metric", "95", "%", "value", "limit", "unit", "missed", "verdict"]
    assert lines[1] == "small ospa_m 3 at most 10 m 0 of 1 undecided".split()
    assert lines[2] == "small held none at least 1 1 of 1 shown".split()
    assert lines[3] == "small: remark: 1 of 2 scans flood the plot extractor; <more>".split()


@pytest.mark.parametrize(
    ("metric", "unit"),
    [("relative_course_deg_1min", "degrees"), ("cpa_nm_3min", "NM"), ("tcpa_min_3min", "min"), ("true_speed_kn_1min", "kn"),
     ("velocity_error_m_s", "m/s"), ("ospa_m", "m"), ("held", ""), ("identity_changes", "")],
)  # fmt: skip
def test_a_metric_has_the_unit_of_its_name(metric: str, unit: str) -> None:
    assert unit_of(metric) == unit


def test_two_reports_side_by_side() -> None:
    lines = comparison(data("one", 3.0), data("two", 4.5)).splitlines()
    assert lines[0].split() == ["scenario", "metric", "one", "two"]
    assert ["small", "ospa_m", "3", "4.5"] in [line.split() for line in lines]
    assert ["small", "held", "none", "none"] in [line.split() for line in lines]


@pytest.mark.parametrize("runs", [1, 3])
def test_means_and_percentiles(runs: int) -> None:
    made = [{**RUN, "metrics": {"ospa_m": float(k)}} for k in range(runs)]
    (its,) = report({"small": Scenario(**SMALL)}, {"small": made}, "gnn")["scenarios"]
    assert its["metrics"] == {"ospa_m": (runs - 1) / 2} and its["percentile_95"]["ospa_m"] == pytest.approx(
        0.95 * (runs - 1)
    )


def test_failed_runs_are_listed_with_scan_status_and_last_line() -> None:
    failure = {"scan": 7, "message": "it has ended", "status": -11, "stderr": "Segmentation <fault>", "hangs": False}
    runs = [{**RUN, "seed": seed, "metrics": {}, "failure": failure, "scans": [], "events": []} for seed in range(7)]
    made = report({"small": Scenario(**{**SMALL, "limit": LIMITS})}, {"small": runs}, "mine")
    lines = verdict_table(made).splitlines()
    assert "small, seed 4: failed at scan 7: it has ended; exit status -11; it said: Segmentation <fault>" in lines
    assert lines[-1] == f"the worst run again: {made['sheet']['again']} --seed 0"
    assert lines[-2] == "small: 2 more failed runs" and not any("at most" in line for line in lines)
    assert (
        lines[1]
        == f"small: the tracker failed in all 7 runs, and so misses all {len(made['scenarios'][0]['verdicts'])} limits"
    )
    assert summary_table(made).splitlines()[2].strip().startswith("failed at scan 7: it has ended; exit status -11")
    text = page(made, {"small": None})
    assert 0 < text.index("Segmentation &lt;fault&gt;") < text.index("<h2")  # in the summary
    assert "<p>the tracker failed in all 7 runs" in text and "at most" not in text
    assert all(verdict["failures"] == 7 for verdict in made["scenarios"][0]["verdicts"])


def test_limits_of_every_scenario_ask_nothing_of_runs_that_cannot_judge_them() -> None:
    """Nobody vanishes here, so no track has to end; where the tracker owes a state and has none, it misses the limit."""
    run = {**RUN, "metrics": {"completeness": 1.0, "velocity_kn_1min": None}}
    (its,) = report({"small": Scenario(**SMALL)}, {"small": [run]}, "mine")["scenarios"]
    assert {one["metric"]: one["failures"] for one in its["verdicts"]} == {"completeness": 0, "velocity_kn_1min": 1}


def test_the_summary_has_the_gravest_scenario_first() -> None:
    limit = Limit(metric="held", minimum=1, source="c")
    scenarios = {
        name: Scenario(**{**SMALL, "name": name, "limit": (limit,), "judges": "plots"}) for name in ("good", "<bad>")
    }
    runs = {"good": [{**RUN, "metrics": {"held": 1.0}}], "<bad>": [RUN, {**RUN, "seed": 1, "events": [EVENT] * 4}]}
    made = report(scenarios, runs, "mine", smoke=True)
    assert [one["name"] for one in gravest_first(made)] == ["<bad>", "good"]
    lines = [line.split() for line in summary_table(made).splitlines()]
    assert lines[1:3] == ["<bad> fail 2 of 2 none none none none 0".split(), "scan 1: break: t <1> has no track".split()]
    assert lines[3] == "good no gross miss 0 of 1 none none none none".split()
    text = page(made, {"good": None, "<bad>": None})
    assert "<table>" in text and "<bad>" not in text and "t &lt;1&gt; has no track" in text
    assert (
        text.index("scan 1: break") < text.index("<h2") < text.index("seed 0 misses held none") < text.index("seed 1 misses")
    )


def test_the_metrics_of_plots_are_a_table() -> None:
    runs = [{**RUN, "metrics": {"detected": share, "range_sd_m": 2.0}} for share in (0.5, 1.0)]
    made = report({"small": Scenario(**{**SMALL, "judges": "plots"})}, {"small": runs}, "mine")
    lines = [line.split() for line in plot_table(made).splitlines()]
    assert lines[1] == "small detected 0.75 0.25".split() and lines[6] == "small range_sd_m 2 0 m".split()
    assert lines[2] == "small detected_worst none none".split()


def test_more_failed_runs_and_events_are_counted() -> None:
    events = [{**EVENT, "scan": 2 * k, "last": 2 * k} for k in range(15)]
    runs = [{**RUN, "seed": seed, "events": events} for seed in range(12)]
    limit = Limit(metric="held", minimum=1, source="c")
    made = report({"small": Scenario(**{**SMALL, "limit": (limit,), "judges": "plots"})}, {"small": runs}, "mine")
    text = page(made, {"small": None})
    assert "2 more failed runs" in text and text.count("3 more events") == 10


@pytest.mark.parametrize(("completeness", "failure"), [(None, None), (0.0, None), (None, {"scan": 0, "hangs": False})])
def test_a_scenario_that_is_too_short_to_judge_says_so(completeness: float | None, failure: dict | None) -> None:
    """Not where a state was owed, nor where the tracker failed and nothing is known."""
    run = {**RUN, "failure": failure, "metrics": {"completeness": completeness}}
    if failure:
        run |= {"failure": {**failure, "message": "?", "status": None, "stderr": ""}, "metrics": {}}
    (its,) = report({"small": Scenario(**SMALL)}, {"small": [run]}, "mine")["scenarios"]
    short = "8 scans judge no tracker: a state is owed from 60 s after a target is seen first; give more scans"
    assert (its["remark"] is not None) == (completeness is failure is None)
    assert its["remark"] is None or its["remark"].startswith(short)
