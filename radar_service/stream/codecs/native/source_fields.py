"""What a `spokes` message tells of the sources of its bins: `labels`, and `powers` of `power_sources` (see `wire`)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.stream.codecs.native import wire
from radar_service.stream.codecs.native.shown_cells import shown_cells
from radar_service.stream.feed_request import View
from radar_service.stream.spokes import SpokeBatch
from radar_service.types import Indices


def source_fields(batch: SpokeBatch, view: View) -> dict[str, Any]:
    """Returns `labels` and `powers` of a batch, as far as the view requests them and the spokes tell them.

    Both are those of the cell that a bin shows.
    """
    block, to = batch.block, batch.epoch.layout(view.bins)
    labels = block.labels if view.labels else None
    powers = block.powers if view.powers else None
    if labels is None and powers is None:
        return {}
    noise_power = batch.epoch.engine.noise_power
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


def _labels_field(labels: NDArray[np.uint32]) -> dict[str, Any]:
    return {"labels": labels.astype("<u4").tobytes()}


def _powers_fields(numbers: list[int], power: NDArray[np.float32]) -> dict[str, Any]:
    """power: (rows, sources, bins)."""
    return {"power_sources": numbers, "powers": power.astype("<f4").tobytes()}
