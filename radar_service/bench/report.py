"""The report of a test bench as one HTML page: a summary, the worst run of each scenario, verdicts with their sources."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from radar_service.bench.run_picture import run_picture
from radar_service.bench.scenario import PLOT_METRICS
from radar_service.terminal import html_page, write_file

UNITS = {"_m_s": "m/s", "_m": "m", "_deg": "degrees", "_kn": "kn", "_nm": "NM", "_min": "min", "_s": "s", "_h": "1/h"}
JUDGED = ("_1min", "_3min", "_median", "_95")  # when a metric of motion is judged
LEADING = {"gospa_m": "GOSPA [m]", "gospa_localisation_m": "distance", "gospa_missed_m": "missed", "gospa_false_m": "false"}
MAX_FAILURES = 5  # of a scenario that are listed
MAX_LISTED = 10  # failed runs of a scenario whose events are listed
MAX_SUMMARY = 3  # events of a scenario in the summary
WORDS = ("fail", "undecided", "no gross miss", "pass", "shown")  # the gravest first


def write_report(report: Mapping[str, Any], drawn: Mapping[str, Mapping[str, Any] | None], folder: Path) -> None:
    """Writes report.json and report.html. drawn: the run of each scenario that is drawn, or None. Raises OSError."""
    write_file(folder / "report.json", json.dumps(report, indent=1, allow_nan=False))
    write_file(folder / "report.html", page(report, drawn))


def page(report: Mapping[str, Any], drawn: Mapping[str, Mapping[str, Any] | None]) -> str:
    """Returns the page: the summary, then the scenarios, the gravest first."""
    return html_page(
        "bench/report.html", report=report, scenarios=gravest_first(report), drawn=drawn, run_picture=run_picture,
        word_of=word_of, missed_limits=_missed_limits, blind_words=blind_words, leading=LEADING,
        always_failed=always_failed, again_lines=again_lines, gravest_lines=_gravest_lines, failure_lines=failure_lines,
        number_of=number_of, bound_of=bound_of, unit_of=unit_of, max_listed=MAX_LISTED,
    )  # fmt: skip


def blind_words(report: Mapping[str, Any]) -> str:
    """Returns whether the tracker knew what is judged, as a sentence."""
    if not (blind := report["blind"]):
        return "Open runs: scenario and seed are known."
    return f"Blind runs, {'sealed' if blind['sealed'] else 'not sealed: truth stayed in memory'}; salt {blind['salt']}."


def gravest_first(report: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Returns the scenarios of a report, by their gravest verdict, then those with the most failed runs."""
    return sorted(report["scenarios"], key=lambda scenario: (WORDS.index(word_of(scenario)), -len(scenario["failed_runs"])))


def word_of(scenario: Mapping[str, Any]) -> str:
    """Returns the gravest verdict on a scenario of a report."""
    return min((verdict["word"] for verdict in scenario["verdicts"]), key=WORDS.index, default="shown")


def table(form: str, rows: Iterable[Sequence[object]]) -> list[str]:
    """Returns the lines of a table, the heads first. form: of a line, with the widths of its columns."""
    return [form.format(*row).rstrip() for row in rows]


def summary_table(report: Mapping[str, Any]) -> str:
    """Returns a table as text, the gravest scenario first: verdict, failed runs, the worst seed, and what went wrong in it."""
    form = "{:32.32} {:14} {:>12}" + " {:>9}" * len(LEADING) + " {:>10}"
    lines = table(form, [("scenario", "verdict", "failed runs", *LEADING.values(), "worst seed")])
    for scenario in gravest_first(report):
        failed, count = scenario["failed_runs"], len(scenario["seeds"])
        means = [number_of(scenario["metrics"].get(name)) for name in LEADING]
        seed = failed[0]["seed"] if failed else ""
        lines += table(form, [(scenario["name"], word_of(scenario), f"{len(failed)} of {count}", *means, seed)])
        lines += [f"    {line}" for line in _gravest_lines(scenario)]
    return "\n".join(lines) + "\n"


def _gravest_lines(scenario: Mapping[str, Any]) -> list[str]:
    """What went wrong in the worst run: how the tracker failed, and else some events."""
    if not scenario["failed_runs"]:
        return []
    worst = scenario["failed_runs"][0]
    failures = [_failure(failure) for failure in scenario["failures"] if failure["seed"] == worst["seed"]]
    return failures or [event_line(event) for event in worst["events"][:MAX_SUMMARY]]


def event_line(event: Mapping[str, Any]) -> str:
    """Returns an event in words."""
    scans = f"scan {event['scan']}" if event["scan"] == event["last"] else f"scans {event['scan']} to {event['last']}"
    return f"{scans}: {event['kind']}: {event['what']}"


def _missed_limits(run: Mapping[str, Any]) -> str:
    """Some of the limits that a failed run misses."""
    missed = [*run["missed"]]
    more = [f"{len(missed) - MAX_SUMMARY} more"] if len(missed) > MAX_SUMMARY else []
    return ", ".join(missed[:MAX_SUMMARY] + more)


def comparison(report: Mapping[str, Any], compared: Mapping[str, Any]) -> str:
    """Returns a table of the metrics of two reports, scenario by scenario, as text."""
    others = {scenario["name"]: scenario["metrics"] for scenario in compared["scenarios"]}
    rows = [
        (scenario["name"], metric, number_of(value), number_of(others.get(scenario["name"], {}).get(metric)))
        for scenario in report["scenarios"]
        for metric, value in scenario["metrics"].items()
    ]
    heads = ("scenario", "metric", report["tracker"][-14:], compared["tracker"][-14:])
    return "\n".join(table("{:32.32} {:26.26} {:>14} {:>14}", [heads, *rows])) + "\n"


def plot_table(report: Mapping[str, Any]) -> str:
    """Returns a table of the metrics of plots as text: means of the runs of each scenario, with their standard errors."""
    rows = [
        (scenario["name"], name, *(number_of(scenario[of].get(name)) for of in ("metrics", "standard_error")), unit_of(name))
        for scenario in report["scenarios"]
        for name in PLOT_METRICS
    ]
    heads = ("scenario", "metric", "mean", "standard error", "unit")
    return "\n".join(table("{:32.32} {:18} {:>10} {:>15} {}", [heads, *rows])) + "\n"


def verdict_table(report: Mapping[str, Any]) -> str:
    """Returns a table of the verdicts as text: a limit's metric, its value that 95 % of runs keep, bound, unit; then remarks."""
    rows = [
        (
            scenario["name"], verdict["metric"], number_of(verdict["value_95"]), bound_of(verdict),
            unit_of(verdict["metric"]), f"{verdict['failures']} of {verdict['runs']}", verdict["word"],
        )
        for scenario in report["scenarios"] if not always_failed(scenario) for verdict in scenario["verdicts"]
    ]  # fmt: skip
    heads = ("scenario", "metric", "95 % value", "limit", "unit", "missed", "verdict")
    lines = table("{:26.26} {:28.28} {:>10} {:>16} {:8} {:>9}  {}", [heads, *rows])
    lines += [f"{scenario['name']}: {sentence}" for scenario in report["scenarios"] if (sentence := always_failed(scenario))]
    lines += [f"{scenario['name']}: remark: {scenario['remark']}" for scenario in report["scenarios"] if scenario["remark"]]
    return "\n".join([*lines, *failure_lines(report), *again_lines(report)]) + "\n"


def again_lines(report: Mapping[str, Any]) -> list[str]:
    """Returns the command that makes the worst run again; nothing where none failed or the report is of such a run."""
    if " --seed " in report["sheet"]["again"]:
        return []
    failed = [run for scenario in gravest_first(report)[:1] for run in scenario["failed_runs"][:1]]
    return [f"the worst run again: {report['sheet']['again']} --seed {run['seed']}" for run in failed]


def always_failed(scenario: Mapping[str, Any]) -> str:
    """Returns a sentence in place of the limits of a scenario in whose every run the tracker failed; "" for others."""
    runs = len(scenario["failures"])
    all_failed = runs == len(scenario["seeds"]) > 0
    return (
        f"the tracker failed in all {runs} runs, and so misses all {len(scenario['verdicts'])} limits" if all_failed else ""
    )


def failure_lines(report: Mapping[str, Any]) -> list[str]:
    """Returns a line for each failed run, of the first MAX_FAILURES of a scenario, and how many more there are."""
    lines = []
    for scenario in report["scenarios"]:
        name, failures = scenario["name"], scenario["failures"]
        lines += [f"{name}, seed {failure['seed']}: {_failure(failure)}" for failure in failures[:MAX_FAILURES]]
        if (more := len(failures) - MAX_FAILURES) > 0:
            lines.append(f"{name}: {more} more failed runs")
    return lines


def _failure(failure: Mapping[str, Any]) -> str:
    """How a run failed: where, what is wrong, the exit status and the last line of the standard error."""
    at = "not started" if failure["scan"] is None else f"failed at scan {failure['scan']}"
    status = "" if failure["status"] is None else f"; exit status {failure['status']}"
    return f"{at}: {failure['message']}{status}" + (f"; it said: {failure['stderr']}" if failure["stderr"] else "")


def unit_of(metric: str) -> str:
    """Returns the unit of a metric, which its name ends with or has before what is judged as in `_1min`; empty for a number."""
    name = metric.rsplit("_", 1)[0] if metric.endswith(JUDGED) else metric
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")


def bound_of(verdict: Mapping[str, Any]) -> str:
    """Returns the bound of a limit in words."""
    return f"at most {verdict['maximum']:g}" if verdict["maximum"] is not None else f"at least {verdict['minimum']:g}"


def number_of(value: float | None) -> str:
    """Returns a value in words."""
    return "none" if value is None else f"{value:.4g}"
