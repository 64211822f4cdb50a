"""What a `spokes` message tells of the sources of its bins: `labels`, and `powers` of `power_sources` (see `wire`).

Both are those of the cell that a bin shows.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service import wire
from radar_service.display.video import Controls, Layout, stretch_cells, video_level_db
from radar_service.numerics.types import Indices, Profiles, Singles
from radar_service.service.feed_request import View
from radar_service.service.spokes import SpokeBatch


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

    Arguments are those of `messages.encode`. Echo stretch shows a cell also in the bins behind it.
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
