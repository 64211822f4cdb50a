"""The one decoder of `spokes` messages: what the codec has encoded, as arrays."""

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls
from radar_service.service.codecs.native.messages import NativeCodec
from radar_service.service.feed_request import View
from radar_service.service.spokes import Epoch, SpokeBatch
from radar_service.wire import SpokeRows
from tests.service.fake import BINS, STEP, FakeEngine, power_of, scene

ENGINE = FakeEngine(scene())
UNIT = 2.0 * np.pi / 65536  # of angles on the wire


def message(view: View, first: int = 3, count: int = 4) -> dict[str, object]:
    """Spokes from number 26 on, which are 3 and on within their epoch; those of 80 to 100 degrees off the bow are blind."""
    batch = SpokeBatch(Epoch("e", ENGINE, None), first, ENGINE.block(26, count), Controls())  # type: ignore[arg-type]
    return wire.unpack(NativeCodec().spokes(batch, view))


def test_rows_are_what_was_sent() -> None:
    block, rows = ENGINE.block(26, 4), SpokeRows.of(message(View("f32")))
    assert rows.number.tolist() == [3, 4, 5, 6] and rows.index.tolist() == [2, 3, 4, 5]
    for name in ("time", "speed", "position"):
        np.testing.assert_array_equal(getattr(rows, name), getattr(block, name))
    for name in ("azimuth", "heading", "course"):
        np.testing.assert_allclose(getattr(rows, name), getattr(block, name), atol=UNIT / 2)
    np.testing.assert_array_equal(rows.samples, power_of(26 + np.arange(4), BINS))
    np.testing.assert_allclose(rows.range, (np.arange(BINS) + 0.5) * STEP)
    assert rows.range_step == STEP and rows.labels is None and rows.powers is None
    assert rows.blind.dtype == np.bool_ and rows.blind.shape == (4,)


def test_merged_rows_have_the_number_of_their_first_spoke() -> None:
    rows = SpokeRows.of(message(View("f32", spokes=2)))
    assert rows.number.tolist() == [3, 5] and rows.index.tolist() == [2, 4] and rows.samples.shape == (2, BINS)
    assert len(SpokeRows.of(message(View("f32", sector=(180.0, 190.0)))).number) == 0


def test_exact_angles_of_a_recording_are_taken() -> None:
    exact = [0.1, 0.2, 0.3, 0.4]
    rows = SpokeRows.of(message(View("f32")) | {"azimuth_rad": exact, "heading_rad": exact, "course_rad": exact})
    assert rows.azimuth.tolist() == rows.heading.tolist() == rows.course.tolist() == exact


def test_a_lost_heading_is_not_a_number() -> None:
    made = message(View("f32"))
    rows = SpokeRows.of(made | {"heading": [None, *made["heading"][1:]]})  # type: ignore[index]
    assert np.isnan(rows.heading).tolist() == [True, False, False, False]


def test_lengths_that_disagree_are_refused() -> None:
    with pytest.raises(ValueError, match="data"):
        SpokeRows.of(message(View("f32")) | {"bins": 7})
