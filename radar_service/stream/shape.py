"""What a view makes of a `spokes` message: a sector of it, neighbouring spokes merged by their peaks, its samples packed.

A shaped message still covers numbers first to first + count; `row_first` says at which offset each of its rows begins,
`row_count` for how many spokes it stands. Numbers without a row are those that
the view did not ask for: they are not lost.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.stream import wire
from radar_service.stream.mailbox import View

EACH_ROW = ("time", "azimuth", "heading", "position", "course", "speed", "blind")
Rows = NDArray[np.intp]


def shaped(message: dict[str, Any], view: View) -> dict[str, Any]:
    """A `spokes` message (all its spokes, in order) as the view wants it."""
    if view.sector is not None or view.spokes > 1:
        samples = wire.samples(message)
        start, count = _groups(message, view)
        message = message | _described(message, start, count) | {"data": _peaks(samples, start, count).tobytes()}
    return wire.packed_samples(message, view.compression) if view.compression else message


def cut(message: dict[str, Any], count: int) -> dict[str, Any]:
    """A message, shaped or not, cut down to its last `count` spokes."""
    left_out = message["count"] - count
    data = wire.samples(message).tobytes() if "compression" in message else message["data"]
    row = len(data) // max(1, len(message["azimuth"]))
    if "row_first" not in message:
        kept, more = slice(left_out, None), {}
    else:
        ends = np.add(message["row_first"], message["row_count"]).astype(np.intp)
        kept = slice(int(np.searchsorted(ends, left_out, side="right")), None)
        first = np.maximum(np.array(message["row_first"][kept], dtype=np.intp) - left_out, 0)
        more = {"row_first": first.tolist(), "row_count": (ends[kept] - left_out - first).tolist()}
    rows = {key: message[key][kept] for key in EACH_ROW if key in message}
    changed = {"first": message["first"] + left_out, "count": count, "index": message["index"] + left_out}
    plain = {key: value for key, value in message.items() if key != "compression"}
    made = plain | rows | more | changed | {"data": data[kept.start * row :]}
    return wire.packed_samples(made, message["compression"]) if "compression" in message else made


def _groups(message: dict[str, Any], view: View) -> tuple[Rows, Rows]:
    """Offset and length (G,) of the runs of spokes that become a row: in the sector, in one group of `spokes` azimuths."""
    azimuth = np.array(message["azimuth"], dtype=np.int64)
    inside = np.ones(azimuth.shape, dtype=np.bool_)
    if view.sector is not None:
        start, stop = (round(degree * wire.TURN / 360) for degree in view.sector)  # as the azimuths are rounded
        width = (stop - start) % wire.TURN or (wire.TURN if stop != start else 0)
        inside = np.mod(azimuth - start, wire.TURN) <= width
    offset = np.flatnonzero(inside)
    group = (message["index"] + offset) // view.spokes
    begins = np.flatnonzero(np.diff(group, prepend=-1))
    if view.spokes > 1:  # a run that the sector has interrupted is two
        begins = np.union1d(begins, np.flatnonzero(np.diff(offset, prepend=offset[:1] - 1) > 1))
    ends = np.append(begins[1:], len(offset))
    return offset[begins], (ends - begins).astype(np.intp)


def _described(message: dict[str, Any], start: Rows, count: Rows) -> dict[str, Any]:
    """The fields of each row: time and azimuth of its middle, the rest as of its middle spoke."""
    last, middle = start + count - 1, start + (count - 1) // 2
    rows: dict[str, Any] = {key: [message[key][k] for k in middle] for key in EACH_ROW if key in message}
    time = [(message["time"][a] + message["time"][b]) / 2 for a, b in zip(start, last, strict=True)]
    azimuth = [(message["azimuth"][a] + message["azimuth"][b]) // 2 for a, b in zip(start, last, strict=True)]
    return rows | {"time": time, "azimuth": azimuth, "row_first": start.tolist(), "row_count": count.tolist()}


def _peaks(samples: NDArray[Any], start: Rows, count: Rows) -> NDArray[Any]:
    """The largest sample of each group (G, bins), of complex ones that of greatest magnitude."""
    longest = int(count.max(initial=1))
    rows = np.minimum(start[:, None] + np.arange(longest), (start + count - 1)[:, None])
    groups = samples[rows]
    if not np.iscomplexobj(samples):
        most: NDArray[Any] = groups.max(axis=1)
        return most
    pick = np.argmax(groups.real**2 + groups.imag**2, axis=1)
    return np.take_along_axis(groups, pick[:, None], axis=1)[:, 0]
