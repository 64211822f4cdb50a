"""What a radar tells those who may not know the truth: nothing that names, counts or places what its scene holds.

A tracker under test reads the feed of a server without --truth. Its plan then has the methods and no bodies, and the scene no
warnings, which name bodies and say where they are.
"""

from collections.abc import Mapping
from typing import Any

BODY = "body "  # how what a choice is about begins, where it is about a body (plan.bodies)
TELLING: Mapping[str, Any] = {
    "caveats": [], "believed": [], "counts": None, "field_db": {}, "costs": None, "realtime_factor": None,
}  # fmt: skip  # parts of a plan that name or count bodies, or say whether these move, and what stands there instead


def told_plan(plan: Mapping[str, Any], knows_truth: bool) -> dict[str, Any]:
    """Returns a plan as plain data; without the truth, only what it says of methods."""
    if knows_truth:
        return dict(plan)
    hidden = {key: value for key, value in TELLING.items() if key in plan}
    choices = [choice for choice in plan.get("choices", ()) if not choice["what"].startswith(BODY)]
    return {**plan, **hidden, **({"choices": choices} if "choices" in plan else {})}


def told_fields(fields: Mapping[str, Any], is_blind: bool) -> dict[str, Any]:
    """Returns fields of a radar; where it is blind, without seed, scene's name and number of bodies, which tell a known scene."""
    return {**fields, "seed": 0, "scene": {**fields["scene"], "name": "", "bodies": 0}} if is_blind else dict(fields)


def told_warnings(warnings: tuple[str, ...], knows_truth: bool) -> list[str]:
    """Returns the warnings of a scene; none without the truth."""
    return list(warnings) if knows_truth else []
