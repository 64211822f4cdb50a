"""The plan of a scene at a fidelity: what is modelled, what is not and why, with errors, costs and what backs its figures.

A pace is kept on one machine; the error budget of the result pins it, and gives the same bytes anywhere.
"""

import json
import math
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.engine.land_rows import is_diffuse_land
from radar_service.engine.preparation import rests
from radar_service.numerics import arithmetic
from radar_service.plan.body_errors import aspects_db, body_error
from radar_service.plan.budget import STEPS_DB, ErrorBudget
from radar_service.plan.cost_model import Costs, Counts, EngineStatistics, realtime_factor
from radar_service.plan.effects import effects
from radar_service.plan.settings_search import (
    all_rests,
    fidelity_for,
    moving_db,
    multipath_db,
    relative_cost,
    resting_db,
)
from radar_service.radar import Radar, remedies
from radar_service.records import Fidelity, PlanItem
from radar_service.scattering import Conditions, scattering_model
from radar_service.world import Body, Scene, is_land, is_metal

METHODS = {"at rest": resting_db, "moving": moving_db}
ASPECTS = "of aspects, moving"
STAGE = {"looks": "visibility"}  # as text; the other costs have the names of their keys
NOTHING_KNOWN = EngineStatistics()
ROUNDING = 1.02  # of an error budget: more is beyond it
TABLE = Path(__file__).with_name("believed.toml")
NEVER_VISIBLE = "never visible: other bodies at rest occlude it, or it is out of range"
WORTH_TRYING = 0.8  # of the pace: a budget whose estimate reaches this share of it is planned and measured


@dataclass(frozen=True)
class Plan:
    """All choices for one scene at one fidelity.

    fidelity: its name.
    arithmetic: of the process that made the plan.
    choices: one item for each effect and body.
    settings: the fields of the Fidelity.
    field_db: predicted relative field errors [dB]: at rest, moving, of sea reflection, of aspects, of shadows that pass
        metal.
    counts: what the engine computes; None before it is prepared.
    costs: CPU times per azimuth [us]; None before they are measured.
    realtime_factor: simulated seconds per second of one thread of this machine; None without costs.
    caveats: a sentence for each requirement that the plan cannot meet.
    believed: what of the scene was held against published figures, a line each.
    """

    fidelity: str
    arithmetic: str
    choices: tuple[PlanItem, ...]
    settings: dict[str, Any]
    field_db: dict[str, float]
    counts: Counts | None
    costs: Costs | None
    realtime_factor: float | None
    caveats: tuple[str, ...]
    believed: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON: infinities and NaN become None."""
        plain: dict[str, Any] = json.loads(json.dumps(asdict(self)), parse_constant=lambda _: None)
        return plain

    def __str__(self) -> str:
        width = max((len(choice.what) for choice in self.choices), default=0)
        prices = [choice.price() for choice in self.choices]
        price_width = max((len(price) for price in prices), default=0)
        pairs = zip(self.choices, prices, strict=True)
        lines = [f"{'+' if c.modelled else '-'} {c.what:<{width}}  {price:<{price_width}}  {c.how}" for c, price in pairs]
        caveats = [f"! {caveat}" for caveat in self.caveats]
        return "\n".join([*self._head(), *lines, *caveats, *(f"= {line}" for line in self.believed)])

    def _head(self) -> list[str]:
        budget = self.settings["error_db"]
        field = "" if not budget else f" (error budget {budget:g} dB, field {ErrorBudget(budget).field_db:.0f} dB)"
        return [f"fidelity {self.fidelity}{field}", f"arithmetic: {self.arithmetic}", *self._predicted()]

    def _predicted(self) -> list[str]:
        """Errors, counts and costs, a line each."""
        lines = []
        if self.field_db:
            errors = ", ".join(f"{error:.0f} dB {what}" for what, error in self.field_db.items())
            lines.append(f"predicted field error: {errors}")
        if self.counts is not None:
            lines.append(_counted(self.counts))
        if self.costs is not None and self.realtime_factor is not None:
            costs = {STAGE.get(name, name): cost for name, cost in self.costs.by_stage().items()}
            parts = ", ".join(f"{name} {cost:.3g}" for name, cost in costs.items() if cost >= 0.5)
            factor = f"{self.realtime_factor:.3g} x real time on one thread here"
            lines.append(f"cost: {self.costs.total:.3g} us per azimuth ({parts}), {factor}")
        return lines


def _counted(counts: Counts) -> str:
    """The counts of an engine as text."""
    once = f"{counts.scatterers} scatterers; once {counts.resting_echoes} echoes and {counts.set_up_rays} rays"
    first = f"the first {counts.moving_echoes} echoes and {counts.look_rays} rays"
    shadows = f", {counts.shadowed_echoes} in shadow" if counts.shadowed_echoes else ""
    updates = f"{counts.looks_per_scan:.3g} visibility updates per scan, {first}{shadows}"
    return f"{once}; {updates}; {counts.transform_samples} FFT samples per profile"


def plan_for(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics = NOTHING_KNOWN) -> Plan:
    """The plan of a scene at a fidelity, as far as its statistics are known."""
    errors, items = _field_errors(scene, fidelity), bodies(scene, fidelity, statistics)
    phenomena, costs = effects(scene, fidelity, statistics), statistics.costs
    return Plan(
        fidelity.name,
        arithmetic(),
        (*phenomena, *items),
        asdict(fidelity),
        errors,
        statistics.counts,
        costs,
        None if costs is None else realtime_factor(scene, costs),
        (*_caveats(scene, fidelity, errors), *_weak_bodies(fidelity, items)),
        credibility(scene, phenomena, items),
    )


def _field_errors(scene: Scene, fidelity: Fidelity) -> dict[str, float]:
    """Predicted relative field errors [dB] by their cause; none for `documented`."""
    errors: dict[str, float] = {}
    if fidelity.engine == "corrected":
        errors["at rest"] = resting_db(scene.radar, fidelity)
        if not all_rests(scene):
            errors["moving"] = moving_db(scene.radar, fidelity)
        others = {"of sea reflection, moving": multipath_db(scene, fidelity), ASPECTS: aspects_db(scene)}
        errors |= {what: error for what, error in others.items() if math.isfinite(error)}
    return errors


def _caveats(scene: Scene, fidelity: Fidelity, errors: dict[str, float]) -> list[str]:
    """A sentence for each method that cannot keep the error budget."""
    if not fidelity.error_db or not errors:
        return []
    budget = ErrorBudget(fidelity.error_db)
    limit = budget.method_db
    aspects = errors.get(ASPECTS, -math.inf)
    turning = f"the error budget cannot be kept for metal that turns fast: its field errs by up to {aspects:.0f} dB"
    return [turning] * (aspects > budget.field_db) + [
        f"the error budget cannot be kept: it allows methods a field error of {limit:.0f} dB, and with the best settings "
        f"it is {error:.0f} dB {what}: {_advice(scene, METHODS[what], budget)}"
        for what, error in errors.items()
        if what in METHODS and error > limit
    ]


def _weak_bodies(fidelity: Fidelity, items: list[PlanItem]) -> list[str]:
    """A sentence where bodies exceed the error budget at some time of the run."""
    errors = {item.what: item.power_db for item in items if item.modelled and item.power_db is not None}
    over = {what: error for what, error in errors.items() if error > fidelity.error_db * ROUNDING}
    if not over or not fidelity.error_db:
        return []
    worst = max(over, key=lambda what: over[what])
    others = f", and {len(over) - 1} other{'s' if len(over) > 2 else ''}" if len(over) > 1 else ""
    return [
        f"over the run the mean power of {worst}{others} errs by more than the error budget, by {over[worst]:.2g} dB at most"
    ]


def _advice(scene: Scene, method_db: Callable[[Radar, Fidelity], float], budget: ErrorBudget) -> str:
    """What lets the best settings of a method keep the budget."""

    def best_db(changed: Radar) -> float:
        return method_db(changed, fidelity_for(replace(scene, radar=changed), budget))

    helpful = remedies(scene.radar, best_db, budget.method_db)
    return ", or ".join(text for text in (helpful, "allow a larger error") if text)


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


def bodies(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[PlanItem]:
    """The items of all bodies, in their order."""
    costs = _microseconds(scene, fidelity, statistics)
    return [_body(key, scene, fidelity, statistics, costs[key]) for key in range(len(scene.bodies))]


def _microseconds(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[float | None]:
    """CPU time of each body while the radar turns [us]: moving bodies share that of moving echoes by their echoes, and those
    whose echoes depend on aspect that of their aspects."""
    if statistics.costs is None or statistics.bodies is None:
        return [None] * len(scene.bodies)
    moving = np.array([not rests(body, scene, fidelity) for body in scene.bodies], dtype=np.bool_)
    by_aspect = np.array([scattering_model(body).by_aspect for body in scene.bodies], dtype=np.bool_)
    echoes, times = np.where(moving, statistics.bodies.echoes, 0), np.zeros(len(scene.bodies))
    for cost, count in ((statistics.costs.moving, echoes), (statistics.costs.aspects, echoes * by_aspect)):
        times += count * (cost / max(int(count.sum()), 1))
    return [float(time) for time in times]


def _body(key: int, scene: Scene, fidelity: Fidelity, statistics: EngineStatistics, microseconds: float | None) -> PlanItem:
    body = scene.bodies[key]
    what = f"body {body.name}"
    if fidelity.engine == "documented":
        how = "one hit per azimuth" if body.mesh is None else f"rays against {len(body.mesh.faces)} triangles"
        return PlanItem(what, True, how)
    if key in statistics.culled:
        culled = statistics.culled[key]
        shadow = "; still occludes what is behind it" if culled.occludes else ""
        return PlanItem(what, False, culled.reason + shadow, culled.error_db)
    if statistics.bodies is not None and rests(body, scene, fidelity) and not statistics.bodies.echoes[key]:
        return PlanItem(what, False, NEVER_VISIBLE, 0.0, microseconds=0.0)
    model = scattering_model(body, fidelity.sampler)
    scatterers = None if statistics.bodies is None else int(statistics.bodies.scatterers[key])
    conditions = Conditions.of_scene(scene, fidelity, scatterers)
    how = model.description(body, conditions, _computed(body, scene, fidelity, statistics))
    error = body_error(body, scene, fidelity, scatterers)
    text = "; ".join((how + _counted_of(body, key, statistics), *error.remarks))
    return PlanItem(what, True, text, error.power_db, error.field_db, microseconds)


def _computed(body: Body, scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> str:
    """How often a body is computed, as text."""
    if rests(body, scene, fidelity):
        return "computed once"
    on_grid = statistics.land_border is not None and is_diffuse_land(body, fidelity)
    return "computed once a passage" if on_grid else "computed at each azimuth"


def _counted_of(body: Body, key: int, statistics: EngineStatistics) -> str:
    """Scatterers and echoes of a body as text, once they are known."""
    if statistics.bodies is None:
        return ""
    scatterers, echoes = int(statistics.bodies.scatterers[key]), int(statistics.bodies.echoes[key])
    if scatterers == 1:
        size = "a point" if body.mesh is None else "smaller than a resolution cell: a point"
        return f"; {size}" if echoes else f"; {size}, not visible now"
    return f"; {scatterers} points, {echoes} echoes" if scatterers else f"; {echoes} echoes"


def plan_in_time(
    scene: Scene, factor: float, planned: Callable[[Fidelity], Plan], requested: ErrorBudget | None = None
) -> Plan:
    """The plan of the most accurate fidelity that runs `factor` simulated seconds per second on one thread here.

    planned: returns the plan of the scene at a fidelity, with measured costs.
    requested: the error budget to prefer. If it is too slow, a larger one replaces it, and a caveat says so.
    Where no budget is fast enough, the largest one is planned, and a caveat says so.
    """
    first = planned(fidelity_for(scene, requested or ErrorBudget()))
    if requested is not None and _is_fast_enough(first, factor):
        return first
    steps = [step for step in STEPS_DB if requested is None or step > requested.target_db]
    tried = [] if requested is None else [first]
    for step in steps:
        if step != steps[-1] and estimated_factor(scene, first, step) < WORTH_TRYING * factor:
            continue
        tried.append(planned(fidelity_for(scene, ErrorBudget(step))))
        if _is_fast_enough(tried[-1], factor):
            break
    return _with_caveats(tried[-1], factor, () if requested is None else tried[:1])


def estimated_factor(scene: Scene, known: Plan, step: float) -> float:
    """The pace at another error budget `step` [dB], estimated from the measured costs of a known plan.

    Gridding costs grow with scatterers and beam extent, visibility updates with scatterers and their number per scan. Physical
    optics is evaluated as the beam passes, as often whatever the budget.
    """
    assert known.costs is not None
    old, new = (fidelity_for(scene, ErrorBudget(budget)) for budget in (known.settings["error_db"], step))
    scatterers = new.scatterers_per_cell / old.scatterers_per_cell
    gridding = scatterers * relative_cost(scene.radar, new) / relative_cost(scene.radar, old)
    updates = scatterers * old.visibility_step / new.visibility_step
    changed = replace(known.costs, moving=known.costs.moving * gridding, looks=known.costs.looks * updates)
    return realtime_factor(scene, changed)


def _is_fast_enough(plan: Plan, factor: float) -> bool:
    assert plan.realtime_factor is not None
    return plan.realtime_factor >= factor


def _with_caveats(plan: Plan, factor: float, refused: Sequence[Plan]) -> Plan:
    """The plan with caveats about its pace, and about the plans refused as too slow."""
    caveats, budget = list(plan.caveats), plan.settings["error_db"]
    for slow in refused:
        caveats.append(
            f"an error budget of {slow.settings['error_db']:g} dB cannot run at {factor:g} x real time on this machine: "
            f"it would run at {slow.realtime_factor:.3g}"
        )
    if not _is_fast_enough(plan, factor):
        caveats.append(
            f"{factor:g} x real time is not possible on this machine: {plan.realtime_factor:.3g} with the coarsest methods; "
            "use fewer azimuths, a shorter range, fewer bodies or less clutter"
        )
    caveats.append(f"chosen for the speed of this machine; --error-db {budget:g} gives the same bytes on any")
    return replace(plan, caveats=tuple(caveats))
