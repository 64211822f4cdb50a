"""The chart in one paragraph, made from its numbers."""

from collections.abc import Sequence

from radar_service.study.chart.drawing import duration, percent, rate
from radar_service.study.chart.point import Point, pareto


def reading(points: Sequence[Point], real_time: float) -> str:
    """What the points say: which presets stand where, what is fastest, most accurate, and too slow."""
    field, power = ([p for p in points if p.panel == panel] for panel in ("field", "power"))
    return " ".join([*(_field(field, real_time) if field else []), *(_power(power) if power else [])])


def _field(points: Sequence[Point], real_time: float) -> list[str]:
    front = pareto(points)
    fast, good = front[0], front[-1]
    late = [p for p in points if p.seconds > real_time]
    documented = next(p for p in points if p.family == "integer-delay chirps")
    said = [
        f"Signal chain, the same echoes for all: the fastest is {_name(fast)}, {_decibels(fast)} in "
        f"{duration(fast.seconds)} an azimuth, the most accurate {_name(good)}, {_decibels(good)} in "
        f"{duration(good.seconds)}.",
        f"The documented integer-delay chirps err by {_decibels(documented)} and take {duration(documented.seconds)}.",
    ]
    for preset in (p for p in points if p.preset):
        ratio, gained = documented.seconds / preset.seconds, (documented.error_db or 0.0) - (preset.error_db or 0.0)
        said.append(
            f"The preset {preset.preset} is {_name(preset)}: {_decibels(preset)} at {rate(1 / preset.seconds)} azimuths/s, "
            f"{ratio:.3g} times as fast as those and {gained:.0f} dB better{'' if preset in front else ', off the front'}."
        )
    said.append(
        f"Slower than this scene's {rate(1 / real_time)} azimuths/s: "
        + (", ".join(f"{_name(p)}" for p in late) if late else "none") + "."
    )  # fmt: skip
    return said


def _power(points: Sequence[Point]) -> list[str]:
    said = []
    for p in points:
        if p.preset:
            said.append(f"As a sampler, {p.preset} ({_name(p)}) {_strays(p)} at {duration(p.seconds)} an azimuth.")
    rays = [p for p in points if p.family.endswith("rays") and not p.preset and p.height is not None]
    if rays:
        best = min(rays, key=lambda p: (p.missed or 0.0, p.height or 0.0))
        said.append(f"Of the other rays the best, {_name(best)}, {_strays(best)} at {duration(best.seconds)}.")
    starved = [p for p in points if (p.missed or 0.0) > 0.5]
    if starved:
        said.append(f"{len(starved)} of {len(points)} settings miss a target more often than they meet it.")
    return said


def _strays(point: Point) -> str:
    missed = f"misses {percent(point.missed or 0.0)} of its looks"
    if point.error_db is None or point.spread_db is None:
        return f"{missed}: it never met a target"
    return f"errs by {point.error_db:.2g} dB in the mean with a spread of {point.spread_db:.2g} dB a draw and {missed}"


def _name(point: Point) -> str:
    return f"{point.family} ({point.setting})"


def _decibels(point: Point) -> str:
    return f"{point.error_db or 0.0:.0f} dB"
