"""The process of one running scene: loads it, prepares it, computes its spokes, and ends with it.

It sends on `control`: ("stage", text) while it prepares, then ("ready", SpokeSourceInfo) or ("refused", exception), then its
spare (see spare.py), and afterwards one (whether it succeeded, answer) for each question. Questions, commands and requests are
calls of its simulator, as (method, arguments). An order to run, as (scan, size, commands), arrives on `data`, and commands and
requests after it; from then on it sends (fields of a block, number of trees) there, a MeasuredPlan that comes later, a NewSpare
where its spare has died, and at last the text of a fault.
"""

import contextlib
import gc
import math
import os
import threading
from collections.abc import Sequence
from functools import partial
from time import monotonic
from typing import NoReturn

from radar_service.numerics import BLAS_LIMIT
from radar_service.processes.channel import CAN_FORK, Channel, portable
from radar_service.processes.limits import MachineBusyError, at_low_priority, limit_memory
from radar_service.radar import Radar
from radar_service.scene_file import IN_PROCESS, Sandbox, model_and_folder, model_at_range, scene_from_model
from radar_service.service.radio.forks import MeasuredPlan, PlanChild, Spares, SpareTakesOver
from radar_service.service.scene_request import MakeSimulator, ProcessSimulator, SceneRequest
from radar_service.spoke_source import SpokeSourceInfo
from radar_service.world import Scene, SceneError, scene_at_rpm

TREES_SECONDS = 1.0  # between two counts of the trees: ten thousand take a millisecond


def scene_of(scene_request: SceneRequest) -> Scene:
    """Returns the scene of a scene request. Raises SceneError and MachineBusyError."""
    sandbox = Sandbox() if scene_request.sandboxed else None
    try:
        model, folder = model_and_folder(scene_request.scene_input, None)
        model = model_at_range(model, scene_request.radar, scene_request.range_m)
        scene = scene_from_model(model, folder, sandbox or IN_PROCESS)
    finally:
        if sandbox:
            sandbox.close()
    scene = scene.for_radar(scene_request.radar)
    return scene if scene_request.rpm is None else scene_at_rpm(scene, scene_request.rpm)


def run_scene(
    control: Channel,
    data: Channel,
    scene_request: SceneRequest,
    make_simulator: MakeSimulator,
    memory: int,
    in_background: bool,
) -> None:
    """Runs the process. Returns when the service is gone.

    memory: what it may use [bytes]; in_background: whether it prepares at a low priority.
    """
    limit_memory(memory)
    simulators: list[ProcessSimulator] = []
    answering = threading.Lock()
    _answer_on(control, simulators, answering)
    with contextlib.suppress(OSError, EOFError), BLAS_LIMIT.held():
        try:
            set_up = partial(_prepared, control, scene_request, make_simulator)
            simulator, info = at_low_priority(set_up) if in_background else set_up()
        except Exception as error:  # of any kind: the service must be notified
            control.send(("refused", _refusal(error, memory)))
            return
        simulators.append(simulator)
        control.send(("ready", info))
        spares = Spares(control, data)
        while True:
            spares.first()
            if spares.is_spare:
                _answer_on(spares.ends[0], simulators, answering)
            plan = PlanChild.forked(lambda: simulator.info.plan, spares.ends) if _comes_later(scene_request) else None
            try:
                return _compute(spares, simulator, info.radar, answering, plan)
            except SpareTakesOver:
                pass


def _prepared(
    control: Channel, scene_request: SceneRequest, make_simulator: MakeSimulator
) -> tuple[ProcessSimulator, SpokeSourceInfo]:
    control.send(("stage", "reading the scene"))
    scene = scene_of(scene_request)
    control.send(("stage", "preparing and planning"))
    simulator = make_simulator(scene)
    simulator.set_errors(None)  # they may change until a spoke is sent, so the serving process adds them
    if scene_request.plan:
        info = simulator.described(scene_request.plan)
    else:
        info = simulator.unmeasured_info if _comes_later(scene_request) else simulator.info
    gc.collect()
    gc.freeze()  # the scene is not searched again and again
    return simulator, info


def _comes_later(scene_request: SceneRequest) -> bool:
    """Whether the plan is measured after the first spokes."""
    return CAN_FORK and scene_request.measured_later and not scene_request.plan


def _refusal(error: Exception, memory: int) -> Exception:
    """Returns why a scene was not prepared, as the service can read it."""
    if isinstance(error, MemoryError):
        return SceneError(
            f"scene: it needs more than the {memory / 2**20:.0f} MiB of memory that a scene may use; simplify it"
        )
    return portable(error, (SceneError, MachineBusyError))


def _compute(
    spares: Spares, simulator: ProcessSimulator, radar: Radar, answering: threading.Lock, plan: PlanChild | None
) -> None:
    """Sends blocks; the last message is the reason of the end. Raises TakeOver in a spare that is to run instead.

    radar: as it was prepared; answering: held while a question is answered; plan: who measures it meanwhile.
    """
    data = spares.ends[1]
    scan, size, commands = data.receive()
    trees, counted = 0, -math.inf
    commanding = threading.Lock()
    try:
        simulator.skip_to(scan)
        simulator.replay(commands)
        threading.Thread(target=_obey, args=(data, simulator, commanding), name="commands", daemon=True).start()
        for block in simulator.blocks(size=size):
            if monotonic() > counted + TREES_SECONDS:
                trees, counted = simulator.trees, monotonic()
            data.send((vars(block) | {"range": None}, trees))  # the service has the ranges from the description
            if plan and (measured := plan.measured()):
                data.send(MeasuredPlan(measured))
            if block.index + len(block) == radar.azimuths:  # once a scan is often enough
                _renew(spares, answering, commanding)
        data.send("the engine ended its stream of spokes")
    except (OSError, EOFError):
        return
    except SpareTakesOver:
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


def _obey(data: Channel, simulator: ProcessSimulator, commanding: threading.Lock) -> None:
    """Carries out the commands and requests that arrive. commanding: held meanwhile."""
    with contextlib.suppress(OSError, EOFError):  # the service is gone: the thread that computes finds out, too
        while True:
            method, arguments = data.receive()
            with commanding:
                getattr(simulator, method)(*arguments)


def _answer_on(control: Channel, simulators: Sequence[ProcessSimulator], answering: threading.Lock) -> None:
    threading.Thread(target=_answer, args=(control, simulators, answering), name="truth", daemon=True).start()


def _answer(control: Channel, simulators: Sequence[ProcessSimulator], answering: threading.Lock) -> NoReturn:
    """Answers questions; ends the process, also while it prepares, when the service is gone."""
    try:
        while True:
            method, arguments = control.receive()
            with answering:
                try:
                    control.send((True, getattr(simulators[0], method)(*arguments)))
                except Exception as error:  # as above
                    control.send((False, f"{type(error).__name__}: {error}"))
    finally:
        os._exit(0)
