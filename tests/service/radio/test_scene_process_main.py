"""What happens inside the process of a scene, tested in this one."""

import json
import os

import pytest

from radar_service.numerics.constants import KNOT
from radar_service.processes.fork_server import ForkServer
from radar_service.scene_file.readers.sandbox import Sandbox
from radar_service.service.radio import scene_process_main
from radar_service.service.radio.scene_process_main import scene_of
from radar_service.service.scene_request import ProcessSimulator, SceneRequest
from radar_service.simulator import Simulator
from radar_service.world.commands import Command
from radar_service.world.error import SceneError
from radar_service.world.scene import outline_of
from tests.service.fake import scene

STEERABLE = {"radar": {"azimuths": 60, "beamwidth_deg": 8}, "own_ship": {"steerable": {}}}
PERIOD = 2.5 / 60  # s of a spoke
SOON = 60.0  # s, for what should take a second


def test_the_simulator_is_an_engine_of_a_scene() -> None:
    engine: ProcessSimulator = Simulator(scene())
    assert {name for name in dir(ProcessSimulator) if not name.startswith("_")} <= set(dir(engine))
    assert engine.info.scene == outline_of(scene()) and engine.described({"a": 1}).plan == {"a": 1}


def test_only_orders_that_say_so_are_sandboxed_and_the_sandbox_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[bool] = []

    class Noting(Sandbox):
        def close(self) -> None:
            super().close()
            closed.append(True)

    monkeypatch.setattr(scene_process_main, "Sandbox", Noting)
    scene_of(SceneRequest({"name": "empty"}))
    assert not closed
    scene_of(SceneRequest({"name": "empty"}, sandboxed=True))
    with pytest.raises(SceneError):
        scene_of(SceneRequest({"radar": 3}, sandboxed=True))
    assert len(closed) == 2


def test_the_process_speaks_as_its_docstring_says(fork_server: ForkServer) -> None:
    child = fork_server.child(scene_process_main.run_scene, SceneRequest(STEERABLE), Simulator, 2**31, True)
    stages = []
    while (message := child.control.receive(SOON))[0] == "stage":
        stages.append(message[1])
    assert message[0] == "ready" and stages == ["reading the scene", "preparing and planning"]
    spare_process = child.control.receive(SOON)
    spare_control, spare_data = child.control.receive_ends(2)
    assert spare_process not in (os.getpid(), child.process)
    child.data.send((2, 16, (Command(5, 5 * PERIOD, None, speed_kn=10.0),)))
    block, trees = child.data.receive(SOON)
    assert trees >= 0 and block["first"] == 120 and block["range"] is None and len(block["time"]) == 16
    assert block["commands"] == 1 and block["speed"][0] == pytest.approx(10 * KNOT)
    child.data.send(("take", (Command(130, 130 * PERIOD, None, speed_kn=0.0),)))
    while block["commands"] < 2:
        block, _ = child.data.receive(SOON)
    assert (block["first"], block["speed"].max()) == (130, 0.0)
    child.control.send(("truth", (3.0,)))
    succeeded, truth = child.control.receive(SOON)
    assert succeeded and truth.time == 3.0
    child.control.send(("truth_lines", (None,)))
    _, [header] = child.control.receive(SOON)
    assert json.loads(header.text)["type"] == "header"
    child.control.send(("truth_lines", (4,)))
    _, [snapshot] = child.control.receive(SOON)
    assert json.loads(snapshot.text)["scan"] == 4 and snapshot.time == json.loads(snapshot.text)["time"]
    child.control.send(("truth_lines", (4, True)))
    assert child.control.receive(SOON) == (True, [snapshot])  # no body is crossed
    for question in (("truth", ("no time",)), ("what", ())):
        child.control.send(question)
        succeeded, reason = child.control.receive(SOON)
        assert not succeeded and "Error" in reason
    child.close()
    for channel in (spare_control, spare_data):
        channel.close()
