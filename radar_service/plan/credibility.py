"""What of a scene was held against published figures (docs/believed.md), by a table, and what was not."""

import tomllib
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from radar_service.records.plan_item import PlanItem
from radar_service.scattering.models import scattering_model
from radar_service.world.body import Body
from radar_service.world.materials import is_land, is_metal
from radar_service.world.scene import Scene

TABLE = Path(__file__).with_name("believed.toml")


@cache
def held() -> dict[str, Any]:
    """Returns the table: rows by phenomenon, and those outside of their tolerance."""
    return tomllib.loads(TABLE.read_text(encoding="utf-8"))


def credibility(scene: Scene, effects: Sequence[PlanItem], bodies: Sequence[PlanItem]) -> tuple[str, ...]:
    """Returns a line for each phenomenon that is modelled and was held against published figures, and one for all others.

    effects, bodies: what the plan says of effects, and of each body of the scene.
    """
    outside, rows, others = held()["outside"], held()["rows"], list[str]()
    lines = []
    for name in dict.fromkeys(_phenomena(scene, effects, bodies)):
        if name not in rows:
            others.append(name)
            continue
        beyond = [row for row in rows[name] if row in outside]
        inside = f"{len(rows[name]) - len(beyond)} of {len(rows[name])} published figures inside"
        lines.append(f"{name}: {inside}" + (f", outside {', '.join(beyond)}" if beyond else ""))
    return (*lines, *([f"held against nothing published: {', '.join(others)}"] if others else []))


def _phenomena(scene: Scene, effects: Sequence[PlanItem], bodies: Sequence[PlanItem]) -> Iterator[str]:
    """Yields what is modelled: effects, and kinds of bodies."""
    if scene.radar.scales:
        yield "set that is sold"
    for item in effects:
        if item.modelled:
            yield item.what.removesuffix(", heave")
    for body, item in zip(scene.bodies, bodies, strict=True):
        if item.modelled:
            yield _kind(body)


def _kind(body: Body) -> str:
    """Returns the kind of a body, as far as figures were published of it."""
    if body.reflector is not None:
        return "radar reflectors"
    if body.mesh is None or body.rcs is not None:
        return "cross-sections as declared"
    if is_land(body):
        return "land"
    if not scattering_model(body).by_aspect or not body.is_vessel:
        return "other bodies"
    return "metal ships" if is_metal(body.material) else "boats"
