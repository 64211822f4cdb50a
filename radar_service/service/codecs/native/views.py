"""The query string of the native feed, and views of a `spokes` message that are not whole: sectors, merged neighbours.

A message after its view still covers the sequence numbers first to first + count: `row_first` is the offset at which each
of its rows begins, `row_count` the number of spokes that the row stands for. A number without a row is a spoke that the
view leaves out: it counts as delivered, not as lost.
"""

import re
from collections.abc import Mapping
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from radar_service import wire
from radar_service.display.video import Controls, Layout, stretch_cells, video_level_db
from radar_service.numerics import Indices, Profiles, Singles
from radar_service.records import powers_from_text
from radar_service.scene_file import MAX_BINS
from radar_service.service.feed_request import FeedRequest, Mode, View
from radar_service.service.spokes import SpokeBatch

PARAMETERS = ("encoding", "bins", "truth", "mode", "since", "sector", "spokes", "compress", "labels", "powers")
MAX_MERGED = 32  # spokes in a row; a message holds no more
TICKET = "ticket"  # the security layer has read it before the request arrives here
EACH_ROW = ("time", "azimuth", "heading", "position", "course", "speed", "blind")
Rows = NDArray[np.intp]


def source_fields(batch: SpokeBatch, view: View) -> dict[str, Any]:
    """Returns `labels` and `powers` of a batch, as far as the view requests them and the spokes tell them."""
    block, to = batch.block, batch.epoch.layout(view.bins)
    labels = block.labels if view.labels else None
    powers = block.powers if view.powers else None
    if labels is None and powers is None:
        return {}
    noise_power = batch.epoch.info.noise_power
    cells = shown_cells(view.encoding, block.power, block.field, to, batch.video, noise_power, batch.before, batch.earlier)
    fields = {} if labels is None else _labels_field(np.take_along_axis(labels, cells, axis=1))
    if powers is not None:
        numbers = [number for number in powers if view.powers == "all" or number in view.powers]
        shown = np.zeros((len(block), len(numbers), to.bins), dtype=np.float32)
        for k, number in enumerate(numbers):
            shown[:, k] = np.take_along_axis(powers[number], cells, axis=1)
        fields |= _powers_fields(numbers, shown)
    return fields


def fields_by_rows(message: dict[str, Any], rows: Indices) -> dict[str, Any]:
    """Returns the same fields of a message with another row in each bin. rows: (G, bins) numbers of the present rows."""
    fields: dict[str, Any] = {}
    labels, powers = wire.labels(message), wire.powers(message)
    if labels is not None:
        fields |= _labels_field(np.take_along_axis(labels, rows, axis=0))
    if powers is not None:
        shown = [np.take_along_axis(power, rows, axis=0) for power in powers.values()]
        shape = len(shown), *rows.shape
        fields |= _powers_fields(list(powers), np.array(shown, dtype=np.float32).reshape(shape).swapaxes(0, 1))
    return fields


def shown_cells(
    encoding: str, power: Singles, field: Profiles, to: Layout, controls: Controls, noise_power: float,
    before: Singles | None = None, earlier: Singles | None = None,
) -> Indices:  # fmt: skip
    """The number (K, bins) of the cell whose sample each bin shows in an encoding; the first one where several are equal.

    controls, before, earlier: as `display_video`. Echo stretch shows a cell also in the bins behind it.
    """
    if encoding == "u8":
        level = video_level_db(power, to, controls, noise_power, before, earlier)
        return _strongest_cells(level, to, stretch_cells(to, controls))
    if encoding == "c64":
        return _strongest_cells(field[:, : to.samples].real ** 2 + field[:, : to.samples].imag ** 2, to, 0)
    return _strongest_cells(power[:, : to.samples], to, 0)


def _labels_field(labels: NDArray[np.uint32]) -> dict[str, Any]:
    return {"labels": labels.astype("<u4").tobytes()}


def _powers_fields(numbers: list[int], power: Singles) -> dict[str, Any]:
    """power: (rows, sources, bins)."""
    return {"power_sources": numbers, "powers": power.astype("<f4").tobytes()}


def _strongest_cells(level: Singles, to: Layout, stretch: int) -> Indices:
    """The strongest cell of each bin (K, bins) and of `stretch` cells before it."""
    begins, ends = np.maximum(to.starts - stretch, 0), np.append(to.starts[1:], to.samples)
    cells = np.minimum(begins[:, None] + np.arange(int((ends - begins).max())), ends[:, None] - 1)
    pick = np.argmax(level[:, cells], axis=2)
    return np.asarray(cells[np.arange(to.bins), pick])


def request_from_query(query: Mapping[str, str], is_local: bool = True) -> FeedRequest:
    """Returns the request of a query string. is_local: the client runs here, and `compress=auto` means none.

    Raises ValueError that names the parameter, its value and what is allowed.
    """
    for key in query:
        if key not in (*PARAMETERS, TICKET):
            raise ValueError(f"{key[:40]}: the feed has no such parameter; it takes {', '.join(PARAMETERS)}")
    compression = _one_of("compress", query.get("compress", "none"), ("none", "auto", *wire.COMPRESSIONS))
    truth, labels = (_flag(name, query.get(name, "0")) for name in ("truth", "labels"))
    view = View(
        _one_of("encoding", query.get("encoding", "u8"), tuple(wire.DTYPES)),
        _whole("bins", query.get("bins", ""), MAX_BINS, "leave it out for every cell"),
        _sector(query.get("sector", "")),
        _whole("spokes", query.get("spokes", ""), MAX_MERGED, "leave it out for every spoke") or 1,
        {"none": "", "auto": "" if is_local else "zstd"}.get(compression, compression),
        labels=labels, powers=powers_from_text(query.get("powers", "")),
    )  # fmt: skip
    mode = cast(Mode, _one_of("mode", query.get("mode", "live"), ("live", "lossless")))
    return FeedRequest(view, mode, truth, _since(query.get("since", "")))


def _flag(name: str, text: str) -> bool:
    if text not in ("0", "1"):
        raise ValueError(f'{name}: "{text[:40]}" is not 0 or 1')
    return text == "1"


def _one_of(name: str, text: str, allowed: tuple[str, ...]) -> str:
    if text not in allowed:
        raise ValueError(f'{name}: "{text[:40]}" is not one of {", ".join(allowed)}')
    return text


def _whole(name: str, text: str, maximum: int, otherwise: str) -> int | None:
    if not text:
        return None
    if not re.fullmatch(r"[0-9]{1,6}", text) or not 1 <= int(text) <= maximum:
        raise ValueError(f'{name}: "{text[:40]}" is not a whole number from 1 to {maximum}; {otherwise}')
    return int(text)


def _sector(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    match = re.fullmatch(r"([0-9]{1,3}),([0-9]{1,3})", text)
    if not match or int(match[1]) > 360 or int(match[2]) > 360:
        raise ValueError(f'sector: "{text[:40]}" is not FROM,TO: true bearings from 0 to 360 in whole degrees, clockwise')
    return int(match[1]), int(match[2])


def _since(text: str) -> tuple[str, int] | None:
    if not text:
        return None
    match = re.fullmatch(r"([^:]{1,64}):([0-9]{1,18})", text)
    if not match:
        raise ValueError(f'since: "{text[:80]}" is not EPOCH:SEQ, the epoch and the number of the first missing spoke')
    return match[1], int(match[2])


def apply_view(message: dict[str, Any], view: View) -> dict[str, Any]:
    """Returns a `spokes` message (all its spokes, in order, not compressed) with the view's sector and merging applied."""
    samples = wire.samples(message)
    start, count = _groups(message, view)
    if "labels" in message or "powers" in message:
        message = message | fields_by_rows(message, _strongest_rows(samples, start, count))
    return message | _described(message, start, count) | {"data": _peaks(samples, start, count).tobytes()}


def trim(message: dict[str, Any], count: int) -> dict[str, Any]:
    """Returns a message, before or after its view, with only its last `count` spokes."""
    dropped = message["count"] - count
    plain, row_count = wire.unpacked(message), len(message["azimuth"])
    if "row_first" not in message:
        kept, extents = slice(dropped, None), {}
    else:
        ends = np.add(message["row_first"], message["row_count"]).astype(np.intp)
        kept = slice(int(np.searchsorted(ends, dropped, side="right")), None)
        first = np.maximum(np.array(message["row_first"][kept], dtype=np.intp) - dropped, 0)
        extents = {"row_first": first.tolist(), "row_count": (ends[kept] - dropped - first).tolist()}
    rows = {key: message[key][kept] for key in EACH_ROW if key in message}
    numbers = {"first": message["first"] + dropped, "count": count, "index": message["index"] + dropped}
    begins = {key: kept.start * (len(plain[key]) // max(1, row_count)) for key in wire.ARRAYS if key in plain}
    arrays = {key: plain[key][begin:] for key, begin in begins.items()}
    result = plain | rows | extents | numbers | arrays
    return wire.packed(result, message.get("compression", ""))


def _groups(message: dict[str, Any], view: View) -> tuple[Rows, Rows]:
    """Returns offset and length (G,) of the runs of spokes that become one row each.

    A run lies within the sector and within one group of `view.spokes` azimuths.
    """
    azimuth = np.array(message["azimuth"], dtype=np.int64)
    inside = np.ones(azimuth.shape, dtype=np.bool_)
    if view.sector is not None:
        start, stop = (round(degree * wire.TURN / 360) for degree in view.sector)  # as the azimuths are rounded
        width = (stop - start) % wire.TURN or (wire.TURN if stop != start else 0)
        inside = np.mod(azimuth - start, wire.TURN) <= width
    offset = np.flatnonzero(inside)
    group = (message["index"] + offset) // view.spokes
    begins = np.flatnonzero(np.diff(group, prepend=-1))
    if view.spokes > 1:  # the sector's edge splits a run in two
        begins = np.union1d(begins, np.flatnonzero(np.diff(offset, prepend=offset[:1] - 1) > 1))
    ends = np.append(begins[1:], len(offset))
    return offset[begins], (ends - begins).astype(np.intp)


def _described(message: dict[str, Any], start: Rows, count: Rows) -> dict[str, Any]:
    """Returns the fields of each row: time and azimuth of its middle, all else of its middle spoke."""
    last, middle = start + count - 1, start + (count - 1) // 2
    rows: dict[str, Any] = {key: [message[key][k] for k in middle] for key in EACH_ROW if key in message}
    time = [(message["time"][a] + message["time"][b]) / 2 for a, b in zip(start, last, strict=True)]
    azimuth = [_between(message["azimuth"][a], message["azimuth"][b]) for a, b in zip(start, last, strict=True)]
    return rows | {"time": time, "azimuth": azimuth, "row_first": start.tolist(), "row_count": count.tolist()}


def _between(first: int, last: int) -> int:
    """Returns the azimuth midway between two, the short way [wire units]."""
    half = wire.TURN // 2
    return int((first + ((last - first + half) % wire.TURN - half) // 2) % wire.TURN)


def _peaks(samples: NDArray[Any], start: Rows, count: Rows) -> NDArray[Any]:
    """Returns the largest sample of each group (G, bins), of complex samples the one of greatest magnitude."""
    if np.iscomplexobj(samples):
        return np.take_along_axis(samples, _strongest_rows(samples, start, count), axis=0)
    peaks: NDArray[Any] = samples[_group_rows(start, count)].max(axis=1)
    return peaks


def _strongest_rows(samples: NDArray[Any], start: Rows, count: Rows) -> Rows:
    """Returns the row (G, bins) of the largest sample of each group, the first one where several are equal."""
    groups = samples[_group_rows(start, count)]
    level = groups.real**2 + groups.imag**2 if np.iscomplexobj(samples) else groups
    return np.asarray(start[:, None] + np.argmax(level, axis=1))


def _group_rows(start: Rows, count: Rows) -> Rows:
    """Returns the rows (G, longest) of each group; the last one again where a group is shorter."""
    rows = start[:, None] + np.arange(int(count.max(initial=1)))
    return np.asarray(np.minimum(rows, (start + count - 1)[:, None]))
