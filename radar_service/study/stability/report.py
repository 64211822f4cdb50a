"""All findings as one page of HTML, complete in itself, and as JSON."""

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

from radar_service.study.stability.finding import VERDICTS, Finding
from radar_service.study.stability.plot import legend, number, svg

STYLE = """
body{font:16px/1.45 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#1b1b1b;background:#fff}
table{border-collapse:collapse;width:100%;font-size:14px}
a{color:#0b57b0}td,th{text-align:left;padding:.3em .6em;border-bottom:1px solid #ddd;
vertical-align:top}section{margin-top:2.6em}svg[role]{width:100%;max-width:760px;height:auto;font:12px system-ui,sans-serif}
.grid{stroke:#e4e4e4}.limit{stroke:#888;stroke-dasharray:2 2}.boundary{stroke:#000;stroke-width:1.5}
.legend span{margin-right:1.4em;white-space:nowrap}.legend svg{vertical-align:middle}h2{margin-bottom:.1em}p{margin:.4em 0}
.verdict{font-weight:600}@media(prefers-color-scheme:dark){a{color:#8ab8ff}body{color:#ddd;background:#161616}svg text{fill:#ddd}
.grid{stroke:#333}.boundary{stroke:#fff}td,th{border-color:#333}}
"""
INTRODUCTION = (
    "Every method and model was driven to where it fails. In a chart the dotted line is the error that counts as failing, "
    "the upright line where the first curve passes it. Below it stands what the service does there."
)


def write_report(folder: Path, findings: Sequence[Finding]) -> None:
    """stability.html and stability.json in `folder`, which is made where it is not there. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "stability.json").write_text(json.dumps([finding.as_dict() for finding in findings], indent=1) + "\n")
    (folder / "stability.html").write_text(page(findings), encoding="utf-8")


def page(findings: Sequence[Finding]) -> str:
    """The report as HTML."""
    count = Counter(finding.verdict for finding in findings)
    summary = ", ".join(f"{count[verdict]} {verdict}" for verdict in VERDICTS if count[verdict])
    rows = "".join(_row(k, finding) for k, finding in enumerate(findings))
    head = "<tr><th>region</th><th>what was driven</th><th>where it fails</th><th>what the service does</th></tr>"
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Where it breaks</title>"
        f"<meta name='viewport' content='width=device-width'><style>{STYLE}</style></head><body><h1>Where it breaks</h1>"
        f"<p>{INTRODUCTION}</p><p>{len(findings)} regions: {summary}.</p><table>{head}{rows}</table>"
        f"{''.join(_sections(findings))}</body></html>"
    )


def boundary_text(finding: Finding) -> str:
    """Where it fails, in words; it may hold SVG's raised exponents, see `plain`."""
    if finding.boundary is None:
        return f"nowhere from {plain(finding.places[0])} to {plain(finding.places[-1])}, {escape(finding.driven.label)}"
    return f"{escape(finding.driven.label)} = {plain(finding.boundary)}"


def plain(value: float) -> str:
    """A number in HTML."""
    return number(value).replace("<tspan dy='-5' font-size='9'>", "<sup>").replace("</tspan>", "</sup>")


def _row(k: int, finding: Finding) -> str:
    region, service = f"<a href='#r{k}'>{escape(finding.name)}</a>", f"<span class='verdict'>{finding.verdict}</span>"
    cells = (region, escape(finding.method), boundary_text(finding), service)
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _sections(findings: Sequence[Finding]) -> Iterator[str]:
    for k, finding in enumerate(findings):
        yield (
            f"<section id='r{k}'><h2>{escape(finding.name)}</h2><p>{escape(finding.method)}</p>"
            f"{svg(finding)}{legend(finding)}"
            f"<p>{'Fails nowhere' if finding.boundary is None else 'Fails at'} "
            f"{boundary_text(finding).removeprefix('nowhere ')} ({escape(finding.why)}).</p>"
            f"<p><span class='verdict'>The service: {finding.verdict}.</span> {escape(finding.service)}</p></section>"
        )
