"""The records between a radar and its sinks."""

import dataclasses
from itertools import product

import numpy as np
import pytest

from radar_service.display.video import Controls, display_video
from radar_service.service.spokes import Epoch, SpokeBatch, new_epoch_name
from tests.service.fake import FakeEngine, scene


def test_a_batch_is_as_long_as_its_block_and_cannot_be_changed() -> None:
    engine = FakeEngine(scene())
    batch = SpokeBatch(Epoch("e", engine, None), 7, engine.block(3, 4), Controls())
    assert len(batch) == 4
    with pytest.raises(dataclasses.FrozenInstanceError):
        batch.first = 8  # type: ignore[misc]


def test_the_cells_of_an_epoch_end_at_its_range() -> None:
    assert Epoch("e", FakeEngine(scene()), 100.0).layout(None).bins == 10


@pytest.mark.parametrize("controls", [Controls(), Controls(60, 30, 20, False, False, 1.5, True, True)])
def test_the_video_of_a_view_is_that_of_the_display(controls: Controls) -> None:
    """To the byte, in as many bins as a view asks for: the highest byte of a bin is that of its highest level."""
    engine = FakeEngine(scene())
    draw = np.random.default_rng(5)
    levels = [(10.0 ** draw.uniform(-17, -9, (4, 20))).astype(np.float32) for _ in range(2)]
    block = dataclasses.replace(engine.block(3, 4), power=levels[0])
    for display_range, bins in product((None, 130.0), (None, 20, 11, 7, 3, 1)):
        epoch = Epoch("e", engine, display_range)
        batch = SpokeBatch(epoch, 0, block, controls, levels[1][0], levels[1])
        to = epoch.layout(bins)
        expected = display_video(levels[0], to, controls, engine.noise_power, levels[1][0], levels[1])
        assert expected.any() and expected.shape == (4, to.bins)
        for _ in range(2):
            np.testing.assert_array_equal(batch.video_bytes(to), expected)


def test_no_two_epochs_have_the_same_name() -> None:
    assert len({new_epoch_name() for _ in range(100)}) == 100
