"""The stream of spokes of a simulator: commands cut blocks, errors change what is reported."""

from typing import Any

import numpy as np
import pytest

from radar_service.errors.reporter import ErrorReporter
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.fidelity import PRESETS
from radar_service.records.spokes import SpokeBlock
from radar_service.scans.sector import Sector
from radar_service.scene_file.load import load_scene
from radar_service.simulation.engine_set_up import SourceTiles, engine_set_up
from radar_service.simulation.spoke_stream import SpokeStream
from radar_service.simulation.tile_processes import TileProcesses
from radar_service.simulator import Simulator
from radar_service.world.reporting import ErrorSettings
from radar_service.world.steering import Steering
from tests.scenes import point

SCENE = {
    "name": "stream",
    "radar": {"azimuths": 32, "beamwidth_deg": 20, "range_max_m": 600, "pulse_s": 1e-6, "rpm": 60},
    "own_ship": {"steerable": {"max_speed_kn": 40}},
    "body": [point("p", 100, 200)],
    "errors": {"gyro": {"bias_deg": 1.0}},
}


@pytest.fixture
def stream() -> SpokeStream:
    scene = load_scene(SCENE)
    steering = Steering(scene)
    engine, _, _, pulses = engine_set_up(steering.scene, PRESETS["fast"], "fast", 0)
    tiles = TileProcesses(SourceTiles(engine, pulses, SourceRequest()), steering, 1)
    errors: ErrorSettings | None = scene.errors
    return SpokeStream(tiles, steering, Sector(scene.radar, None), ErrorReporter(scene.radar, 0, errors))


def test_blocks_follow_each_other_and_are_reported_with_errors(stream: SpokeStream) -> None:
    blocks = list(stream.blocks(2, 8))
    assert [block.first for block in blocks] == list(range(0, 64, 8)) and (stream.next_scan, stream.next_spoke) == (2, 64)
    assert all(block.true is not None for block in blocks)
    assert np.degrees(blocks[0].heading - blocks[0].true.heading) == pytest.approx(np.full(8, 1.0))


def test_a_command_cuts_the_blocks_where_it_acts(stream: SpokeStream) -> None:
    stream.command(None, 5, None, {"speed_kn": 10, "course_deg": 90})
    blocks = list(stream.blocks(1, 8))
    assert sum(len(block) for block in blocks) == 32 and 5 in [block.first for block in blocks]
    speeds = np.concatenate([block.true.speed for block in blocks])
    assert (speeds[:5] == 0).all() and (speeds[5:] > 5).all()
    assert [block.commands for block in blocks] == [1] * len(blocks)


def test_an_earlier_command_takes_the_stream_back(stream: SpokeStream) -> None:
    blocks = stream.blocks(1, 8)
    assert [next(blocks).first, next(blocks).first] == [0, 8]
    stream.command(None, 4, None, {"speed_kn": 10})
    assert next(blocks).first == 4 and sum(map(len, blocks)) == 20


def test_a_request_acts_from_its_spoke_on_and_changes_no_byte(stream: SpokeStream) -> None:
    """The stream goes back for labels, but not where they are no longer requested."""
    blocks, plain = stream.blocks(2, 8), SpokeBlocks(SCENE)
    taken = [next(blocks), next(blocks)]
    stream.request_sources(SourceRequest(labels=True), 12)
    taken += [next(blocks), next(blocks)]
    stream.request_sources(SourceRequest(powers=(256,)), None)
    taken.append(next(blocks))
    stream.request_sources(SourceRequest(), None)
    taken += list(blocks)
    spans = [(block.first, len(block), block.labels is not None, block.powers is not None) for block in taken]
    assert spans[:6] == [(0, 8, False, False), (8, 8, False, False), (12, 8, True, False), (20, 8, True, False),
                         (28, 4, False, True), (32, 8, False, False)]  # fmt: skip
    assert [block.requests for block in taken[:6]] == [0, 0, 1, 1, 2, 3]
    for block in taken:
        plain.check(block)


class SpokeBlocks:
    """The spokes of a run with labels and powers from the start."""

    def __init__(self, scene: dict[str, Any]) -> None:
        self._spokes = list(Simulator(load_scene(scene), "fast", labels=True, powers="all").spokes(2))

    def check(self, block: SpokeBlock) -> None:
        for spoke in block.spokes():
            whole = self._spokes[spoke.number]
            assert spoke.field.tobytes() == whole.field.tobytes() and spoke.heading == whole.heading
            assert spoke.labels is None or spoke.labels.tobytes() == whole.labels.tobytes()
            assert spoke.powers is None or spoke.powers[256].tobytes() == whole.powers[256].tobytes()


def test_readings_are_those_of_each_time(stream: SpokeStream) -> None:
    stream.command(None, 16, None, {"speed_kn": 20, "course_deg": 90})
    list(stream.blocks(1, 8))
    readings = stream.readings(np.array([0, 15, 17]))
    assert readings.speed.tolist()[:2] == [0.0, 0.0] and readings.speed[2] == pytest.approx(20 * 0.514444, rel=1e-4)


def test_it_skips_scans_forward_and_back(stream: SpokeStream) -> None:
    stream.skip_to(7)
    assert next(stream.blocks(1, 4)).first == 7 * 32
    stream.skip_to(1)
    assert next(stream.blocks(1, 4)).scan == 1


def test_a_command_before_the_skip_is_followed_from_there(stream: SpokeStream) -> None:
    """Nothing is computed that nobody asked for: an engine that goes on for another one gets its last commands late."""
    stream.skip_to(2)
    blocks = stream.blocks(1, 8)
    assert [next(blocks).first, next(blocks).first] == [64, 72]
    stream.command(None, None, 40 / 32, {"speed_kn": 20, "course_deg": 90})
    again = next(blocks)
    assert again.first == 64 and again.speed[0] == pytest.approx(20 * 0.514444, rel=1e-4)


def test_a_request_before_a_skip_adds_no_scan(stream: SpokeStream) -> None:
    list(stream.blocks(1, 32))
    stream.request_sources(SourceRequest(labels=True), None)
    stream.skip_to(4)
    assert [(block.scan, block.labels is not None) for block in stream.blocks(1, 32)] == [(4, True)]
