"""The most accurate fidelity that keeps a pace on this machine. It depends on the machine; the error budget that it comes to
pins it: the same budget gives the same bytes anywhere."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from radar_service.fidelity import Fidelity
from radar_service.plan.budget import STEPS_DB, ErrorBudget
from radar_service.plan.plan import Plan
from radar_service.plan.settings_search import fidelity_for, relative_cost
from radar_service.scene.world import Scene

HOPE = 0.8  # of the pace: estimates from another fidelity that come so near to it are worth setting up


def plan_in_time(
    scene: Scene, factor: float, planned: Callable[[Fidelity], Plan], requested: ErrorBudget | None = None
) -> Plan:
    """The plan of the most accurate fidelity that reaches `factor` simulated seconds a second on one thread here, of `requested`
    if that does; of the coarsest where none does. Its caveats say so.

    planned: the plan of the scene at a fidelity, with measured costs.
    """
    first = planned(fidelity_for(scene, requested or ErrorBudget()))
    if requested is not None and _reaches(first, factor):
        return first
    steps = [step for step in STEPS_DB if requested is None or step > requested.target_db]
    tried = [] if requested is None else [first]
    for step in steps:
        if step != steps[-1] and estimated_factor(scene, first, step) < HOPE * factor:
            continue
        tried.append(planned(fidelity_for(scene, ErrorBudget(step))))
        if _reaches(tried[-1], factor):
            break
    return _said(tried[-1], factor, () if requested is None else tried[:1])


def estimated_factor(scene: Scene, known: Plan, step: float) -> float:
    """The pace that another error budget [dB] would give, judged by the costs of a known plan: laying goes with the number of
    scatterers and the beam, looking with scatterers and the number of looks; the rest stays."""
    assert known.costs is not None
    old, new = (fidelity_for(scene, ErrorBudget(budget)) for budget in (known.settings["error_db"], step))
    points = new.scatterers_per_cell / old.scatterers_per_cell
    laying = points * relative_cost(scene.radar, new) / relative_cost(scene.radar, old)
    costs = known.costs
    changed = replace(
        costs, moving=costs.moving * laying, looks=costs.looks * points * old.visibility_step / new.visibility_step
    )
    return scene.radar.spoke_period / (changed.total * 1e-6)


def _reaches(plan: Plan, factor: float) -> bool:
    assert plan.realtime_factor is not None
    return plan.realtime_factor >= factor


def _said(plan: Plan, factor: float, refused: Sequence[Plan]) -> Plan:
    """The plan with what is to be said about its pace, and about the plan refused for being too slow."""
    caveats, budget = list(plan.caveats), plan.settings["error_db"]
    for slow in refused:
        caveats.append(
            f"an error budget of {slow.settings['error_db']:g} dB cannot be had at {factor:g} x real time on this machine: "
            f"it would run at {slow.realtime_factor:.3g}"
        )
    if not _reaches(plan, factor):
        caveats.append(
            f"{factor:g} x real time cannot be had on this machine: {plan.realtime_factor:.3g} with the coarsest methods; "
            "ask for fewer azimuths, a shorter range, fewer bodies or less clutter"
        )
    caveats.append(f"chosen for the speed of this machine; --error-db {budget:g} gives the same bytes on any")
    return replace(plan, caveats=tuple(caveats))
