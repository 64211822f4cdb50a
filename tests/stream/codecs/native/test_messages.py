"""Messages of the native feed: a real point target through every encoding."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.display.video import Controls
from radar_service.records import SpokeBlock
from radar_service.scene.load import load_scene
from radar_service.simulator import Simulator
from radar_service.stream.codecs.native import messages, wire
from radar_service.stream.feed_request import View
from radar_service.stream.spokes import Epoch, SpokeBatch
from tests.stream.fake import FakeEngine, scene

DEGREE = math.pi / 180


def test_interference_rejection_continues_from_batch_to_batch() -> None:
    engine = FakeEngine(scene())
    epoch, video = Epoch("e", engine, None), Controls(gain=0, gain_auto=False, sea_auto=False, interference_rejection=True)
    whole, before, first = engine.block(0, 6), engine.block(2, 1), engine.block(3, 3)
    before = replace(before, power=before.power / 1e3)

    def data(block: SpokeBlock, power: Any) -> Any:
        return wire.samples(
            wire.unpack(wire.pack(messages.spokes(SpokeBatch(epoch, 0, block, video, power), View("u8", None))))
        )

    assert np.array_equal(data(first, whole.power[2]), data(whole, None)[3:])
    assert data(first, before.power[0])[0].max() < data(first, None)[0].max()  # 30 dB less before the first spoke


@pytest.mark.parametrize("encoding", ["u8", "u8-log", "f16", "f32", "c64"])
def test_a_point_target_stands_where_it_belongs_in_every_encoding(encoding: str) -> None:
    position = (math.sin(120 * DEGREE) * 400, math.cos(120 * DEGREE) * 400, 15.0)
    point = {"name": "p", "shape": "point", "position_m": position, "rcs_dbsm": 0}
    radar = {"azimuths": 72, "beamwidth_deg": 8, "range_max_m": 600, "height_m": 15, "pulse_s": 1e-6}
    engine = Simulator(load_scene({"radar": radar, "own_ship": {"heading_deg": 70}, "body": [point]}))
    epoch, view = Epoch("e", engine, None), View(encoding, 60)
    to = epoch.layout(60)
    strongest, result = -math.inf, (0.0, 0.0)
    for block in engine.blocks(scans=1):
        batch = SpokeBatch(epoch, block.first, block, Controls(gain=0, gain_auto=False, sea_auto=False))
        message = wire.unpack(wire.pack(messages.spokes(batch, view)))
        level = np.abs(wire.samples(message)).astype(float) if encoding == "c64" else wire.samples(message).astype(float)
        k, b = np.unravel_index(np.argmax(level), level.shape)
        if level[k, b] > strongest:
            strongest = level[k, b]
            result = (message["azimuth"][k] * 360 / wire.TURN, message["range_first_m"] + b * message["range_step_m"])
    assert result[0] == pytest.approx(120, abs=2.5 + 0.01)  # half a step between spokes, and the wire's 0.005
    assert result[1] == pytest.approx(400, abs=to.step / 2)  # half a bin
