"""The records between a radar and its sinks."""

import dataclasses

import pytest

from radar_service.display.video import Controls
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


def test_no_two_epochs_have_the_same_name() -> None:
    assert len({new_epoch_name() for _ in range(100)}) == 100
