"""The wire of the native feed, each module under its name."""

import math
import struct
import zlib

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from radar_service import wire
from radar_service.display.video import Controls
from radar_service.service.codecs.native.messages import NativeCodec
from radar_service.service.feed_request import View
from radar_service.service.spokes import Epoch, SpokeBatch
from radar_service.wire import SpokeRows
from tests.service.codecs.native.test_views import message
from tests.service.fake import BINS, STEP, FakeEngine, power_of, scene


# format: exact messages, angles, and what a decoder refuses.
def test_angles_are_whole_parts_of_a_turn() -> None:
    assert wire.turn_from_radians(np.array([0.0, math.pi / 2, math.pi, -math.pi / 2, 2 * math.pi])) == [
        0,
        16384,
        32768,
        49152,
        0,
    ]
    assert wire.turn_from_radians(np.array([math.nan, math.pi])) == [None, 32768]
    assert np.isnan(wire.radians_from_turn([None, 32768])).tolist() == [True, False]
    back = wire.radians_from_turn([16384, 65535])
    np.testing.assert_allclose(back, [math.pi / 2, 2 * math.pi * 65535 / 65536], rtol=1e-15)  # rounding


def test_a_message_is_these_bytes() -> None:
    # by the msgpack specification: a map of three, fixed strings, a fixed integer, bin 8
    message = {"type": "x", "first": 5, "data": b"\x01\x02"}
    assert wire.pack(message) == b"\x83\xa4type\xa1x\xa5first\x05\xa4data\xc4\x02\x01\x02"
    assert wire.unpack(wire.pack(message)) == message


@pytest.mark.parametrize(
    "data",
    [b"", b"\xc1", b"\x81", b"\x90", b"\x05", b"\x81\xa4type\x05", b"\x80", b"\xdd\xff\xff\xff\xff",
     b"\xc6\x7f\xff\xff\xffab",
     b"\x91" * 5000, b"\x81\xa4type\xa1x\x00"],
)  # fmt: skip
def test_what_is_not_a_message_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="message"):
        wire.unpack(data)


@given(st.binary(max_size=64))
def test_rubbish_raises_nothing_but_value_errors(data: bytes) -> None:
    try:
        message = wire.unpack(data)
    except ValueError:
        return
    assert isinstance(message["type"], str)


def test_samples_are_little_endian_rows() -> None:
    data = struct.pack("<6f", 1, 2, 3, 4, 5, 6)
    message = {"encoding": "f32", "azimuth": [0, 1], "bins": 3, "data": data}
    np.testing.assert_array_equal(wire.samples(message), [[1, 2, 3], [4, 5, 6]])
    with pytest.raises(ValueError, match="24 bytes are not 2 rows of 16 bytes"):
        wire.samples(message | {"bins": 4})


@pytest.mark.parametrize(
    ("data", "compression"),
    [
        (b"rubbish", "zstd"), (b"rubbish", "deflate"), ("10 MB", "deflate"), ("10 MB", "zstd"),
        (zstandard.compress(b"short"), "zstd"), (bytes(12), "brotli"), (b"", "zstd"),
    ],
)  # fmt: skip
def test_packed_samples_that_are_too_many_or_nonsense_are_refused(data: bytes | str, compression: str) -> None:
    if isinstance(data, str):
        data = {"deflate": zlib.compress, "zstd": zstandard.compress}[compression](bytes(10**7), 9)
    with pytest.raises(ValueError, match="^(data|compression): "):
        wire.samples(message(0, 0, 1) | {"data": data, "compression": compression})


# spoke_rows: the one decoder of `spokes` messages: what the codec has encoded, as arrays.
ENGINE = FakeEngine(scene())
UNIT = 2.0 * np.pi / 65536  # of angles on the wire


def encoded(view: View, first: int = 3, count: int = 4) -> dict[str, object]:
    """Spokes from number 26 on, which are 3 and on within their epoch; those of 80 to 100 degrees off the bow are blind."""
    batch = SpokeBatch(Epoch("e", ENGINE, None), first, ENGINE.block(26, count), Controls())  # type: ignore[arg-type]
    return wire.unpack(NativeCodec().spokes(batch, view))


def test_rows_are_what_was_sent() -> None:
    block, rows = ENGINE.block(26, 4), SpokeRows.of(encoded(View("f32")))
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
    rows = SpokeRows.of(encoded(View("f32", spokes=2)))
    assert rows.number.tolist() == [3, 5] and rows.index.tolist() == [2, 4] and rows.samples.shape == (2, BINS)
    assert len(SpokeRows.of(encoded(View("f32", sector=(180.0, 190.0)))).number) == 0


def test_exact_angles_of_a_recording_are_taken() -> None:
    exact = [0.1, 0.2, 0.3, 0.4]
    rows = SpokeRows.of(encoded(View("f32")) | {"azimuth_rad": exact, "heading_rad": exact, "course_rad": exact})
    assert rows.azimuth.tolist() == rows.heading.tolist() == rows.course.tolist() == exact


def test_a_lost_heading_is_not_a_number() -> None:
    made = encoded(View("f32"))
    rows = SpokeRows.of(made | {"heading": [None, *made["heading"][1:]]})  # type: ignore[index]
    assert np.isnan(rows.heading).tolist() == [True, False, False, False]


def test_lengths_that_disagree_are_refused() -> None:
    with pytest.raises(ValueError, match="data"):
        SpokeRows.of(encoded(View("f32")) | {"bins": 7})
