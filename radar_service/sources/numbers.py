"""The numbers of sources: what a label says, and by which the power of a source is asked for.

Land is all that rests on the map and is built of no vessel's material; its bodies of one material are one source. Every other
body is a source of its own, with its reflection from the sea.
"""

import numpy as np

from radar_service.echo.echoes import INDIRECT, MULTIPLE, SECOND_TIME
from radar_service.numerics.types import Indices
from radar_service.radar.structure_shadow import structure_reflectors
from radar_service.stages.registry import echo_numbers, numbered_sources
from radar_service.world.body import Body
from radar_service.world.materials import MATERIALS, is_land
from radar_service.world.scene import Scene

NOISE, SECOND_TIME_AROUND = 0, 4  # and those of effects
FALSE = {INDIRECT: 7, MULTIPLE: 8}  # numbers of false echoes, by what stands in place of a body's index
FALSE_NAMES = {INDIRECT: "indirect", MULTIPLE: "multiple"}
FAINT = 9  # range sidelobes and faint parts of bodies: more than `labels_within_db` below the peak of the body
LAND = 16  # of the first material of MATERIALS; the others follow in their order
BODY = 256  # of the first body of the scene; the others follow in their order
COMMON = {NOISE: "noise", SECOND_TIME_AROUND: "second time around"}


def source_numbers(scene: Scene) -> Indices:
    """The source number of each body of a scene and of what else has echoes: effects of other packages, the kinds of false echoes
    that the scene has, and SECOND_TIME, which is -1."""
    assert SECOND_TIME == -1
    false = [FALSE[MULTIPLE], FALSE[INDIRECT]] if false_echoes(scene) else []
    bodies = [_number(body, k) for k, body in enumerate(scene.bodies)]
    return np.array([*bodies, *echo_numbers(scene), *false, SECOND_TIME_AROUND], dtype=np.int64)


def false_echoes(scene: Scene) -> set[int]:
    """The kinds of false echoes that a scene may have, as what stands in place of a body's index."""
    kinds = {INDIRECT} if structure_reflectors(scene.radar) else set()
    return kinds if scene.radar.multiple is None else kinds | {MULTIPLE}


def source_names(scene: Scene) -> dict[int, str]:
    """The name of each source number that the scene may have, by rising number."""
    names = COMMON | {FALSE[kind]: FALSE_NAMES[kind] for kind in false_echoes(scene)}
    land = {_number(body, k): f"land: {body.material.name}" for k, body in enumerate(scene.bodies) if is_land(body)}
    bodies = {BODY + k: body.name for k, body in enumerate(scene.bodies) if not is_land(body)}
    names |= {FAINT: "range sidelobes and faint parts"} if bodies and scene.radar.label_floor else {}
    effects = {number: source.name for number, (_, source) in numbered_sources(scene).items()}
    return dict(sorted((names | effects | land | bodies).items()))


def _number(body: Body, k: int) -> int:
    return LAND + list(MATERIALS).index(body.material.name) if is_land(body) else BODY + k
