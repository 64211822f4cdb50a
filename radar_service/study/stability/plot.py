"""A finding drawn as a small chart in SVG: curves told apart by colour (Okabe and Ito 2008), dash and mark."""

from html import escape

import numpy as np

from radar_service.study.stability.finding import Axis, Finding
from radar_service.trace.line_of_sight import Floats

WIDTH, HEIGHT = 640, 300
LEFT, RIGHT, TOP, BOTTOM = 70, 30, 14, 48  # px about the frame
COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#a07800", "#444444")
DASHES = ("", "7 4", "2 3", "9 3 2 3", "1 3", "12 4")
MOST_TICKS = 8


class _Scale:
    """Values of one axis to pixels."""

    def __init__(self, axis: Axis, values: Floats, low_px: float, high_px: float) -> None:
        shown = values[values > 0] if axis.log else values
        low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.1, 1.0)
        if low == high:
            low, high = (low / 10.0, high * 10.0) if axis.log else (low - 1.0, high + 1.0)
        pad = 0.0 if axis.log else 0.04 * (high - low)
        self._log, self._low, self._high = axis.log, low - pad, high + pad
        self._px = (low_px, high_px)

    def __call__(self, value: float) -> float:
        low, high = self._raw(self._low), self._raw(self._high)
        share = (self._raw(max(value, self._low)) - low) / (high - low)
        return self._px[0] + min(share, 1.0) * (self._px[1] - self._px[0])

    def _raw(self, value: float) -> float:
        return float(np.log10(value)) if self._log else value

    def holds(self, value: float) -> bool:
        return self._low <= value <= self._high

    def ticks(self) -> list[float]:
        if self._log:
            first, last = int(np.ceil(self._raw(self._low) - 1e-9)), int(np.floor(self._raw(self._high) + 1e-9))
            return [10.0**k for k in range(first, last + 1, 1 + (last - first) // MOST_TICKS)]
        span = self._high - self._low
        step = 10.0 ** np.floor(np.log10(span / 2.0))
        step *= next(m for m in (1, 2, 5, 10, 20, 50) if span / (step * m) <= MOST_TICKS)
        return [float(step * k) for k in range(int(np.ceil(self._low / step)), int(np.floor(self._high / step)) + 1)]


def number(value: float) -> str:
    """A number as a person writes it, three digits."""
    if value == 0.0 or 1e-4 <= abs(value) < 1e6:
        return f"{float(f'{value:.3g}'):,.10g}"
    mantissa, exponent = f"{value:.2e}".split("e")
    short = f"{float(mantissa):g}"
    power = f"10<tspan dy='-5' font-size='9'>{int(exponent)}</tspan>"
    return power if short == "1" else f"{short} x {power}"


def svg(finding: Finding) -> str:
    """The chart of a finding as an SVG element."""
    values = np.array([curve.values for curve in finding.curves])
    x = _Scale(finding.driven, np.array(finding.places), LEFT, WIDTH - RIGHT)
    y = _Scale(finding.measured, np.append(values.ravel(), _shown_limit(finding)), HEIGHT - BOTTOM, TOP)
    parts = [*_frame(finding, x, y), *_marks(finding, x, y)]
    for k, curve in enumerate(finding.curves):
        spots = [f"{x(a):.1f},{y(b):.1f}" for a, b in zip(finding.places, curve.values, strict=True)]
        style = f"fill='none' stroke='{COLOURS[k]}' stroke-width='2' stroke-dasharray='{DASHES[k]}'"
        parts.append(f"<polyline points='{' '.join(spots)}' {style}/>")
    title = escape(f"{finding.name}: {finding.method}")
    body = "".join(parts)
    return f"<svg viewBox='0 0 {WIDTH} {HEIGHT}' role='img' aria-label='{title}'>{body}</svg>"


def legend(finding: Finding) -> str:
    """What the curves are, in HTML."""
    entries = []
    for k, curve in enumerate(finding.curves):
        line = f"stroke='{COLOURS[k]}' stroke-width='3' stroke-dasharray='{DASHES[k]}'"
        swatch = f"<svg width='34' height='10'><line x1='0' y1='5' x2='34' y2='5' {line}/></svg>"
        entries.append(f"<span>{swatch} {escape(curve.name)}</span>")
    return f"<p class='legend'>{''.join(entries)}</p>"


def _shown_limit(finding: Finding) -> Floats:
    show = finding.limit > 0 or not finding.measured.log
    return np.array([finding.limit] if show else [])


def _frame(finding: Finding, x: _Scale, y: _Scale) -> list[str]:
    parts = []
    for tick in x.ticks():
        parts.append(f"<line class='grid' x1='{x(tick):.1f}' y1='{TOP}' x2='{x(tick):.1f}' y2='{HEIGHT - BOTTOM}'/>")
        parts.append(f"<text x='{x(tick):.1f}' y='{HEIGHT - BOTTOM + 17}' text-anchor='middle'>{number(tick)}</text>")
    for tick in y.ticks():
        parts.append(f"<line class='grid' x1='{LEFT}' y1='{y(tick):.1f}' x2='{WIDTH - RIGHT}' y2='{y(tick):.1f}'/>")
        parts.append(f"<text x='{LEFT - 6}' y='{y(tick) + 4:.1f}' text-anchor='end'>{number(tick)}</text>")
    middle = (LEFT + WIDTH - RIGHT) / 2
    label = escape(finding.measured.label)
    parts.append(f"<text x='{middle}' y='{HEIGHT - 8}' text-anchor='middle'>{escape(finding.driven.label)}</text>")
    spot = f"x='14' y='{(TOP + HEIGHT - BOTTOM) / 2}'"
    turn = f"transform='rotate(-90 14 {(TOP + HEIGHT - BOTTOM) / 2})'"
    parts.append(f"<text {spot} {turn} text-anchor='middle'>{label}</text>")
    return parts


def _marks(finding: Finding, x: _Scale, y: _Scale) -> list[str]:
    parts = []
    if y.holds(finding.limit):
        at = y(finding.limit)
        parts.append(f"<line class='limit' x1='{LEFT}' y1='{at:.1f}' x2='{WIDTH - RIGHT}' y2='{at:.1f}'/>")
    if finding.boundary is not None and x.holds(finding.boundary):
        at = x(finding.boundary)
        parts.append(f"<line class='boundary' x1='{at:.1f}' y1='{TOP}' x2='{at:.1f}' y2='{HEIGHT - BOTTOM}'/>")
    return parts
