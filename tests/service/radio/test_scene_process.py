"""Scenes in processes of their own: the same bytes, clear errors, and a feed that outlives its process."""

import json
import math
import os
import signal
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.commands.shared_options import SimulatorOptions
from radar_service.processes.call import Progress
from radar_service.processes.fork_server import ForkServer
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.spokes import SpokeBlock
from radar_service.scene_file.load import load_scene
from radar_service.service.radio import scene_process
from radar_service.service.radio.scene_process import SceneProcess, SceneProcessMaker, prepared
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.simulator import Simulator
from radar_service.spoke_source import BusyFault, SpokeSource, SpokeSourceFault
from radar_service.world.error import SceneError
from tests.descriptors import descriptors_left, open_descriptors
from tests.processes import tasks
from tests.processes.test_fork_server import is_gone, until
from tests.service.fake import FakeEngine, dying
from tests.service.held import resident_memory
from tests.service.radio.recording import RecordingSink

SCENE: dict[str, Any] = {
    "name": "ship", "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600},
    "environment": {"noise": True},
    "body": [
        {"name": "ship", "shape": "box", "length_m": 20, "width_m": 5, "height_m": 5, "position_m": [0, 300, 2],
         "course_deg": 90, "speed_kn": 10},
        {"name": "buoy", "shape": "point", "position_m": [200, 0, 5], "rcs_dbsm": 10},
    ],
}  # fmt: skip
ORDER = SceneRequest(SCENE)
FLAT_OUT = Settings(pace=Pace("run", math.inf))


@pytest.fixture
def maker(fork_server: ForkServer) -> SceneProcessMaker:
    return SceneProcessMaker(fork_server, SimulatorOptions(fidelity="fast"))


def taken(source: SpokeSource, spokes: int) -> list[SpokeBlock]:
    """Blocks of so many spokes."""
    blocks, size = [], 0
    for block in source.blocks(size=32):
        blocks.append(block)
        size += len(block)
        if size >= spokes:
            return blocks
    raise AssertionError


def test_spokes_are_those_of_a_simulator_in_this_process(maker: SceneProcessMaker) -> None:
    simulator, source = Simulator(load_scene(SCENE), "fast"), maker(ORDER, Progress())
    for block, expected in zip(taken(source, 120), simulator.blocks(scans=2, size=32), strict=True):
        for key, value in vars(expected).items():
            np.testing.assert_array_equal(getattr(block, key), value)
    assert source.truth(12.5) == simulator.truth(12.5)
    known = source.info
    assert (known.seed, known.fidelity, known.noise_power) == (simulator.seed, simulator.fidelity, simulator.noise_power)
    assert known.radar == simulator.scene.radar and known.scene.body_count == 2
    assert set(known.plan) == set(simulator.plan.as_dict())
    source.close()
    until(lambda: is_gone(source.process))


def test_a_plan_that_is_measured_later_is_completed_in_place_and_changes_no_spoke(maker: SceneProcessMaker) -> None:
    """Counts and costs follow the first spokes, in the description that everybody has by then; a spare measures none again."""
    source, simulator = maker(replace(ORDER, measured_later=True), Progress()), Simulator(load_scene(SCENE), "fast")
    plan = source.info.plan
    assert plan["counts"] is None and plan["costs"] is None and plan["choices"]
    blocks = source.blocks(size=32)
    for block in simulator.blocks(size=32):
        np.testing.assert_array_equal(next(blocks).power, block.power)
        if plan["costs"]:
            break
    expected = simulator.plan.as_dict()
    assert plan["counts"] == expected["counts"] and plan["arithmetic"] == expected["arithmetic"]
    assert [choice["how"] for choice in plan["choices"]] == [choice["how"] for choice in expected["choices"]]
    assert plan["realtime_factor"] > 0
    again = maker(replace(ORDER, measured_later=True, plan=plan), Progress())
    assert again.info.plan == plan and again.scene_request.plan is None  # so that a changed order does not keep it
    for each in (source, again):
        each.close()


def test_a_spare_goes_on_and_has_a_spare_itself(maker: SceneProcessMaker) -> None:
    """Each goes on where the one before ended, with the same bytes; nothing is prepared again."""
    source, processes = maker(ORDER, Progress()), []
    simulator = Simulator(load_scene(SCENE), "fast")
    for scan, block in enumerate(simulator.blocks(scans=3, size=60)):
        processes += [source.process, source.spare_process]
        source.skip_to(scan)
        np.testing.assert_array_equal(np.concatenate([part.power for part in taken(source, 60)])[:60], block.power)
        assert source.truth(1.0) == simulator.truth(1.0)
        os.kill(source.process, signal.SIGKILL)
        failed, spare = source, source.spare()
        assert spare is not None and spare.process == processes[-1] and failed.spare() is None
        failed.close()
        source = spare
    source.close()
    until(lambda: all(is_gone(process) for process in processes if process))


@pytest.mark.parametrize("kill_after", [0, 70])
def test_labels_come_when_they_are_requested_also_after_a_crash(maker: SceneProcessMaker, kill_after: int) -> None:
    """Every spoke that is sent has the bytes of a run with labels from the start, whoever asks when."""
    sink, wanted = RecordingSink(), [SourceRequest()]
    source = maker(ORDER, Progress())
    transmitter = Transmitter(
        source, Settings(pace=Pace("pause", math.inf)), (sink,), time.monotonic, maker, sources=lambda: wanted[-1]
    )  # fmt: skip
    transmitter.start()
    try:
        for stop, request in (
            (20, SourceRequest(True)), (70, SourceRequest(True, (256,))), (150, SourceRequest()), (230, SourceRequest()),
        ):  # fmt: skip
            transmitter.pacer.step(stop - sink.spokes)
            sink.wait_for(lambda stop=stop: sink.spokes >= stop)  # type: ignore[misc]
            wanted.append(request)
            transmitter.pacer.interrupt()
            if stop == kill_after:
                os.kill(source.process, signal.SIGKILL)
    finally:
        transmitter.stop(10.0)
    expected = {spoke.number: spoke for spoke in Simulator(load_scene(SCENE), "fast", labels=True, powers=(256,)).spokes(6)}
    told = [(spoke.labels is not None, spoke.powers is not None) for batch in sink.batches for spoke in batch.block.spokes()]
    assert told[:150] == [(False, False)] * 20 + [(True, False)] * 50 + [(True, True)] * 80
    assert transmitter.state.restarts == bool(kill_after) and (kill_after or sink.numbers == list(range(230)))
    for spoke in (spoke for batch in sink.batches for spoke in batch.block.spokes()):
        wanted = expected[spoke.number]
        assert spoke.field.tobytes() == wanted.field.tobytes()
        assert spoke.labels is None or spoke.labels.tobytes() == wanted.labels.tobytes()
        assert spoke.powers is None or spoke.powers[256].tobytes() == wanted.powers[256].tobytes()


def test_a_spare_that_has_died_is_no_spare(maker: SceneProcessMaker) -> None:
    source = maker(ORDER, Progress())
    assert source.spare_process is not None
    os.kill(source.spare_process, signal.SIGKILL)
    assert source.spare() is None
    assert taken(source, 1)[0].first == 0  # the process itself goes on
    source.close()


@pytest.mark.parametrize("threads", [1, 2])
def test_a_spare_that_has_died_is_replaced_within_scans(threads: int, fork_server: ForkServer) -> None:
    """The new spare gives the bytes of a simulator, though it was forked while the process computed."""
    source = SceneProcessMaker(fork_server, SimulatorOptions(fidelity="fast", threads=threads))(ORDER, Progress())
    assert (first := source.spare_process) is not None
    os.kill(first, signal.SIGKILL)
    until(lambda: is_gone(first))
    blocks = source.blocks(size=32)
    for _ in range(1000):  # the socket holds some blocks that were computed before
        next(blocks)
        if source.spare_process != first:
            break
    os.kill(source.process, signal.SIGKILL)
    spare = source.spare()
    assert spare is not None and spare.process != first and spare.spare_process is not None
    spare.skip_to(7)
    simulator = Simulator(load_scene(SCENE), "fast")
    simulator.skip_to(7)
    (expected,) = simulator.blocks(scans=1, size=60)
    np.testing.assert_array_equal(np.concatenate([part.power for part in taken(spare, 60)])[:60], expected.power)
    assert spare.truth(3.0) == simulator.truth(3.0)
    processes = spare.process, spare.spare_process
    for one in (source, spare):
        one.close()
    until(lambda: all(is_gone(process) for process in processes))


def halt(process: int) -> None:
    """Stops a process, and waits until each of its threads stands still: the signal alone takes some time."""
    os.kill(process, signal.SIGSTOP)
    threads = list(Path(f"/proc/{process}/task").glob("*/stat"))
    until(lambda: all(thread.read_text().rpartition(")")[2].split()[0] == "T" for thread in threads))


@pytest.mark.same_bytes
def test_a_truth_that_takes_too_long_ends_nothing_and_is_not_taken_for_another(
    maker: SceneProcessMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, simulator = maker(ORDER, Progress()), Simulator(load_scene(SCENE), "fast")
    assert source.truth(1.0) == simulator.truth(1.0)
    halt(source.process)
    monkeypatch.setattr(scene_process, "TRUTH_TIMEOUT", 0.05)
    for time_asked in (2.0, 3.0):
        with pytest.raises(BusyFault, match=r"^truth: none after 0.05 s; try again later$"):
            source.truth(time_asked)
    os.kill(source.process, signal.SIGCONT)
    monkeypatch.setattr(scene_process, "TRUTH_TIMEOUT", 20.0)
    assert source.truth(4.0) == simulator.truth(4.0) and source.truth(5.0) == simulator.truth(5.0)
    assert taken(source, 1)[0].first == 0
    source.close()


def test_a_spare_that_comes_after_the_end_is_ended(maker: SceneProcessMaker, fork_server: ForkServer) -> None:
    source, late = maker(ORDER, Progress()), fork_server.child(tasks.wait)
    source.close()
    source.replace_spare(late)
    until(lambda: is_gone(late.process))


def test_it_tells_how_many_trees_it_holds(maker: SceneProcessMaker) -> None:
    """Equal boxes share one."""
    boxes = [
        SCENE["body"][0] | {"name": name, "material": "steel", "position_m": [x, 300, 2]}
        for name, x in (("a", 0), ("b", 50))
    ]
    source = maker(SceneRequest(SCENE | {"body": boxes}), Progress())
    assert source.trees == 0
    taken(source, 60)
    assert source.trees == 1
    source.close()


@pytest.mark.parametrize(
    ("scene", "words"),
    [({"radar": {"azimuths": 10**9}}, "radar.azimuths"), ({"body": [{"name": "a", "mesh": "a.obj"}]}, "body[0].mesh")],
)
def test_a_scene_that_is_not_valid_is_refused_with_its_lines(maker: SceneProcessMaker, scene: Any, words: str) -> None:
    with pytest.raises(SceneError) as error:
        maker(SceneRequest(scene), Progress())
    assert all(isinstance(line, str) for line in error.value.problems) and words in error.value.problems[0]


def test_a_rate_that_the_scene_cannot_have_is_refused(maker: SceneProcessMaker) -> None:
    slow = SCENE | {"radar": SCENE["radar"] | {"prf_hz": 60.0}}
    with pytest.raises(SceneError, match="rpm: 600 gives"):
        maker(SceneRequest(slow, rpm=600.0), Progress())


def test_too_much_memory_is_an_error_of_the_scene(fork_server: ForkServer) -> None:
    with pytest.raises(SceneError, match="it needs more than the 512 MiB"):
        SceneProcessMaker(fork_server, hungry, 2**29)(ORDER, Progress())


def hungry(of: Any) -> FakeEngine:
    np.ones(2**30, dtype=np.uint8)
    return FakeEngine(of)


class KilledInPreparation(Progress):
    """Kills the process as soon as it says that it reads the scene."""

    def __init__(self) -> None:
        self.close: Any = None

    def ends_with(self, close: Any) -> None:
        self.close = close

    def stage(self, text: str) -> None:
        self.close()


def test_a_process_that_ends_while_it_prepares_is_a_fault(maker: SceneProcessMaker) -> None:
    with pytest.raises(SpokeSourceFault, match="its process has ended"):
        maker(ORDER, KilledInPreparation())


def test_preparing_too_long_is_a_fault(maker: SceneProcessMaker, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_process, "PREPARE_TIMEOUT", 0.0)
    with pytest.raises(SpokeSourceFault, match="too heavy"):
        maker(ORDER, Progress())


def test_a_machine_that_gives_no_processor_time_is_no_fault_of_the_scene(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_process, "PREPARE_TIMEOUT", 1.0)
    with pytest.raises(BusyFault, match="^scene: the machine is busy: .* in 1 s; try again later$"):
        SceneProcessMaker(fork_server, tasks.wait)(ORDER, Progress())  # type: ignore[arg-type]


def test_without_descriptors_a_scene_is_to_be_tried_again_and_nothing_is_lost(maker: SceneProcessMaker) -> None:
    maker(ORDER, Progress()).close()  # the process that starts others runs
    before, refused = open_descriptors(), 0
    for left in range(9):
        with descriptors_left(left):
            try:
                maker(ORDER, Progress()).close()
            except BusyFault as error:
                refused += 1
                assert "no process could be started" in str(error) and "try again later" in str(error), left
        assert open_descriptors() == before, left
    assert 4 <= refused < 9


def test_a_busy_sandbox_is_no_fault_of_the_scene(fork_server: ForkServer) -> None:
    with pytest.raises(BusyFault, match="^here: the machine is busy"):
        SceneProcessMaker(fork_server, tasks.find_machine_busy)(ORDER, Progress())  # type: ignore[arg-type]


def test_an_engine_that_fails_says_why(fork_server: ForkServer) -> None:
    source = SceneProcessMaker(fork_server, dying)(ORDER, Progress())
    with pytest.raises(SpokeSourceFault, match="RuntimeError: the wheel came off"):
        taken(source, 1000)
    assert source.truth(1.0).time == 1.0  # still
    source.close()
    for failing in (lambda: source.truth(1.0), lambda: taken(source, 1)):
        with pytest.raises(SpokeSourceFault, match="its process has ended"):
            failing()


@pytest.mark.parametrize("death", [signal.SIGKILL, signal.SIGSEGV])
def test_a_killed_process_is_replaced_in_the_next_scan(maker: SceneProcessMaker, death: int) -> None:
    """Numbers go on, and the missing ones are announced."""
    sink, first = RecordingSink(), maker(ORDER, Progress())
    transmitter = Transmitter(first, FLAT_OUT, (sink,), time.monotonic, maker)
    transmitter.start()
    sink.wait_for(lambda: sink.spokes > 100)
    before = transmitter.state.restarts
    os.kill(first.process, death)
    sink.wait_for(lambda: "skip" in sink.names() and sink.calls[-1][0] == "send")
    second = transmitter.epoch.spoke_source
    transmitter.stop(10.0)
    assert transmitter.state.restarts == before + 1
    number = 0
    for name, details in sink.calls[1:]:
        assert name in ("send", "skip") and details[1] == number
        number += details[2]
    assert [batch.first for batch in sink.batches] == [batch.block.first for batch in sink.batches]
    assert isinstance(second, SceneProcess) and second is not first
    until(lambda: is_gone(first.process) and is_gone(second.process))


def test_a_file_that_has_changed_does_not_go_on_in_the_same_epoch(maker: SceneProcessMaker, tmp_path: Path) -> None:
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(SCENE))
    sink, first, reasons = RecordingSink(), maker(SceneRequest(file), Progress()), list[str]()
    transmitter = Transmitter(first, FLAT_OUT, (sink,), time.monotonic, maker, on_restart=reasons.append)
    transmitter.start()
    sink.wait_for(lambda: sink.spokes > 0)
    file.write_text(json.dumps(SCENE | {"radar": SCENE["radar"] | {"azimuths": 72}}))
    assert first.spare_process is not None
    halt(first.process)  # so that it makes no other spare
    os.kill(first.spare_process, signal.SIGKILL)
    os.kill(first.process, signal.SIGKILL)
    sink.wait_for(lambda: sink.calls[-1][0] == "close")
    assert reasons[0].startswith("its process has ended") and "the radar in the scene's file has changed" in reasons[1]
    transmitter.stop(10.0)


@pytest.mark.parametrize("swaps", [10, pytest.param(50, marks=pytest.mark.study)])
def test_swaps_leave_no_memory_descriptor_or_process(swaps: int, maker: SceneProcessMaker) -> None:
    def swap() -> int:
        worker = prepared(maker(ORDER, Progress()))
        process: int = worker.spoke_source.process  # type: ignore[attr-defined]
        worker.stop(10.0)
        return process

    swap()
    memory, descriptors = resident_memory(os.getpid()), len(os.listdir("/proc/self/fd"))
    processes = [swap() for _ in range(swaps)]
    until(lambda: all(is_gone(process) for process in processes))
    assert len(os.listdir("/proc/self/fd")) <= descriptors  # fewer where an earlier test's were still open
    assert (
        resident_memory(os.getpid()) - memory < 8 * 2**20
    )  # bytes: the allocator's arenas come and go by less; a process has 20 MiB
