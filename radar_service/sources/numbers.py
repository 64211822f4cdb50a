"""The numbers of sources: what a label says, and by which the power of a source is asked for.

Land is all that rests on the map and is built of no vessel's material; its bodies of one material are one source. Every other
body is a source of its own, with its reflection from the sea.
"""

import numpy as np

from radar_service.echo import SECOND_TIME
from radar_service.numerics import Indices
from radar_service.stages.registry import echo_numbers, numbered_sources
from radar_service.world import MATERIALS, Body, Scene, is_land

NOISE, SECOND_TIME_AROUND = 0, 4  # and those of effects
FAINT = 9  # range sidelobes and faint parts of bodies: more than `labels_within_db` below the peak of the body
LAND = 16  # of the first material of MATERIALS; the others follow in their order
BODY = 256  # of the first body of the scene; the others follow in their order
COMMON = {NOISE: "noise", SECOND_TIME_AROUND: "second time around"}


def source_numbers(scene: Scene) -> Indices:
    """The source number of each body of a scene and of what else has echoes: effects, and SECOND_TIME, which is -1."""
    assert SECOND_TIME == -1
    bodies = [_number(body, k) for k, body in enumerate(scene.bodies)]
    return np.array([*bodies, *echo_numbers(scene), SECOND_TIME_AROUND], dtype=np.int64)


def source_names(scene: Scene) -> dict[int, str]:
    """The name of each source number that the scene may have, by rising number."""
    land = {_number(body, k): f"land: {body.material.name}" for k, body in enumerate(scene.bodies) if is_land(body)}
    bodies = {BODY + k: body.name for k, body in enumerate(scene.bodies) if not is_land(body)}
    faint = {FAINT: "range sidelobes and faint parts"} if bodies and scene.radar.label_floor else {}
    effects = {number: source.name for number, (_, source) in numbered_sources(scene).items()}
    return dict(sorted((COMMON | faint | effects | land | bodies).items()))


def _number(body: Body, k: int) -> int:
    return LAND + list(MATERIALS).index(body.material.name) if is_land(body) else BODY + k
