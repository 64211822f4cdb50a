"""The process of one running scene: loads it, prepares it, computes its spokes, and ends with it.

It sends on `control`: ("stage", text) while it prepares, then ("ready", SourceInfo) or ("refused", exception), then its
spare (see spare.py), and afterwards one (whether it succeeded, answer) for each question of ANSWERS that it receives. An
order to run, as (origin, scan, size, commands), arrives on `data`, and further commands and requests after it; from then on
it sends (fields of a block, number of trees) there, a NewSpare where its spare has died, and at last the text of a fault. The
socket holds it back while nobody reads.
"""

import contextlib
import gc
import math
import os
import threading
from collections.abc import Callable, Sequence
from functools import partial
from time import monotonic
from typing import Any, NoReturn

from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.processes.channel import Channel
from radar_service.processes.limits import at_low_priority, limit_memory
from radar_service.processes.processor_time import MachineBusyError
from radar_service.radar.parameters import START, Radar
from radar_service.records.cell_sources import SourceRequest
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.readers.mesh_reader import IN_PROCESS
from radar_service.scene_file.readers.sandbox import Sandbox
from radar_service.service.radio.spare import Spares, TakeOver
from radar_service.service.source import MakeEngine, SceneOrder, WorldEngine, other_radars
from radar_service.spoke_source import SourceInfo
from radar_service.world.commands import Command
from radar_service.world.error import SceneError
from radar_service.world.rotation import scene_at_rpm
from radar_service.world.scene import Scene

TREES_SECONDS = 1.0  # between two counts of the trees: ten thousand take a millisecond


def scene_of(order: SceneOrder) -> Scene:
    """Returns the scene of an order. Raises SceneError and MachineBusyError."""
    sandbox = Sandbox() if order.sandboxed else None
    try:
        scene = load_scene(order.source, mesh_reader=sandbox or IN_PROCESS)
    finally:
        if sandbox:
            sandbox.close()
    if order.radar not in (None, *scene.radar_ids):
        raise other_radars(scene.radar_ids, [order.radar])
    scene = scene.for_radar(order.radar)
    return scene if order.rpm is None else scene_at_rpm(scene, order.rpm, order.origin or START)


def run_world(
    control: Channel, data: Channel, order: SceneOrder, make_engine: MakeEngine, memory: int, in_background: bool
) -> None:
    """Is the life of the process. Returns when the service is gone.

    memory: what it may use [bytes]; in_background: whether it prepares at a low priority.
    """
    limit_memory(memory)
    engines: list[WorldEngine] = []
    answering = threading.Lock()
    _answer_on(control, engines, answering)
    with contextlib.suppress(OSError, EOFError), BLAS_LIMIT.held():
        try:
            set_up = partial(_prepared, control, order, make_engine)
            engine, info = at_low_priority(set_up) if in_background else set_up()
        except Exception as error:  # of any kind: the service must be notified
            control.send(("refused", _portable(error, memory)))
            return
        engines.append(engine)
        control.send(("ready", info))
        spares = Spares(control, data)
        while True:
            spares.first()
            if spares.is_spare:
                _answer_on(spares.ends[0], engines, answering)
            try:
                return _compute(spares, engine, info.radar, answering)
            except TakeOver:
                pass


def _prepared(control: Channel, order: SceneOrder, make_engine: MakeEngine) -> tuple[WorldEngine, SourceInfo]:
    control.send(("stage", "reading the scene"))
    scene = scene_of(order)
    control.send(("stage", "preparing and planning"))
    engine = make_engine(scene)
    engine.set_errors(None)  # they may change until a spoke is sent, so the serving process adds them
    info = engine.described(order.plan) if order.plan else engine.info
    gc.collect()
    gc.freeze()  # the scene is not searched again and again
    return engine, info


def _portable(error: Exception, memory: int) -> Exception:
    """Returns an exception that the service can read."""
    if isinstance(error, SceneError | MachineBusyError):
        return error
    if isinstance(error, MemoryError):
        return SceneError(
            f"scene: it needs more than the {memory / 2**20:.0f} MiB of memory that a scene may use; simplify it"
        )
    return RuntimeError(f"{type(error).__name__}: {error}")


def _compute(spares: Spares, engine: WorldEngine, radar: Radar, answering: threading.Lock) -> None:
    """Sends blocks; the last message is the reason of the end. Raises TakeOver in a spare that is to run instead.

    radar: as it was prepared; answering: held while a question is answered.
    """
    data = spares.ends[1]
    origin, scan, size, commands = data.receive()
    trees, counted = 0, -math.inf
    commanding = threading.Lock()
    try:
        if origin != radar.origin:
            engine.begin_at(origin)
        engine.skip_to(scan)
        engine.replay(commands)
        threading.Thread(target=_obey, args=(data, engine, commanding), name="commands", daemon=True).start()
        for block in engine.blocks(size=size):
            if monotonic() > counted + TREES_SECONDS:
                trees, counted = engine.trees, monotonic()
            data.send((vars(block) | {"range": None}, trees))  # the service has the ranges from the description
            if block.index + len(block) == radar.azimuths:  # threads that compute the scan have ended
                _renew(spares, answering, commanding)
        data.send("the engine ended its stream of spokes")
    except (OSError, EOFError):
        return
    except TakeOver:
        raise
    except Exception as error:  # as above
        data.send(f"{type(error).__name__}: {error}")
    threading.Event().wait()  # questions are answered until the service closes the channel


def _renew(spares: Spares, answering: threading.Lock, commanding: threading.Lock) -> None:
    """Forks another spare where that is needed, as `Spares.renew`, unless a thread carries out a command now."""
    if commanding.acquire(blocking=False):
        try:
            spares.renew(answering)
        finally:
            commanding.release()


def _obey(data: Channel, engine: WorldEngine, commanding: threading.Lock) -> None:
    """Carries out the commands and requests that arrive. commanding: held meanwhile."""
    with contextlib.suppress(OSError, EOFError):  # the service is gone: the thread that computes finds out, too
        while True:
            order: Command | tuple[SourceRequest, int | None] = data.receive()
            with commanding:
                if isinstance(order, Command):
                    engine.take(order)
                else:
                    request, spoke = order
                    engine.request_sources(request.labels, request.powers, spoke)


def _answer_on(control: Channel, engines: Sequence[WorldEngine], answering: threading.Lock) -> None:
    threading.Thread(target=_answer, args=(control, engines, answering), name="truth", daemon=True).start()


ANSWERS: dict[str, Callable[[WorldEngine, Any], Any]] = {
    "truth": lambda engine, time: engine.truth(time),
    "truth_lines": lambda engine, scan: engine.truth_lines(scan),
    "radiometric_lines": lambda engine, scan: engine.truth_lines(scan, radiometric=True),
}


def _answer(control: Channel, engines: Sequence[WorldEngine], answering: threading.Lock) -> NoReturn:
    """Answers questions; ends the process, also while it prepares, when the service is gone."""
    try:
        while True:
            question, argument = control.receive()
            with answering:
                try:
                    control.send((True, ANSWERS[question](engines[0], argument)))
                except Exception as error:  # as above
                    control.send((False, f"{type(error).__name__}: {error}"))
    finally:
        os._exit(0)
