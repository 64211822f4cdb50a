"""Which engine runs: restarts within their limit, and another engine that takes over."""

from dataclasses import replace
from typing import Any

import pytest

from radar_service.processes.call import Progress
from radar_service.service.radio.scene_process import prepared
from radar_service.service.radio.worker_supervisor import WorkerSupervisor
from radar_service.service.scene_request import SceneRequest
from tests.processes.test_fork_server import until
from tests.service.fake import AZIMUTHS, FakeEngine, commanded, factory, scene, steerable_scene
from tests.service.radio.recording import SOON


def supervisor(**options: object) -> WorkerSupervisor:
    return WorkerSupervisor(FakeEngine(scene()), factory(**options))


def test_a_restart_hands_on_the_plan() -> None:
    orders: list[SceneRequest] = []

    def make(order: SceneRequest, progress: Progress) -> FakeEngine:
        orders.append(order)
        return factory()(order, progress)

    engines = WorkerSupervisor(FakeEngine(scene()), make)
    engines.restart(4)
    engines.stop(SOON)
    assert [order.plan for order in orders] == [{"modelled": []}]


class WithSpare(FakeEngine):
    """Has a spare."""

    def __init__(self, spare: FakeEngine) -> None:
        super().__init__(scene())
        self._other = spare

    def spare(self) -> Any:
        assert not self.closed
        return self._other


@pytest.mark.parametrize("delivers", [True, False])
def test_a_spare_goes_on_where_it_delivers(delivers: bool) -> None:
    spare = FakeEngine(scene("spare"), dies_at=None if delivers else 0)
    engines = WorkerSupervisor(WithSpare(spare), factory())
    engines.restart(4)
    assert (engines.worker.spoke_source is spare) == delivers and spare.closed != delivers
    block = engines.worker.take(SOON)
    assert block is not None and block.first == 4 * AZIMUTHS
    engines.stop(SOON)


def test_the_last_pending_engine_wins_and_the_replaced_one_ends() -> None:
    engines = supervisor()
    replaced, last = (prepared(FakeEngine(scene(name))) for name in ("first", "last"))
    names = [engines.switch_to(worker) for worker in (replaced, last)]
    assert engines.pending and engines.pending_spoke_source.info.scene.name == "last" and names[0] != names[1]
    assert engines.take_over() == names[1] and last is engines.worker and not engines.pending
    until(lambda: not replaced.is_alive)
    engines.stop(SOON)
    assert not last.is_alive


def test_an_engine_that_goes_on_follows_the_commands_that_came_while_it_was_prepared() -> None:
    of = steerable_scene()
    engines = WorkerSupervisor(FakeEngine(of), factory())
    began = list[Any]()
    for order, count in ((SceneRequest(of, goes_on=True), 2), (SceneRequest(of), 0)):
        next_engine = FakeEngine(of)
        next_engine.scene_request = order
        engines.switch_to(prepared(next_engine))
        commanded(engines.worker, 30, "buoy", {"speed_kn": 5})
        commanded(engines.worker, 31, "buoy", {"speed_kn": 6})
        assert engines.pending is not None and engines.pending.spoke_source is next_engine
        taken = engines.take_over(began.append)
        assert taken is not None and engines.worker.spoke_source is next_engine
        assert len(next_engine.commands) == count
    engines.stop(SOON)
    assert len(began) == 2 and engines.pending is None


def test_another_rate_keeps_the_scene_and_an_equal_scene_does_not() -> None:
    of = scene()
    engines = WorkerSupervisor(running := FakeEngine(of), factory())
    order = replace(running.scene_request, rpm=48.0)
    assert engines.keep_scene_of(order) and not engines.keep_scene_of(SceneRequest(scene()))
    engines.switch_to(prepared(FakeEngine(scene())))
    assert not engines.keep_scene_of(order)
    engines.stop(SOON)


def test_a_command_that_comes_during_a_restart_is_known_to_the_next_engine() -> None:
    of = steerable_scene()

    def make(order: SceneRequest, progress: Progress) -> FakeEngine:
        commanded(failed, 30, "buoy", {"speed_kn": 6})
        return made

    made = FakeEngine(of)
    whole = made.replay
    made.replay = lambda commands: (whole(list(commands)), commanded(failed, 33, "buoy", {"speed_kn": 7}))[0]  # type: ignore[method-assign]
    engines = WorkerSupervisor(FakeEngine(of), make)
    failed = engines.worker
    commanded(failed, 7, "buoy", {"speed_kn": 5})
    engines.restart(1)
    engines.stop(SOON)
    assert [command.speed_kn for command in made.commands] == [5.0, 6.0, 7.0]
