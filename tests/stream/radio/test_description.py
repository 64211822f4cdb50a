"""What a world process tells about its engine fits through a channel."""

import pickle

from radar_service.simulator import Simulator
from radar_service.stream.radio.world_process import describe
from tests.stream.fake import scene


def test_a_description_is_small_however_many_bodies_there_are() -> None:
    told = describe(Simulator(scene()))
    assert len(pickle.dumps(told)) < 20_000  # bytes
    assert pickle.loads(pickle.dumps(told)).scene == told.scene
    assert told.plan == pickle.loads(pickle.dumps(told.plan))
