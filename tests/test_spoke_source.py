"""Sources of spokes: what is known of one fits through a channel, and what each can do."""

import json
import pickle
from pathlib import Path

import pytest

from radar_service.recording.recording import Recording
from radar_service.service.radio.scene_process import SceneProcess
from radar_service.service.scene_request import Spared
from radar_service.simulator import Simulator
from radar_service.spoke_source import Commanded, SpokeSource, TellsSources
from tests.recording.scenes import recorded, simulator
from tests.service.fake import FakeEngine, scene

MEMBERS = {"info", "blocks", "skip_to", "truth", "truth_lines", "close"}
CAPABILITIES = (Commanded, TellsSources, Spared)


def members_of(protocol: type) -> set[str]:
    return {name for name in dir(protocol) if not name.startswith("_")} | set(getattr(protocol, "__annotations__", {}))


def test_a_source_of_spokes_has_six_members_which_each_kind_has() -> None:
    assert members_of(SpokeSource) == MEMBERS
    made: SpokeSource = Simulator(scene())
    assert MEMBERS <= set(dir(made)) and MEMBERS <= set(dir(FakeEngine(scene())))
    assert MEMBERS - {"info"} <= set(dir(Recording)) & set(dir(SceneProcess))  # that is made with the object


@pytest.mark.parametrize(
    ("kind", "can"),
    [(Simulator, (Commanded, TellsSources)), (Recording, ()), (SceneProcess, CAPABILITIES)],
)
def test_what_else_a_source_can_do_is_told_by_its_methods(kind: type, can: tuple[type, ...]) -> None:
    for capability in CAPABILITIES:
        assert (members_of(capability) - {"trees"} <= set(dir(kind))) is (capability in can), capability


def test_what_is_known_is_small_however_many_bodies_there_are() -> None:
    known = Simulator(scene()).info
    again = pickle.loads(pickle.dumps(known))
    assert len(pickle.dumps(known)) < 20_000  # bytes
    assert again.scene == known.scene and again.plan == known.plan and (again.range == known.range).all()


@pytest.mark.same_bytes
def test_a_simulator_and_a_recording_of_it_say_the_same(tmp_path: Path) -> None:
    made, read = simulator().info, Recording(recorded(tmp_path / "a.mcap", 1)).info
    assert (made.seed, made.fidelity, made.noise_power) == (read.seed, read.fidelity, read.noise_power)
    assert made.radar == read.radar and made.range.tobytes() == read.range.tobytes()
    assert made.plan.keys() == read.plan.keys() and made.plan["arithmetic"] == read.plan["arithmetic"]


def test_the_lines_of_the_truth_are_those_of_a_truth_file() -> None:
    made = simulator()
    next(made.blocks())
    header, lines = made.truth_lines(None), made.truth_lines(0)
    assert json.loads(header[0].text) == made.truth_header() and header[0].time == 0.0
    records = [*made.crossings(0), made.snapshot(0)]
    assert [json.loads(line.text) for line in lines] == [json.loads(json.dumps(each.as_dict())) for each in records]
    assert [line.time for line in lines] == [each.time for each in records]
