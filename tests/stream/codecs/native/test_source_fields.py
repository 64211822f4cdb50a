"""Labels and powers in messages: those of the spokes, to the bit, in every view."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.cell_sources import PowersOf, SourceRequest
from radar_service.display.video import Controls
from radar_service.stream.codecs.native import messages, wire
from radar_service.stream.codecs.native.source_fields import fields_by_rows, source_fields
from radar_service.stream.codecs.native.views import apply_view, trim
from radar_service.stream.feed_request import View
from radar_service.stream.spokes import Epoch, RadarInfo, SpokeBatch
from tests.stream.fake import AZIMUTHS, BINS, FakeEngine, labels_of, scene

COUNT = 6
ENCODINGS = ["u8", "u8-log", "f16", "f32", "c64"]
EVERY = SourceRequest(True, "all")


def batch(first: int = 0, told: SourceRequest = EVERY) -> SpokeBatch:
    """Spokes whose power falls with range in every second one, so that bins show cells of either end."""
    engine = FakeEngine(scene())
    engine.request_sources(told, None)
    block = engine.block(first, COUNT)
    power = np.where((np.arange(COUNT) % 2 == 0)[:, None], block.power, block.power[:, ::-1])
    powers = None if block.powers is None else {0: np.full_like(power, 1e-15), 256: power}
    block = replace(block, power=power, field=np.sqrt(power).astype(np.complex64), powers=powers)
    return SpokeBatch(Epoch("e", engine, None), first, block, Controls(gain=0, gain_auto=False, sea_auto=False))


def message(made: SpokeBatch, view: View) -> dict[str, Any]:
    return wire.unpack(wire.pack(apply_view(messages.spokes(made, view), view)))


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
