"""The chart in words: a short list of results for each panel."""

from collections.abc import Sequence

from radar_service.study.chart.point import Point, pareto
from radar_service.study.plotting import duration, percent

BUDGET_DB = -40.0  # default error budget of the field
UNDER_WAY = " under way"
TITLES = {"field": "Signal chain", "power": "Samplers", "scattering": "Scattering models"}


def summary(points: Sequence[Point], real_time: float) -> dict[str, list[str]]:
    """Returns the lines of each panel that has points; real_time: time of one azimuth at the scene's rpm [s]."""
    field, power, models = ([p for p in points if p.panel == panel] for panel in TITLES)
    lines = {"field": _field(field, real_time), "power": _samplers(power), "scattering": [_model(p) for p in models]}
    return {panel: panel_lines for panel, panel_lines in lines.items() if panel_lines}


def summary_text(lines: dict[str, list[str]]) -> str:
    """Returns the summary as text: a title for each panel and one line for each result."""
    return "".join(f"{TITLES[panel]}\n" + "".join(f"- {line}\n" for line in lines[panel]) for panel in lines)


def _field(points: Sequence[Point], real_time: float) -> list[str]:
    moving = {p.preset.removesuffix(UNDER_WAY): p for p in points if p.preset and p.preset.endswith(UNDER_WAY)}
    lines = []
    for point in points:
        if point.preset and not point.preset.endswith(UNDER_WAY):
            other = moving.get(point.preset)
            lines.append(f"{point.preset}: {_error(point)}" + (f"; under way {_error(other)}" if other else ""))
    corrected = next((p for p in points if p.family == "integer-delay chirps" and not p.preset), None)
    if corrected is not None:
        lines.append(f"documented chain with corrected beam: {corrected.error_db or 0.0:.0f} dB")
    accurate = [p for p in pareto(points) if (p.error_db or 0.0) <= BUDGET_DB]
    if accurate:
        lines.append(f"fastest within {BUDGET_DB:g} dB: {_name(accurate[0])}, {_error(accurate[0])}")
    late = [p for p in points if p.seconds > real_time]
    if points:
        lines.append(f"slower than real time ({duration(real_time)}): {len(late)} of {len(points)} settings")
    return lines


def _samplers(points: Sequence[Point]) -> list[str]:
    lines = [f"{p.preset}: {_mean_and_spread(p)}, {duration(p.seconds)}" for p in points if p.preset]
    rays = [p for p in points if p.family.endswith("rays") and not p.preset and p.error_db is not None]
    if rays:
        best = min(rays, key=lambda p: (p.missed or 0.0, p.total_error_db or 0.0))
        lines.append(f"best rays, {_name(best)}: {_mean_and_spread(best)}, {duration(best.seconds)}")
    starved = [p for p in points if (p.missed or 0.0) > 0.5]
    if starved:
        lines.append(f"miss more than half of their targets: {len(starved)} of {len(points)} settings")
    return lines


def _model(point: Point) -> str:
    preset = f" = {point.preset}" if point.preset else ""
    return f"{point.family}, {point.setting}{preset}: {_mean_and_spread(point)}"


def _mean_and_spread(point: Point) -> str:
    missed = f", {percent(point.missed)} missed" if point.missed else ""
    if point.error_db is None or point.spread_db is None:
        return f"no target met{missed}"
    return f"mean {point.error_db:.2g} dB, spread {point.spread_db:.2g} dB{missed}"


def _name(point: Point) -> str:
    return f"{point.family} ({point.setting})"


def _error(point: Point) -> str:
    return f"{point.error_db or 0.0:.0f} dB in {duration(point.seconds)}"
