"""The report of all findings: one page of HTML without other files, and JSON."""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

from radar_service.study.plotting import number, svg_text
from radar_service.study.stability.figure import finding_figure
from radar_service.study.stability.finding import RESPONSES, Finding
from radar_service.terminal.output_files import make_folder

STYLE = """
body{font:16px/1.45 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#1b1b1b;background:#fff}
table{border-collapse:collapse;width:100%;font-size:14px}
a{color:#0b57b0}td,th{text-align:left;padding:.3em .6em;border-bottom:1px solid #ddd;vertical-align:top}
section{margin-top:2.6em}img{width:100%;max-width:830px;height:auto}h2{margin-bottom:.1em}p{margin:.4em 0}
@media(prefers-color-scheme:dark){a{color:#8ab8ff}body{color:#ddd;background:#161616}td,th{border-color:#333}}
"""
INTRODUCTION = (
    "Each study drives one parameter until a method fails. The table names the method, where it fails, and what the service "
    "uses or does instead. In a figure the dotted line is the limit of the error. The upright line is the boundary, where the "
    "method passes the limit."
)


def write_report(folder: Path, findings: Sequence[Finding]) -> None:
    """Writes stability.html and stability.json to `folder`, which it creates if necessary. Raises OSError."""
    make_folder(folder)
    (folder / "stability.json").write_text(json.dumps([finding.as_dict() for finding in findings], indent=1) + "\n")
    (folder / "stability.html").write_text(page(findings), encoding="utf-8")


def page(findings: Sequence[Finding]) -> str:
    """Returns the report as HTML."""
    count = Counter(finding.response for finding in findings)
    overview = "".join(f"<li>{count[key]}: {meaning}</li>" for key, meaning in RESPONSES.items() if count[key])
    rows = "".join(_row(k, finding) for k, finding in enumerate(findings))
    head = "<tr><th>region</th><th>method</th><th>where it fails</th><th>in the service</th></tr>"
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Where methods fail</title>"
        f"<meta name='viewport' content='width=device-width'><style>{STYLE}</style></head><body><h1>Where methods fail</h1>"
        f"<p>{INTRODUCTION}</p><p>{len(findings)} regions:</p><ul>{overview}</ul><table>{head}{rows}</table>"
        f"{''.join(_sections(findings))}</body></html>"
    )


def boundary_text(finding: Finding) -> str:
    """Returns where the method fails, in words."""
    if finding.boundary is None:
        return f"{finding.parameter.label}: nowhere from {number(finding.values[0])} to {number(finding.values[-1])}"
    return f"{finding.parameter.label} = {number(finding.boundary)}"


def _row(k: int, finding: Finding) -> str:
    region = f"<a href='#r{k}'>{escape(finding.name)}</a>"
    cells = (region, escape(finding.method), escape(boundary_text(finding)), escape(finding.instead))
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _sections(findings: Sequence[Finding]) -> Iterator[str]:
    for k, finding in enumerate(findings):
        yield (
            f"<section id='r{k}'><h2>{escape(finding.name)}</h2><p>Setup: {escape(finding.setup)}.</p>{_image(finding)}"
            f"<p>Method: {escape(finding.method)}. Limit: {escape(finding.limit_reason)}. "
            f"Where it fails: {escape(boundary_text(finding))}. {escape(_expected_text(finding))}</p>"
            f"<p><b>In the service: {escape(finding.instead)}.</b> {escape(finding.details)}</p></section>"
        )


def _expected_text(finding: Finding) -> str:
    expected = finding.expected
    return "" if expected.boundary is None else f"Expected: {number(expected.boundary)}; {expected.origin}."


def _image(finding: Finding) -> str:
    data = b64encode(svg_text(finding_figure(finding)).encode()).decode()
    return f"<img alt='{escape(f'{finding.name}: {finding.setup}', quote=True)}' src='data:image/svg+xml;base64,{data}'>"
