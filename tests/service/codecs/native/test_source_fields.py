"""Labels and powers in messages: those of the spokes, to the bit, in every view; the cell that a bin shows, by a plain loop."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls, decibels, display_video, layout, sea_attenuation_db
from radar_service.records.cell_sources import PowersOf, SourceRequest
from radar_service.service.codecs.native import messages
from radar_service.service.codecs.native.messages import NativeCodec, encode
from radar_service.service.codecs.native.views import fields_by_rows, shown_cells, source_fields, trim
from radar_service.service.feed_request import View
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import AZIMUTHS, BINS, FakeEngine, labels_of, scene

COUNT = 6
ENCODINGS = ["u8", "u8-log", "f16", "f32", "c64"]
EVERY = SourceRequest(True, "all")
NOISE, CELLS = 1e-15, 97
BY_HAND = Controls(gain=80, sea=60, gain_auto=False, sea_auto=False)


def batch(first: int = 0, told: SourceRequest = EVERY) -> SpokeBatch:
    """Spokes whose power falls with range in every second one, so that bins show cells of either end."""
    engine = FakeEngine(scene())
    engine.request_sources(told.labels, told.powers)
    block = engine.block(first, COUNT)
    power = np.where((np.arange(COUNT) % 2 == 0)[:, None], block.power, block.power[:, ::-1])
    powers = None if block.powers is None else {0: np.full_like(power, 1e-15), 256: power}
    block = replace(block, power=power, field=np.sqrt(power).astype(np.complex64), powers=powers)
    return SpokeBatch(Epoch("e", engine, None), first, block, Controls(gain=0, gain_auto=False, sea_auto=False))


def message(made: SpokeBatch, view: View) -> dict[str, Any]:
    return wire.unpack(NativeCodec().spokes(made, view))


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("compression", ["", "zstd", "deflate"])
def test_every_cell_has_the_label_and_the_powers_of_the_spoke(encoding: str, compression: str) -> None:
    made = batch()
    told = message(made, View(encoding, compression=compression, labels=True, powers="all"))
    np.testing.assert_array_equal(wire.labels(told), labels_of(np.arange(COUNT), BINS))
    powers = wire.powers(told)
    assert powers is not None and list(powers) == [0, 256] and powers[256].tobytes() == made.block.power.tobytes()
    plain = message(made, View(encoding, compression=compression))
    assert {key: value for key, value in told.items() if key not in ("labels", "powers", "power_sources")} == plain


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_bin_has_those_of_the_cell_that_it_shows(encoding: str) -> None:
    """The strongest cell of five is the last one in even spokes, the first one in odd ones."""
    told = message(batch(), View(encoding, 4, labels=True, powers=(256, 999)))
    cell = np.where((np.arange(COUNT) % 2 == 0)[:, None], 5 * np.arange(4) + 4, 5 * np.arange(4))
    np.testing.assert_array_equal(wire.labels(told), np.take_along_axis(labels_of(np.arange(COUNT), BINS), cell, axis=1))
    powers = wire.powers(told)
    assert powers is not None and told["power_sources"] == [256]
    np.testing.assert_array_equal(powers[256], np.take_along_axis(batch().block.power, cell, axis=1))


@pytest.mark.parametrize("encoding", ["f32", "c64"])
def test_a_merged_row_has_those_of_the_spoke_that_it_shows(encoding: str) -> None:
    made = batch()
    told = message(made, View(encoding, spokes=3, sector=(0, 60), labels=True, powers="all", compression="zstd"))
    assert told["row_first"] == [0, 3] and told["row_count"] == [3, 2]
    labels, powers = wire.labels(told), wire.powers(told)
    assert labels is not None and powers is not None
    for row, spokes in enumerate(([0, 1, 2], [3, 4])):
        for bin_ in range(BINS):
            shown = max(spokes, key=lambda k: made.block.power[k, bin_])
            assert labels[row, bin_] == labels_of([shown], BINS)[0, bin_]
            assert powers[256][row, bin_] == made.block.power[shown, bin_]


@pytest.mark.parametrize("view", [View("f32", labels=True, powers="all"), View("u8", 4, (0, 60), 2, "zstd", labels=True)])
def test_the_end_of_a_message_has_the_end_of_its_labels(view: View) -> None:
    whole = message(batch(AZIMUTHS), view)
    for left in range(1, COUNT + 1):
        rest = wire.unpack(wire.pack(trim(whole, left)))
        dropped = len(whole["azimuth"]) - len(rest["azimuth"])
        all_labels, all_powers = wire.labels(whole), wire.powers(whole)
        assert all_labels is not None
        np.testing.assert_array_equal(wire.labels(rest), all_labels[dropped:])
        for number, power in (wire.powers(rest) or {}).items():
            assert all_powers is not None
            np.testing.assert_array_equal(power, all_powers[number][dropped:])
        assert ("powers" in rest) == ("powers" in whole)


@pytest.mark.parametrize(
    ("told", "view", "keys"),
    [
        (SourceRequest(), View("f32", labels=True, powers="all"), set()), (EVERY, View("f32"), set()),
        (SourceRequest(True), View("f32", labels=True, powers="all"), {"labels"}),
        (SourceRequest(False, "all"), View("f32", labels=True, powers=(256,)), {"powers", "power_sources"}),
        (EVERY, View("f32", labels=True), {"labels"}), (EVERY, View("f32", powers=(256,)), {"powers", "power_sources"}),
    ],
)  # fmt: skip
def test_a_message_has_what_is_requested_and_told(told: SourceRequest, view: View, keys: set[str]) -> None:
    made = batch(told=told)
    assert set(source_fields(made, view)) == keys == set(message(made, view)) & {"labels", "powers", "power_sources"}


def test_no_row_has_no_labels() -> None:
    whole = messages.spokes(batch(), View("f32", labels=True, powers="all"))
    nothing = whole | fields_by_rows(whole, np.zeros((0, BINS), dtype=np.intp)) | {"azimuth": []}
    labels, powers = wire.labels(nothing), wire.powers(nothing)
    assert labels is not None and powers is not None
    assert nothing["labels"] == b"" and labels.shape == powers[256].shape == (0, BINS)


@pytest.mark.parametrize(("key", "value"), [("labels", b"123"), ("powers", b""), ("power_sources", [1])])
def test_arrays_of_another_size_are_refused(key: str, value: Any) -> None:
    whole = message(batch(), View("f32", labels=True, powers="all")) | {key: value}
    with pytest.raises(ValueError, match=r"bytes are not 6 rows of"):
        wire.labels(whole)
        wire.powers(whole)


@pytest.mark.parametrize("powers", ["all", (256,)])
def test_the_hello_names_the_sources_for_those_who_ask(powers: PowersOf) -> None:
    radar = RadarInfo("0", "r", batch().epoch, 0.0, {"pace": {}}, True)
    plain = messages.hello(radar, View("f32"), "live")
    told = messages.hello(radar, View("f32", labels=True, powers=powers), "live")
    assert told.keys() - plain.keys() == {"sources"} and told["sources"][2] == {"number": 256, "name": "buoy"}
    assert told["view"] == plain["view"] | {"labels": True, "powers": powers if powers == "all" else [256]}


def spokes(seed: int = 0) -> np.ndarray:
    """Power [W] of cells that say little about their neighbours."""
    return (1e-13 * 10.0 ** np.random.default_rng(seed).uniform(-3, 3, (4, CELLS))).astype(np.float32)


@pytest.mark.parametrize("encoding", ["u8-log", "f16", "f32", "c64"])
@pytest.mark.parametrize("bins", [None, 96, 40, 7, 1])
def test_it_is_the_strongest_cell_of_the_bin(encoding: str, bins: int | None) -> None:
    power = spokes()
    field, to = (np.sqrt(power) * np.exp(1j * np.arange(CELLS))).astype(np.complex64), layout(CELLS, 5.0, 10.0, bins, 900.0)
    cells = shown_cells(encoding, power, field, to, Controls(), NOISE, None)
    sent = encode(encoding, power, field, to, NOISE)
    assert cells.shape == (4, to.bins) == sent.shape
    for k in range(4):
        for b in range(to.bins):
            group = [n for n in range(to.samples) if math.floor((n + 0.5) * to.bins / to.samples) == b]
            assert cells[k, b] == max(group, key=lambda n: power[k, n])
    if encoding == "c64":
        np.testing.assert_array_equal(sent, np.take_along_axis(field, cells, axis=1))


@pytest.mark.parametrize("stretch", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("bins", [None, 40, 7])
def test_video_shows_the_cell_that_is_strongest_after_the_controls(bins: int | None, stretch: float) -> None:
    """Sea control makes near cells weaker, echo stretch shows cells also behind them."""
    power, to = spokes(1), layout(CELLS, 5.0, 10.0, bins)
    controls = Controls(gain=80, sea=60, gain_auto=False, sea_auto=False, echo_stretch=stretch)
    cells = shown_cells("u8", power, power.astype(np.complex64), to, controls, NOISE, None)
    lengthened = math.ceil(0.01 * stretch * CELLS)
    level = decibels(power) - sea_attenuation_db(5.0 + 10.0 * np.arange(CELLS), 60.0).astype(np.float32)
    for k in range(4):
        for b in range(to.bins):
            group = [n for n in range(CELLS) if math.floor((n + 0.5) * to.bins / CELLS) == b]
            shown = range(max(0, group[0] - lengthened), group[-1] + 1)
            assert cells[k, b] == max(shown, key=lambda n: level[k, n])
    byte = display_video(power, layout(CELLS, 5.0, 10.0), Controls(**vars(controls) | {"echo_stretch": 0.0}), NOISE)
    np.testing.assert_array_equal(display_video(power, to, controls, NOISE), np.take_along_axis(byte, cells, axis=1))


def test_scan_correlation_decides_too() -> None:
    """A cell that was not there in the scan before is shown below its neighbour that was."""
    power = np.full((1, 2), 1e-12, dtype=np.float32) * np.array([[2.0, 1.0]], dtype=np.float32)
    to, field = layout(2, 5.0, 10.0, 1), power.astype(np.complex64)
    controls = Controls(gain=80, gain_auto=False, sea_auto=False, scan_correlation=True)
    before = power * np.array([[1e-3, 1.0]], dtype=np.float32)
    assert shown_cells("u8", power, field, to, controls, NOISE, earlier=None).tolist() == [[0]]
    assert shown_cells("u8", power, field, to, controls, NOISE, earlier=before).tolist() == [[1]]


def test_of_equal_cells_the_first_one_is_shown() -> None:
    power = np.ones((1, 6), dtype=np.float32)
    to = layout(6, 5.0, 10.0, 2)
    assert shown_cells("f32", power, power.astype(np.complex64), to, Controls(), NOISE, None).tolist() == [[0, 3]]
    nothing = np.zeros_like(power)
    assert shown_cells("u8", nothing, nothing.astype(np.complex64), to, BY_HAND, NOISE, None).tolist() == [[0, 3]]
