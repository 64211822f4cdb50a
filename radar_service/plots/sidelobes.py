"""The sidelobe gate: a plot that is no stronger than the sidelobes of a stronger echo is not reported."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radar_service.numerics import Flags, Floats, Indices
from radar_service.plots.detections import Detections
from radar_service.radar import Radar
from radar_service.receive import compression_for, receiver_noise_power
from radar_service.records import PRESETS

MAIN_LOBE = 0.01  # of the two-way gain on boresight: sidelobes are weaker

NOISE_PEAK = 2.5  # times the mean noise amplitude: noise adds that much to a sidelobe in one cell of 500
FANOUT = 8  # detections in a box, and boxes in a larger one
STRIPE = 256  # spokes whose detections are sorted by range together: sidelobes reach farther in azimuth than in range
TOGETHER = 2048  # queries that search at once, which bounds the memory; so few pairs need no search


class SidelobeGate:
    """Knows how strong the sidelobes of a radar are at most, by their distance from an echo in azimuth and in range."""

    def __init__(self, radar: Radar, margin_db: float) -> None:
        """margin_db: sidelobes may be this much stronger than those of a point at rest."""
        self._margin = 10.0 ** (margin_db / 10.0)
        self._azimuths = radar.azimuths
        self._noise = NOISE_PEAK * np.sqrt(receiver_noise_power(radar))
        apart = np.arange(2 * radar.azimuths)  # spokes between two detections of two scans; the beam turns the shorter way
        self._azimuth = azimuth_envelope(radar)[np.minimum(apart % radar.azimuths, -apart % radar.azimuths)]
        self._again = (apart > radar.azimuths // 2) & (self._azimuth > MAIN_LOBE)  # it meets an echo again a scan later
        self._range = range_envelope(radar)

    def sidelobes(self, every: Detections, peak: Indices, plot: Indices) -> Flags:
        """Returns which plots (P,) a stronger echo explains.

        every: all detections of two consecutive scans at most. peak: the strongest of each plot (P,). plot: the number of the
        plot of each detection (C,), from 0; -1 for a detection of none.
        """
        spoke, cell, power = every.spoke[peak], every.cell[peak], every.power[peak]

        def may(query: Indices, boxes: DetectionBoxes, box: Indices) -> Flags:
            echo = every.power[boxes.strongest[box]]
            near, far = distances(spoke[query], boxes.spoke[:, box])
            across = np.maximum(self._azimuth[near], self._azimuth[far])
            across[(near <= self._azimuths) & (self._azimuths <= far)] = 1.0
            along, _ = distances(cell[query], boxes.cell[:, box])
            return self._explains(power[query], echo, across, along)

        def does(query: Indices, echo: Indices) -> Flags:
            apart, along = np.abs(every.spoke[echo] - spoke[query]), np.abs(every.cell[echo] - cell[query])
            other = ~self._again[apart] & (plot[echo] != query)
            return np.asarray(
                other & self._explains(power[query], every.power[echo], self._azimuth[apart], along), dtype=np.bool_
            )

        if (pairs := len(peak) * len(every)) > TOGETHER:
            explained = DetectionTree(every).any(len(peak), may, does)
        else:
            answers = does(*np.divmod(np.arange(pairs), max(1, len(every))))
            explained = np.asarray(answers.reshape(len(peak), len(every)).any(axis=1))
        return np.asarray(explained | (np.sqrt(power) <= self._noise), dtype=np.bool_)

    def _explains(self, power: Floats, echo: Floats, across: Floats, along: Indices) -> Flags:
        """Whether echoes of higher power [W] have sidelobes as strong as plots of this power [W].

        across: gain of the sidelobes in azimuth; along: cells from the echo.
        """
        along = np.maximum(np.minimum(along, len(self._range) - 1) - 1, 0)  # an echo stands between two cells
        level = echo * across * self._range[along]
        as_strong = np.sqrt(power) <= np.sqrt(level * self._margin) + self._noise
        return np.asarray((echo * self._margin > power) & as_strong, dtype=np.bool_)


def distances(position: Indices, interval: Indices) -> tuple[Indices, Indices]:
    """Returns the distances (P,) of positions from the nearest and the farthest number of intervals (2, P)."""
    first, last = interval
    near = np.maximum(np.maximum(first - position, position - last), 0)
    return near, np.maximum(np.abs(first - position), np.abs(last - position))


def azimuth_envelope(radar: Radar) -> Floats:
    """Returns the highest two-way gain (A // 2 + 1,) at each number of spokes from boresight and beyond, 1 at 0."""
    fine = 16
    offset = np.arange((radar.azimuths // 2) * fine + 1, dtype=np.float64) * (radar.azimuth_step / fine)
    return _envelope(radar.azimuth_gain(offset) ** 2)[::fine]


def range_envelope(radar: Radar) -> Floats:
    """Returns the highest power (N,) of a compressed echo of unit peak at each number of cells from its middle and beyond."""
    compression = compression_for(radar, PRESETS["reference"].kernel_width)
    half = radar.bins // 2
    rows = np.zeros((1, compression.size), dtype=np.complex64)
    unit_amplitude = np.ones((1, 1), dtype=np.complex64)
    compression.spread(rows, np.array([float(half)]), np.zeros((1, 1), dtype=np.float32), unit_amplitude)
    profile = np.abs(compression.profiles(rows)[0].astype(np.complex128)) ** 2
    return _envelope(profile[half:] / profile[half])


def _envelope(power: Floats) -> Floats:
    return np.asarray(np.maximum.accumulate(power[::-1])[::-1])


@dataclass(frozen=True)
class DetectionBoxes:
    """Boxes (B,) about detections. spoke, cell: from and to (2, B); strongest: number of the strongest detection in each."""

    spoke: Indices
    cell: Indices
    strongest: Indices


May = Callable[[Indices, DetectionBoxes, Indices], Flags]  # queries (P,), boxes, number of the box of each query (P,)
Does = Callable[[Indices, Indices], Flags]  # queries (P,), a detection for each (P,)


class DetectionTree:
    """Detections, searched by queries that concern strong and near ones, most of which are skipped: boxes about neighbours, boxes
    about boxes, and the strongest of each."""

    def __init__(self, detections: Detections) -> None:
        order = np.lexsort((detections.cell, detections.spoke // STRIPE))
        self._levels = [
            DetectionBoxes(np.stack([detections.spoke[order]] * 2), np.stack([detections.cell[order]] * 2), order)
        ]
        while len(self._levels[-1].strongest) > FANOUT:
            self._levels.append(_larger(self._levels[-1], detections))

    def any(self, queries: int, may: May, does: Does) -> Flags:
        """Returns whether any detection answers each query (Q,).

        may: whether some detection in a box may answer a query; does: whether a detection answers it.
        """
        parts = [np.arange(first, min(first + TOGETHER, queries)) for first in range(0, queries, TOGETHER)]
        result = np.zeros(queries, dtype=np.bool_)
        for part in parts:
            self._search(part, may, does, result)
        return result

    def _search(self, queries: Indices, may: May, does: Does, result: Flags) -> None:
        """Sets the result of some queries: from the largest boxes to the detections, without queries that are answered."""
        top = len(self._levels[-1].strongest)
        query, box = np.repeat(queries, top), np.tile(np.arange(top), len(queries))
        for level in reversed(range(len(self._levels))):
            boxes = self._levels[level]
            open_ = may(query, boxes, box)
            query, box = query[open_], box[open_]
            result[query[does(query, boxes.strongest[box])]] = True
            if level:
                query, box = query[~result[query]], box[~result[query]]
                below = box[:, None] * FANOUT + np.arange(FANOUT)
                exists = below < len(self._levels[level - 1].strongest)
                query, box = np.broadcast_to(query[:, None], below.shape)[exists], below[exists]


def _larger(boxes: DetectionBoxes, detections: Detections) -> DetectionBoxes:
    """Boxes about FANOUT boxes each."""
    count = len(boxes.strongest)
    start = np.arange(0, count, FANOUT)
    power = detections.power[boxes.strongest]
    padded = np.concatenate([power, np.full(-count % FANOUT, -1.0)]).reshape(-1, FANOUT)
    return DetectionBoxes(
        np.stack([np.minimum.reduceat(boxes.spoke[0], start), np.maximum.reduceat(boxes.spoke[1], start)]),
        np.stack([np.minimum.reduceat(boxes.cell[0], start), np.maximum.reduceat(boxes.cell[1], start)]),
        boxes.strongest[start + padded.argmax(axis=1)],
    )
