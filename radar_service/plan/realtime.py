"""The most accurate fidelity that keeps a pace on this machine.

The result depends on the machine. The error budget of the result pins it: the same budget gives the same bytes anywhere.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from radar_service.plan.budget import STEPS_DB, ErrorBudget
from radar_service.plan.plan import Plan
from radar_service.plan.settings_search import fidelity_for, relative_cost
from radar_service.records.fidelity import Fidelity
from radar_service.world.scene import Scene

WORTH_TRYING = 0.8  # of the pace: a budget whose estimate reaches this share of it is planned and measured


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
    return scene.radar.spoke_period / (changed.total * 1e-6)


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
