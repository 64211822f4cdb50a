"""The report of a test bench as one HTML page: a summary, the worst run of each scenario, verdicts with their sources."""

import html
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from radar_service.bench.run_picture import run_picture
from radar_service.terminal.extras import install_command
from radar_service.terminal.output_files import write_file

UNITS = {"_m_s": "m/s", "_m": "m", "_deg": "degrees", "_kn": "kn", "_nm": "NM", "_min": "min", "_s": "s"}  # by endings
JUDGED = ("_1min", "_3min", "_median")  # when a metric of motion is judged
MAX_FAILURES = 5  # of a scenario that are listed
MAX_LISTED = 10  # failed runs of a scenario whose events are listed
MAX_SUMMARY = 3  # events of a scenario in the summary
WORDS = ("fail", "undecided", "no gross miss", "pass", "shown")  # the gravest first

STYLE = (
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;margin:.6rem 0}td,th{border:1px solid #999;padding:.25rem .6rem;text-align:left}"
    ".pass{background:#d8f0d8}.fail{background:#f6d0d0}.undecided{background:#f7ecc4}.no{background:#d8f0d8}img{max-width:100%}"
)


def write_report(report: Mapping[str, Any], drawn: Mapping[str, Mapping[str, Any] | None], folder: Path) -> None:
    """Writes report.json and report.html. drawn: the run of each scenario that is drawn, or None. Raises OSError."""
    write_file(folder / "report.json", json.dumps(report, indent=1, allow_nan=False))
    write_file(folder / "report.html", page(report, drawn))


def page(report: Mapping[str, Any], drawn: Mapping[str, Mapping[str, Any] | None]) -> str:
    """Returns the page: the summary, then the scenarios, the gravest first."""
    ordered = gravest_first(report)
    sections = "".join(_section(scenario, drawn[scenario["name"]]) for scenario in ordered)
    return page_of(f"Test bench: {html.escape(report['tracker'])}", _summary(ordered) + sections)


def gravest_first(report: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Returns the scenarios of a report, by their gravest verdict, then those with the most failed runs."""
    return sorted(report["scenarios"], key=lambda scenario: (WORDS.index(word_of(scenario)), -len(scenario["failed_runs"])))


def word_of(scenario: Mapping[str, Any]) -> str:
    """Returns the gravest verdict on a scenario of a report."""
    return min((verdict["word"] for verdict in scenario["verdicts"]), key=WORDS.index, default="shown")


def summary_table(report: Mapping[str, Any]) -> str:
    """Returns a table as text, the gravest scenario first: verdict, failed runs, the worst seed, and what went wrong in it."""
    lines = [f"{'scenario':32} {'verdict':14} {'failed runs':>12} {'worst seed':>10}"]
    for scenario in gravest_first(report):
        failed, runs = scenario["failed_runs"], len(scenario["seeds"])
        seed = failed[0]["seed"] if failed else ""
        lines.append(
            f"{scenario['name'][:32]:32} {word_of(scenario):14} {f'{len(failed)} of {runs}':>12} {seed:>10}".rstrip()
        )
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


def _summary(scenarios: Sequence[Mapping[str, Any]]) -> str:
    heads = ("scenario", "verdict", "failed runs", "worst seed", "it misses", "what went wrong")
    return table_of(heads, "".join(map(_summary_row, scenarios)))


def _summary_row(scenario: Mapping[str, Any]) -> str:
    name, word, failed = html.escape(scenario["name"]), word_of(scenario), scenario["failed_runs"]
    seed, missed = _worst(failed[0]) if failed else ("", "")
    lines = "<br>".join(map(html.escape, _gravest_lines(scenario)))
    return (
        f'<tr><td><a href="#{name}">{name}</a></td><td class="{word.split()[0]}">{word}</td>'
        f"<td>{len(failed)} of {len(scenario['seeds'])}</td><td>{seed}</td><td>{missed}</td><td>{lines}</td></tr>"
    )


def _worst(run: Mapping[str, Any]) -> tuple[str, str]:
    """Of a failed run the seed and some of the limits that it misses, as HTML."""
    missed = [*run["missed"]]
    more = [f"{len(missed) - MAX_SUMMARY} more"] if len(missed) > MAX_SUMMARY else []
    return str(run["seed"]), ", ".join(missed[:MAX_SUMMARY] + more)


def table_of(heads: Sequence[str], rows: str) -> str:
    """Returns a table; heads and rows are HTML."""
    return f"<table><tr>{''.join(f'<th>{head}</th>' for head in heads)}</tr>{rows}</table>"


def page_of(title: str, content: str) -> str:
    """Returns a page; title and content are HTML."""
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
        f"<h1>{title}</h1>{content}</html>\n"
    )


def comparison(report: Mapping[str, Any], compared: Mapping[str, Any]) -> str:
    """Returns a table of the metrics of two reports, scenario by scenario, as text."""
    others = {scenario["name"]: scenario for scenario in compared["scenarios"]}
    lines = [f"{'scenario':32} {'metric':26} {report['tracker'][-14:]:>14} {compared['tracker'][-14:]:>14}"]
    for scenario in report["scenarios"]:
        second = others.get(scenario["name"], {"metrics": {}})["metrics"]
        for metric, value in scenario["metrics"].items():
            lines.append(
                f"{scenario['name'][:32]:32} {metric[:26]:26} {number_of(value):>14} {number_of(second.get(metric)):>14}"
            )
    return "\n".join(lines) + "\n"


def verdict_table(report: Mapping[str, Any]) -> str:
    """Returns a table of the verdicts as text: a limit's metric, its value that 95 % of runs keep, bound, unit; then remarks."""
    lines = [f"{'scenario':26} {'metric':28} {'95 % value':>10} {'limit':>16} {'unit':8} {'missed':>9}  verdict"]
    for scenario in report["scenarios"]:
        for verdict in scenario["verdicts"]:
            missed = f"{verdict['failures']} of {verdict['runs']}"
            lines.append(
                f"{scenario['name'][:26]:26} {verdict['metric'][:28]:28} {number_of(verdict['value_95']):>10} "
                f"{bound_of(verdict):>16} {unit_of(verdict['metric']):8} {missed:>9}  {verdict['word']}"
            )
    lines += [f"{scenario['name']}: remark: {scenario['remark']}" for scenario in report["scenarios"] if scenario["remark"]]
    lines += failure_lines(report)
    return "\n".join(lines) + "\n"


def failure_lines(report: Mapping[str, Any]) -> list[str]:
    """Returns a line for each failed run, of the first MAX_FAILURES of a scenario, and how many more there are."""
    lines = []
    for scenario in report["scenarios"]:
        failures = scenario["failures"]
        lines += [f"{scenario['name']}, seed {failure['seed']}: {_failure(failure)}" for failure in failures[:MAX_FAILURES]]
        lines += (
            [f"{scenario['name']}: {len(failures) - MAX_FAILURES} more failed runs"] if len(failures) > MAX_FAILURES else []
        )
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


def _section(scenario: Mapping[str, Any], run: Mapping[str, Any] | None) -> str:
    text = {key: html.escape(str(scenario[key])) for key in ("name", "question", "expected", "source")}
    remark = f"<p>Remark: {html.escape(scenario['remark'])}</p>" if scenario["remark"] else ""
    failed = "".join(f"<li>{html.escape(line)}</li>" for line in failure_lines({"scenarios": [scenario]}))
    metrics = "".join(
        f"<tr><td>{name}</td><td>{number_of(scenario['metrics'][name])}</td>"
        f"<td>{number_of(scenario['percentile_95'][name])}</td></tr>"
        for name in scenario["metrics"]
    )
    limits = "".join(map(_verdict_row, scenario["verdicts"]))
    return (
        f'<h2 id="{text["name"]}">{text["name"]}</h2><p>{text["question"]} Expected: {text["expected"]} ({text["source"]})</p>'
        f"{_picture(run)}{remark}<ul>{failed}</ul>{_events(scenario['failed_runs'])}"
        f"{table_of(('limit', '95 % value', 'runs that miss it', 'verdict', 'source'), limits)}"
        f"<details><summary>all metrics</summary>{table_of(('metric', 'mean', '95th percentile'), metrics)}</details>"
    )


def _picture(run: Mapping[str, Any] | None) -> str:
    """The picture of a run; nothing without one."""
    if run is None:
        return ""
    alt = f"seed {run['seed']}: plots, tracks and targets over the PPI of the last scan; distances over time"
    return image(alt, run_picture(run))


def image(alt: str, png: str) -> str:
    """Returns a picture as HTML; where matplotlib was absent, and `png` is empty, how to install it."""
    if png:
        return f'<img alt="{html.escape(alt)}" src="data:image/png;base64,{png}">'
    return f"<p>For a picture here, install the extra pictures: <code>{install_command('pictures')}</code></p>"


def _events(failed: Sequence[Mapping[str, Any]]) -> str:
    """The events of each failed run; those of the worst one are unfolded."""
    runs = "".join(_run_events(run, "" if k else " open") for k, run in enumerate(failed[:MAX_LISTED]))
    return runs + (f"<p>{len(failed) - MAX_LISTED} more failed runs</p>" if len(failed) > MAX_LISTED else "")


def _run_events(run: Mapping[str, Any], is_open: str) -> str:
    more = run["event_count"] - len(run["events"])
    rows = "".join(_event_row(event) for event in run["events"])
    missed = ", ".join(f"{metric} {number_of(value)}" for metric, value in run["missed"].items())
    return (
        f"<details{is_open}><summary>seed {run['seed']} misses {missed}</summary>"
        f"{table_of(('scans', 'target', 'event', 'what'), rows)}{f'<p>{more} more events</p>' if more else ''}</details>"
    )


def _event_row(event: Mapping[str, Any]) -> str:
    scans = f"{event['scan']}" if event["scan"] == event["last"] else f"{event['scan']} to {event['last']}"
    bodies = ", ".join(html.escape(body) for body in (event["body"], event["other"]) if body)
    return f"<tr><td>{scans}</td><td>{bodies}</td><td>{event['kind']}</td><td>{html.escape(event['what'])}</td></tr>"


def _verdict_row(verdict: Mapping[str, Any]) -> str:
    limit = f"{html.escape(verdict['metric'])} {bound_of(verdict)} {unit_of(verdict['metric'])}"
    return (
        f"<tr><td>{limit}</td><td>{number_of(verdict['value_95'])}</td>"
        f'<td>{verdict["failures"]} of {verdict["runs"]}</td><td class="{verdict["word"].split()[0]}">{verdict["word"]}</td>'
        f"<td>{html.escape(verdict['source'])}</td></tr>"
    )
