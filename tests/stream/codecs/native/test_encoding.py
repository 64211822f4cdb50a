"""The encodings of the native feed: what the wire says that they say, and which of them the controls change."""

import math

import numpy as np
import pytest

from radar_service.display.video import DB_PER_STEP, Controls, decibels, layout, noise_threshold_db
from radar_service.stream.codecs.native.encoding import encode, log_offset_db, scale

NOISE = 1.371e-15  # W, the receiver of docs/conventions.md
BY_HAND = Controls(50.0, gain_auto=False, sea_auto=False)


def cells(*levels_db: float) -> np.ndarray:
    """One spoke of power [W] at these levels above the noise threshold [dB]."""
    level = np.array(levels_db) + noise_threshold_db(NOISE)
    return (10.0 ** (level / 10.0)).astype(np.float32)[None, :]


def test_controls_act_on_u8_only() -> None:
    power = cells(10.0, 20.0, 30.0)
    field = np.sqrt(power).astype(np.complex64)
    to = layout(3, 5.0, 10.0)
    settings = Controls(80.0, 70.0, 60.0, gain_auto=False, sea_auto=False, echo_stretch=2.0, interference_rejection=True)
    for encoding in ("u8-log", "f16", "f32", "c64"):
        plain = encode(encoding, power, field, to, Controls(), NOISE)
        np.testing.assert_array_equal(encode(encoding, power, field, to, settings, NOISE), plain)
    assert np.any(encode("u8", power, field, to, settings, NOISE) != encode("u8", power, field, to, Controls(), NOISE))


def test_the_scan_before_acts_on_u8_only() -> None:
    power = cells(10.0, 20.0, 30.0)
    field, to, on = np.sqrt(power).astype(np.complex64), layout(3, 5.0, 10.0), Controls(scan_correlation=True)
    for encoding in ("u8-log", "f16", "f32", "c64"):
        plain = encode(encoding, power, field, to, Controls(), NOISE)
        np.testing.assert_array_equal(encode(encoding, power, field, to, on, NOISE, None, power / 1000), plain)
    assert np.any(encode("u8", power, field, to, on, NOISE, None, power / 1000) != encode("u8", power, field, to, on, NOISE))


def test_a_byte_is_the_middle_of_its_step() -> None:
    levels = np.array([0.01, 1.0, 20.0, 63.0])
    got = encode("u8", cells(*levels), cells(*levels).astype(np.complex64), layout(4, 5.0, 10.0), BY_HAND, NOISE)[0]
    says = scale("u8", NOISE)
    above = says["offset_db"] + got * says["db_per_step"] - noise_threshold_db(NOISE)
    np.testing.assert_allclose(above, levels, atol=DB_PER_STEP / 2 + 1e-5)  # float32 logarithms of -150 dB err by 1e-5 dB


def test_encodings_say_what_the_wire_says_they_say() -> None:
    power = np.array([[0.0, 1e-14, 3e-9, 1e3]], dtype=np.float32)
    field = np.sqrt(power).astype(np.complex64) * np.complex64(1j)
    to = layout(4, 5.0, 10.0)
    level = decibels(power)[0]
    assert np.isneginf(level[0])
    by = {e: encode(e, power, field, to, Controls(), NOISE)[0] for e in ("u8-log", "f16", "f32", "c64")}
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
        encode("png", cells(1.0), cells(1.0).astype(np.complex64), layout(1, 5.0, 10.0), Controls(), NOISE)
