"""The echoes of one declared body, cell by cell (`scattering.declared_cells` computes those of all bodies together)."""

import numpy as np

from radar_service.numerics.frames import distances_from_map
from radar_service.numerics.types import Floats
from radar_service.scattering.declared_cells import MAX_STAGGER, STAGGER, CellSpacing
from radar_service.scattering.model import ScatteringContext

Echo = tuple[Floats, complex, float]


def rows_of_cells(value: Floats, share: Floats, spacing: float) -> tuple[Floats, Floats]:
    """Middles (M,) of cells, and the part (M, A) of each scatterer at `value` (A,) in each of them."""
    middle = float(np.average(value, weights=share))
    length = float(np.sqrt(12.0 * np.average((value - middle) ** 2, weights=share)))
    count = int(length / spacing) + 1
    cells = middle + spacing * (np.arange(count) - (count - 1) / 2.0)
    inside = np.clip(value, cells[0], cells[-1])
    return cells, np.array([np.maximum(0.0, 1.0 - np.abs(inside - cell) / spacing) for cell in cells])


def slow_cell_echoes(
    position: Floats,
    power: Floats,
    span: Floats,
    middle: Floats,
    antenna: Floats,
    context: ScatteringContext,
    spacing: CellSpacing,
) -> list[Echo]:
    """Position (3,), amplitude and vertical extent of each echo of a body; arguments as of `cell_echoes`, of one body."""
    share, radar, earth = power / power.sum(), context.radar, context.earth_radius
    slant = distances_from_map(position, antenna, earth)[1]
    offset = position - antenna
    bearing = np.arctan2(*(share @ offset[:, :2]))
    azimuth = np.angle(np.exp(1j * (np.arctan2(offset[:, 0], offset[:, 1]) - bearing)))
    ranges, along = rows_of_cells(slant, share, spacing.range)
    azimuths, across = rows_of_cells(azimuth, share, spacing.azimuth)
    aside = min(STAGGER * spacing.range, MAX_STAGGER * spacing.azimuth * float(share @ slant)) if len(azimuths) > 1 else 0.0
    cells = []
    for r in range(len(ranges)):
        for a in range(len(azimuths)):
            weight = along[r] * across[a] * share
            total = weight.sum()
            if total < 1e-12:  # rounding of parts that are 0
                continue
            height = weight @ position[:, 2] / total
            variance = weight @ (position[:, 2] ** 2 + span**2 / 12.0) / total - height**2
            reach, toward = ranges[r] + aside * (-1) ** a, bearing + azimuths[a]
            ground = reach
            for _ in range(3):
                ground = np.sqrt(max(reach**2 - (height - ground**2 / (2.0 * earth) - antenna[2]) ** 2, 0.0))
            place = np.array([*(antenna[:2] + ground * np.array([np.sin(toward), np.cos(toward)])), height])
            cells.append((total, reach, azimuths[a], 1j ** (r + a), place, np.sqrt(max(12.0 * variance, 0.0))))
    level = np.array([*middle[:2], sum(total * place[2] for total, _, _, _, place, _ in cells)])
    about = float(distances_from_map(level, antenna, earth)[1])
    nearest = [float(distances_from_map(place, antenna, earth)[1]) for *_, place, _ in cells]
    fields = [
        np.sqrt(total) * turn * (max(about, radar.range_min) / max(at, radar.range_min)) ** 2
        for (total, _, _, turn, _, _), at in zip(cells, nearest, strict=True)
    ]
    energy = 0.0
    for one, (_, reach, azimuth_one, *_) in zip(fields, cells, strict=True):
        for other, (_, beyond, azimuth_other, *_) in zip(fields, cells, strict=True):
            overlap = np.interp(abs(reach - beyond), *spacing.along, right=0.0)
            overlap *= np.interp(abs(azimuth_one - azimuth_other), *spacing.across, right=0.0)
            energy += float(np.real(one * overlap * np.conj(other)))
    wavenumber = 2.0 * np.pi / radar.wavelength
    return [
        (place, np.sqrt(total / energy) * turn * np.exp(2j * wavenumber * (at - about)), span_of)
        for (total, _, _, turn, place, span_of), at in zip(cells, nearest, strict=True)
    ]
