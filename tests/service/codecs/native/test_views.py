"""Sectors and merged spokes, also compressed: compared with a slow reference of one spoke at a time, and over the feed."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from clients.ppi.spoke import spokes_of
from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.service.codecs.native.views import apply_view, request_from_query, trim
from radar_service.service.feed_request import FeedRequest, View
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import running
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene

BINS = 3


def message(first: int, index: int, count: int, encoding: str = "f32") -> dict[str, Any]:
    """Spokes of a scan of 72 azimuths, 5 degrees apart, with samples that say little about their neighbours."""
    rows = np.random.default_rng(first).random((count, BINS, 2))
    data = rows @ np.array([1, 1j]) if encoding == "c64" else rows[..., 0] * 255
    k = np.arange(index, index + count)
    text = {"type": "spokes", "epoch": "e", "first": first, "count": count, "scan": 2, "index": index, "bins": BINS}
    text |= {"encoding": encoding, "data": data.astype(wire.DTYPES[encoding]).tobytes(), "time": (k * 0.5).tolist()}
    text |= {
        "azimuth": np.rint(k * wire.TURN / 72).astype(int).tolist(),
        "heading": k.tolist(),
        "position": [[float(n), 0.0] for n in k],
    }
    return text | {"course": k.tolist(), "speed": k.tolist(), "range_first_m": 5.0, "range_step_m": 10.0}


def reference_rows(made: dict[str, Any], view: View) -> list[tuple[int, int, list[complex]]]:
    """Returns (number of the first spoke, count, samples) of each row, made spoke by spoke."""
    rows: list[tuple[int, int, list[complex]]] = []
    samples = wire.samples(made)
    for k in range(made["count"]):
        bearing_deg = 5 * (made["index"] + k)
        if view.sector and not any(view.sector[0] <= bearing_deg + turn <= _end(*view.sector) for turn in (0, 360)):
            continue
        number, group = made["first"] + k, (made["index"] + k) // view.spokes
        spoke = samples[k].tolist()
        if rows and rows[-1][0] + rows[-1][1] == number and (made["index"] + k - 1) // view.spokes == group:
            first, count, kept = rows.pop()
            spoke = [old if abs(old) >= abs(new) else new for old, new in zip(kept, spoke, strict=True)]
            rows.append((first, count + 1, spoke))
        else:
            rows.append((number, 1, spoke))
    return rows


def _end(start: int, stop: int) -> int:
    return stop if stop >= start else stop + 360


def rows_of(made: dict[str, Any]) -> list[tuple[int, int, list[complex]]]:
    first = [made["first"] + offset for offset in made["row_first"]]
    return list(zip(first, made["row_count"], wire.samples(made).tolist(), strict=True))


SECTORS = st.one_of(st.none(), st.tuples(st.integers(0, 360), st.integers(0, 360)).filter(lambda s: s[0] != s[1]))


@settings(deadline=None, derandomize=True)
@given(
    index=st.integers(0, 60), count=st.integers(1, 12), sector=SECTORS, spokes=st.integers(1, 32),
    encoding=st.sampled_from(["u8", "f16", "f32", "c64"]), packing=st.sampled_from(["", "zstd", "deflate"]),
)  # fmt: skip
def test_rows_are_those_of_the_reference(
    index: int, count: int, sector: tuple[int, int] | None, spokes: int, encoding: str, packing: str
) -> None:
    view = View(encoding, BINS, sector, spokes)
    made = message(1000 + index, index, count, encoding)
    got = wire.unpack(wire.pack(wire.packed(apply_view(made, view), packing)))
    assert (got["first"], got["count"]) == (made["first"], count)
    assert rows_of(got) == reference_rows(made, view)
    for left in range(1, count + 1):
        rest = trim(got, left)
        assert rest["first"] + rest["count"] == made["first"] + count and rest["count"] == left
        held = [(first, size) for first, size, _ in rows_of(got) if first + size > rest["first"]]
        assert [(f, n) for f, n, _ in rows_of(rest)] == [
            (max(first, rest["first"]), first + size - max(first, rest["first"])) for first, size in held
        ]
        assert ("compression" in rest) == bool(packing)


def test_a_row_stands_at_the_middle_of_its_spokes() -> None:
    """Within 1.5 parts of 65536: half a part for each of two azimuths and a whole one for their mean, rounded down."""
    got = apply_view(message(0, 8, 8), View("f32", BINS, spokes=4))
    middle = (np.array([9.5, 13.5]) * wire.TURN / 72).tolist()
    assert got["azimuth"] == pytest.approx(middle, abs=1.5) and got["time"] == [4.75, 6.75]
    assert [spoke.number for spoke in spokes_of(got)] == [0, 4] and got["heading"] == [9, 13]


def test_the_middle_of_azimuths_lies_the_short_way_across_north() -> None:
    """Reported azimuths, with errors on purpose, cross north within a row."""
    reported = message(0, 0, 4) | {"azimuth": [wire.TURN - 300, wire.TURN - 100, 100, 300]}
    assert apply_view(reported, View("f32", BINS, spokes=4))["azimuth"] == [0]
    reported = message(0, 0, 2) | {"azimuth": [wire.TURN - 100, 300], "heading": [None, 5]}
    merged = apply_view(reported, View("f32", BINS, spokes=2))
    assert merged["azimuth"] == [100] and merged["heading"] == [None]


def test_a_sector_may_cross_north_and_may_be_the_whole_circle() -> None:
    whole = message(0, 0, 32) | {"azimuth": [k * wire.TURN // 32 for k in range(32)]}
    assert apply_view(whole, View("f32", BINS, (350, 12)))["row_first"] == [0, 1]
    assert len(apply_view(whole, View("f32", BINS, (0, 360)))["row_first"]) == 32
    cut_out = apply_view(message(0, 0, 12), View("f32", BINS, (30, 20), 32))  # 25 degrees is left out
    assert (cut_out["row_first"], cut_out["row_count"]) == ([0, 6], [5, 6])
    nothing = apply_view(whole, View("f32", BINS, (1, 2)))
    assert nothing["row_first"] == [] and wire.samples(nothing).shape == (0, BINS) and nothing["count"] == 32


async def test_a_filtered_feed_covers_every_number_and_resumes_without_gap_or_repeat() -> None:
    only = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("run", math.inf)))
    async with running(create_app([only])) as server:
        query = "?encoding=f32&sector=0,90&spokes=2&compress=zstd&mode=lossless"
        feed = await server.feed(query)
        hello = await feed.receive()
        assert hello["view"] == {"sector_deg": [0, 90], "spokes": 2, "compression": "zstd"}
        messages = await feed.spokes(3 * AZIMUTHS)
        assert all(a["first"] + a["count"] == b["first"] for a, b in zip(messages, messages[1:], strict=False))
        azimuths = {spoke.azimuth for m in messages for spoke in spokes_of(m)}
        assert 0 < len(azimuths) and max(azimuths) <= math.pi / 2 + 1e-3
        number = messages[1]["first"] + 1
        again = await server.feed(f"{query.replace('&mode=lossless', '')}&since={hello['epoch']}:{number}")
        assert (await again.until("spokes"))["first"] == number


@pytest.mark.parametrize(
    ("query", "is_near", "view"),
    [
        ({"sector": "350,10", "spokes": "4", "compress": "zstd"}, True, View("u8", None, (350, 10), 4, "zstd")),
        ({"compress": "auto"}, True, View("u8")), ({"compress": "auto"}, False, View("u8", compression="zstd")),
        ({"compress": "none"}, False, View("u8")), ({}, False, View("u8")),
    ],
)  # fmt: skip
def test_compression_is_off_on_this_machine_unless_requested(query: dict[str, str], is_near: bool, view: View) -> None:
    assert request_from_query(query, is_near).view == view


@pytest.mark.parametrize(
    "query", [{"sector": "1"}, {"sector": "1,361"}, {"sector": "-1,5"}, {"sector": "a,b"}, {"spokes": "0"}, {"spokes": "33"},
              {"compress": "lz4"}, {"spokes": "1e1"}, {"labels": "yes"}, {"labels": ""}, {"powers": "0,"}, {"powers": "ship"}]
)  # fmt: skip
def test_an_invalid_parameter_is_refused_with_its_name(query: dict[str, str]) -> None:
    with pytest.raises(ValueError, match=f"^{next(iter(query))}: "):
        request_from_query(query)


def test_a_query_is_read_as_it_is_written() -> None:
    query = {"encoding": "c64", "bins": "512", "truth": "1", "mode": "lossless", "since": "ab12:99"}
    assert request_from_query(query) == FeedRequest(View("c64", 512), "lossless", True, ("ab12", 99))
    told = request_from_query({"labels": "1", "powers": "257,1"}).view
    assert told == View("u8", labels=True, powers=(1, 257)) and request_from_query({"powers": "all"}).view.powers == "all"
    assert request_from_query({}) == FeedRequest(View("u8", None), "live", False, None)
