"""The process of one running scene: loads it, prepares it, computes its spokes, and ends with it.

It sends on `control`: ("stage", text) while it prepares, then ("ready", Description) or ("refused", exception), then its
spare (see spare.py), and afterwards one truth for each time [s] that it receives. An order to run, as
(scan, size), arrives on `data`; from then on it sends (fields of a block, number of trees) there, and at last the text of a
fault. The socket holds it back while nobody reads.
"""

import contextlib
import gc
import math
import os
import threading
from collections.abc import Mapping, Sequence
from functools import partial
from time import monotonic
from typing import Any, NoReturn

from radar_service.parallel import BLAS_LIMIT
from radar_service.scene.convert import scene_at_rpm
from radar_service.scene.error import SceneError
from radar_service.scene.files.mesh_reader import IN_PROCESS
from radar_service.scene.files.sandbox import Sandbox
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene
from radar_service.stream.processes.channel import Channel
from radar_service.stream.processes.limits import at_low_priority, limit_memory
from radar_service.stream.radio.description import Description, MakeEngine, SceneEngine
from radar_service.stream.radio.spare import with_spare
from radar_service.stream.source import SceneOrder, SceneOutline

TREES_SECONDS = 1.0  # between two counts of the trees: ten thousand take a millisecond


def scene_of(order: SceneOrder) -> Scene:
    """Returns the scene of an order. Raises SceneError."""
    sandbox = Sandbox() if order.sandboxed else None
    try:
        scene = load_scene(order.source, mesh_reader=sandbox or IN_PROCESS)
    finally:
        if sandbox:
            sandbox.close()
    return scene if order.rpm is None else scene_at_rpm(scene, order.rpm)


def outline_of(scene: Scene) -> SceneOutline:
    """Returns what the serving process keeps of a scene."""
    return SceneOutline(scene.name, scene.origin, scene.body_count, scene.warnings, scene.radar, scene.notes)


def describe(engine: SceneEngine, plan: Mapping[str, Any] | None = None) -> Description:
    """Returns what the serving process needs of an engine. plan: as plain data, where it is known; otherwise it is made."""
    return Description(
        outline_of(engine.scene), engine.seed, engine.fidelity, dict(plan or engine.plan.as_dict()), engine.noise_power,
        engine.range, engine.range_step,
    )  # fmt: skip


def run_world(
    control: Channel, data: Channel, order: SceneOrder, make_engine: MakeEngine, memory: int, in_background: bool
) -> None:
    """Is the life of the process. Returns when the service is gone.

    memory: what it may use [bytes]; in_background: whether it prepares at a low priority.
    """
    limit_memory(memory)
    engines: list[SceneEngine] = []
    _answer_on(control, engines)
    with contextlib.suppress(OSError, EOFError), BLAS_LIMIT.held():
        try:
            set_up = partial(_prepared, control, order, make_engine)
            engine, description = at_low_priority(set_up) if in_background else set_up()
        except Exception as error:  # of any kind: the service must be notified
            control.send(("refused", _portable(error, memory)))
            return
        engines.append(engine)
        control.send(("ready", description))
        (control, data), is_spare = with_spare(control, data)
        if is_spare:
            _answer_on(control, engines)
        _compute(data, engine)


def _prepared(control: Channel, order: SceneOrder, make_engine: MakeEngine) -> tuple[SceneEngine, Description]:
    control.send(("stage", "reading the scene"))
    scene = scene_of(order)
    control.send(("stage", "preparing and planning"))
    engine = make_engine(scene)
    description = describe(engine, order.plan)
    gc.collect()
    gc.freeze()  # the scene is not searched again and again
    return engine, description


def _portable(error: Exception, memory: int) -> Exception:
    """Returns an exception that the service can read."""
    if isinstance(error, SceneError):
        return error
    if isinstance(error, MemoryError):
        return SceneError(
            f"scene: it needs more than the {memory / 2**20:.0f} MiB of memory that a scene may use; simplify it"
        )
    return RuntimeError(f"{type(error).__name__}: {error}")


def _compute(data: Channel, engine: SceneEngine) -> None:
    """Sends blocks; the last message is the reason of the end."""
    scan, size = data.receive()
    trees, counted = 0, -math.inf
    try:
        engine.skip_to(scan)
        for block in engine.blocks(size=size):
            if monotonic() > counted + TREES_SECONDS:
                trees, counted = engine.trees, monotonic()
            data.send((vars(block) | {"range": None}, trees))  # the service has the ranges from the description
        data.send("the engine ended its stream of spokes")
    except OSError:
        return
    except Exception as error:  # as above
        data.send(f"{type(error).__name__}: {error}")
    threading.Event().wait()  # the truth is answered until the service closes the channel


def _answer_on(control: Channel, engines: Sequence[SceneEngine]) -> None:
    threading.Thread(target=_answer, args=(control, engines), name="truth", daemon=True).start()


def _answer(control: Channel, engines: Sequence[SceneEngine]) -> NoReturn:
    """Answers requests for the truth; ends the process, also while it prepares, when the service is gone."""
    try:
        while True:
            time = control.receive()
            try:
                control.send(engines[0].truth(time))
            except Exception as error:  # as above
                control.send(RuntimeError(f"{type(error).__name__}: {error}"))
    finally:
        os._exit(0)
