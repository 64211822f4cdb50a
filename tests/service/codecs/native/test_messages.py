"""The native codec: each message by its fields, what its encodings say, and a real point target through each of them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import DB_PER_STEP, Controls, decibels, display_video, layout, noise_threshold_db
from radar_service.records.spokes import SpokeBlock
from radar_service.scene_file.load import load_scene
from radar_service.service.codecs.native import messages
from radar_service.service.codecs.native.messages import NativeCodec, encode, log_offset_db, scale
from radar_service.service.feed_request import View
from radar_service.service.spokes import Epoch, SpokeBatch
from radar_service.simulator import Simulator
from tests.service.fake import BINS, FakeEngine, power_of, scene

DEGREE = math.pi / 180
NOISE = 1.371e-15  # W, the receiver of docs/conventions.md
BY_HAND = Controls(50.0, gain_auto=False, sea_auto=False)
CODEC = NativeCodec()
EPOCH = Epoch("e", FakeEngine(scene()), None)
BATCH = SpokeBatch(EPOCH, 100, FakeEngine(scene()).block(6, 4), Controls())


def cells(*levels_db: float) -> np.ndarray:
    """One spoke of power [W] at these levels above the noise threshold [dB]."""
    level = np.array(levels_db) + noise_threshold_db(NOISE)
    return (10.0 ** (level / 10.0)).astype(np.float32)[None, :]


def test_a_byte_is_the_middle_of_its_step() -> None:
    levels = np.array([0.01, 1.0, 20.0, 63.0])
    got = display_video(cells(*levels), layout(4, 5.0, 10.0), BY_HAND, NOISE)[0]
    says = scale("u8", NOISE)
    above = says["offset_db"] + got * says["db_per_step"] - noise_threshold_db(NOISE)
    np.testing.assert_allclose(above, levels, atol=DB_PER_STEP / 2 + 1e-5)  # float32 logarithms of -150 dB err by 1e-5 dB


def test_encodings_say_what_the_wire_says_they_say() -> None:
    power = np.array([[0.0, 1e-14, 3e-9, 1e3]], dtype=np.float32)
    field = np.sqrt(power).astype(np.complex64) * np.complex64(1j)
    to = layout(4, 5.0, 10.0)
    level = decibels(power)[0]
    assert np.isneginf(level[0])
    by = {e: encode(e, power, field, to, NOISE)[0] for e in ("u8-log", "f16", "f32", "c64")}
    assert by["u8-log"][0] == 0 and by["u8-log"][3] == 255
    says = scale("u8-log", NOISE)
    np.testing.assert_allclose(
        says["offset_db"] + by["u8-log"][1:3] * says["db_per_step"], level[1:3], atol=says["db_per_step"] / 2 + 1e-4
    )
    np.testing.assert_array_equal(by["f16"], level.astype(np.float16))
    np.testing.assert_array_equal(by["f32"], power[0])
    np.testing.assert_array_equal(by["c64"], field[0])
    assert [by[e].dtype.str for e in ("u8-log", "f16", "f32", "c64")] == ["|u1", "<f2", "<f4", "<c8"]


def test_scales_reach_from_the_noise_to_a_ship_alongside() -> None:
    noise_db = 10 * math.log10(NOISE)
    first_step_db = scale("u8", NOISE)["offset_db"] + 0.5 * DB_PER_STEP  # its lower edge: where cells begin to show
    assert first_step_db - noise_db == pytest.approx(10 * math.log10(math.log(1e4)), abs=1e-9)
    assert -21 < log_offset_db(NOISE) - noise_db <= -20


def test_an_unknown_encoding_is_refused() -> None:
    with pytest.raises(ValueError, match='"png" is not one of'):
        encode("png", cells(1.0), cells(1.0).astype(np.complex64), layout(1, 5.0, 10.0), NOISE)


def test_spokes_carry_numbers_of_the_epoch_and_rows_of_the_scan() -> None:
    message = wire.unpack(CODEC.spokes(BATCH, View("f32")))
    assert (message["first"], message["count"], message["index"], message["scan"]) == (100, 4, 6, 0)
    np.testing.assert_array_equal(wire.samples(message), power_of(6 + np.arange(4), BINS))


@pytest.mark.parametrize("compression", ["zstd", "deflate"])
def test_a_whole_view_has_rows_as_they_are(compression: str) -> None:
    plain, message = (wire.unpack(CODEC.spokes(BATCH, View("f32", compression=each))) for each in ("", compression))
    assert "row_first" not in plain and "compression" not in plain
    assert message["compression"] == compression and message["data"] != plain["data"] and wire.unpacked(message) == plain


def test_notices_have_these_fields() -> None:
    assert wire.unpack(CODEC.gap("e", 3, 2, "x")) == {"type": "gap", "epoch": "e", "first": 3, "count": 2, "reason": "x"}
    assert wire.unpack(CODEC.bye("e", "x")) == {"type": "bye", "epoch": "e", "reason": "x"}
    truth = wire.unpack(CODEC.truth("e", EPOCH.spoke_source.truth(2.5)))
    assert (truth["type"], truth["epoch"], truth["time"], len(truth["bodies"])) == ("truth", "e", 2.5, 1)


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
