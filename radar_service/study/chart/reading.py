"""The chart in one paragraph, made from its numbers."""

from collections.abc import Sequence

from radar_service.study.chart.drawing import duration, rate
from radar_service.study.chart.labels import percent
from radar_service.study.chart.point import Point, pareto

BUDGET_DB = -40.0  # error of the field that a scene is allowed where nothing else is said
UNDER_WAY = " under way"


def reading(points: Sequence[Point], real_time: float) -> str:
    """What the points say: where each preset stands, what is fastest, most accurate, and too slow."""
    field, power, models = ([p for p in points if p.panel == panel] for panel in ("field", "power", "scattering"))
    said = _field(field, real_time) if field else []
    said += _samplers(power) if power else []
    return " ".join(said + (_models(models) if models else []))


def _field(points: Sequence[Point], real_time: float) -> list[str]:
    front, late = pareto(points), [p for p in points if p.seconds > real_time]
    good = [p for p in front if (p.error_db or 0.0) <= BUDGET_DB]
    chirps = next((p for p in points if p.family == "integer-delay chirps" and not p.preset), None)
    said = [
        "Signal chain, error of the field over a turn, the same echoes for all:",
        _listed([f"{p.preset} {_decibels(p)} in {duration(p.seconds)}" for p in points if _rests(p)]) + " an azimuth.",
    ]
    if chirps is not None:
        said.append(f"With its beam put right the documented chain errs by {_decibels(chirps)}.")
    moving = [p for p in points if p.preset and not _rests(p)]
    said.append(
        "What moves, the beam cut: "
        + _listed([f"{(p.preset or '').removesuffix(UNDER_WAY)} {_decibels(p)} in {duration(p.seconds)}" for p in moving])
        + "."
    )
    if good:
        said.append(
            f"Fastest within {BUDGET_DB:g} dB is {_name(good[0])}, {_decibels(good[0])} in {duration(good[0].seconds)};"
        )
    said.append(f"most accurate {_name(front[-1])}, {_decibels(front[-1])} in {duration(front[-1].seconds)}.")
    names = _listed([_name(p) for p in late]) if late else "none"
    return [*said, f"Slower than this scene's {rate(1 / real_time)} azimuths/s: {names}."]


def _rests(point: Point) -> bool:
    return point.preset is not None and not point.preset.endswith(UNDER_WAY)


def _samplers(points: Sequence[Point]) -> list[str]:
    said = ["Samplers, error of the mean power of targets and spread of a draw:"]
    said.append("; ".join(f"{p.preset} {_strays(p)} in {duration(p.seconds)}" for p in points if p.preset) + ".")
    rays = [p for p in points if p.family.endswith("rays") and not p.preset and p.height is not None]
    if rays:
        best = min(rays, key=lambda p: (p.missed or 0.0, p.height or 0.0))
        said.append(f"The best of the other rays, {_name(best)}: {_strays(best)} in {duration(best.seconds)}.")
    starved = [p for p in points if (p.missed or 0.0) > 0.5]
    if starved:
        said.append(f"{len(starved)} of {len(points)} settings miss a target more often than they meet it.")
    return said


def _models(points: Sequence[Point]) -> list[str]:
    each = [f"{p.family} ({p.setting}{f', as {p.preset}' if p.preset else ''}) {_strays(p)}" for p in points]
    return ["Scattering models, the same on a sphere, a cylinder, a plate and two corners:", "; ".join(each) + "."]


def _strays(point: Point) -> str:
    missed = f", {percent(point.missed)} missed" if point.missed else ""
    if point.error_db is None or point.spread_db is None:
        return f"no target met{missed}"
    return f"{point.error_db:.2g} and {point.spread_db:.2g} dB{missed}"


def _listed(words: Sequence[str]) -> str:
    return ", ".join(words)


def _name(point: Point) -> str:
    return f"{point.family} ({point.setting})"


def _decibels(point: Point) -> str:
    return f"{point.error_db or 0.0:.0f} dB"
