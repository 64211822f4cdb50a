"""The antenna pattern past own ship's structures, by tables: in their shadows it is lower and wider, beside it sidelobes rise."""

from functools import cached_property, lru_cache

import numpy as np

from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Complexes, Flags, Floats, Indices
from radar_service.radar.parameters import Radar
from radar_service.radar.structure_reflection import Reflector, reflectors
from radar_service.radar.structures import MAX_ASIDE, TAPER_END, Aperture, Structure, aperture_of, fresnel_unit, taken

STEPS_PER_UNIT = 20  # of the direction, in a Fresnel unit of an edge's shadow
STEPS_PER_NULL = 36  # of the offset, in lambda / D: linear interpolation errs by (pi / 36)^2 / 8, -60 dB of boresight
ENTRIES_PER_NULL = 1024  # in lambda / D of the table of the pattern: linear interpolation errs by (pi / 1024)^2 / 8, -118 dB
MAX_ENTRIES = 2**22
ELEMENTS_PER_CYCLE = 8  # of the aperture, in a cycle of its phase at the outermost offset
MIN_ELEMENTS = 256
MAX_OFFSET = 0.5  # rad; beyond, sidelobes are as without structures
CLUTTER_STEPS = 4  # of boresight, in a beamwidth
CLUTTER_EXTENT = 4.0  # beamwidths each side that receive clutter


class TakenTable:
    """What one structure takes from the pattern, by linear interpolation in direction and offset."""

    def __init__(self, structure: Structure, aperture: Aperture, wavelength: float, extent: float) -> None:
        """extent: offset from boresight up to which the table reaches [rad]."""
        self.bearing = structure.bearing
        extent = min(extent, MAX_OFFSET)
        per_unit = float(fresnel_unit(wavelength, structure.distance))
        reach = 0.5 * aperture.length + structure.radius + TAPER_END * per_unit
        self.reach = (
            MAX_ASIDE if reach >= structure.distance else min(MAX_ASIDE, float(np.arcsin(reach / structure.distance)))
        )
        asides = 2 * int(np.ceil(self.reach * structure.distance / per_unit * STEPS_PER_UNIT)) + 1
        aside = np.linspace(-self.reach, self.reach, asides)
        offsets = 2 * int(np.ceil(extent * aperture.length / wavelength * STEPS_PER_NULL)) + 1
        offset = np.linspace(-extent, extent, offsets)
        cycles = aperture.length / wavelength * offset
        elements = max(MIN_ELEMENTS, int(np.ceil(ELEMENTS_PER_CYCLE * cycles[-1])))
        place = ((np.arange(elements) + 0.5) / elements - 0.5) * aperture.length
        lit = taken(structure, wavelength, aside, place) * aperture.illumination(place) / elements
        phase = np.exp(2j * np.pi * np.outer(place / aperture.length, cycles))
        self._field = (lit @ phase).astype(np.complex64)
        self._aside = aside[0], (asides - 1) / (2.0 * self.reach)
        self._offset, self.extent = (offset[0], (offsets - 1) / (2.0 * extent)), extent

    def subtract(self, field: Complexes, from_bow: Floats, offset: Floats) -> None:
        """Subtracts what the structure takes from a field (any shape), in place; from_bow, offset: as of `StructureShadow`."""
        aside = wrap_angle(from_bow - self.bearing)
        behind = np.nonzero((np.abs(aside) < self.reach) & (np.abs(offset) < self.extent))
        if not len(behind[0]):
            return
        (row, up), (column, right) = (
            _cells(values[behind], *axis) for values, axis in ((aside, self._aside), (offset, self._offset))
        )
        table = self._field
        lower = table[row, column] * (1.0 - right) + table[row, column + 1] * right
        upper = table[row + 1, column] * (1.0 - right) + table[row + 1, column + 1] * right
        field[behind] -= lower * (1.0 - up) + upper * up


class StructureShadow:
    """The one-way field of an antenna among the structures of its ship. Safe to call from several threads."""

    def __init__(self, aperture: Aperture, wavelength: float, structures: tuple[Structure, ...], extent: float) -> None:
        """extent: offset from boresight [rad] up to which the structures change the pattern, MAX_OFFSET at most."""
        self._aperture, self._cycles = aperture, aperture.length / wavelength
        per_radian = min(ENTRIES_PER_NULL * self._cycles, MAX_ENTRIES / np.pi)
        offset = np.arange(int(np.pi * per_radian) + 2) / per_radian
        self._pattern, self._per_radian = aperture.pattern(self._cycles * offset), per_radian
        self._tables = [TakenTable(structure, aperture, wavelength, extent) for structure in structures]

    def one_way(self, from_bow: Floats, offset: Floats) -> Complexes:
        """Field to a target far off, over that on boresight without structures; its square is the two-way field.

        from_bow: direction of the target, clockwise from the bow [rad]; offset: of that shape, from boresight to it [rad].
        """
        offset = wrap_angle(offset)
        return self._past(self._without(offset), from_bow, offset)

    def two_way_change(self, from_bow: Floats, offset: Floats) -> Complexes:
        """What the structures change of the two-way field; arguments as of `one_way`."""
        offset = wrap_angle(offset)
        without = self._without(offset)
        return self._past(without, from_bow, offset) ** 2 - without**2

    def _without(self, offset: Floats) -> Floats:
        """The one-way field without structures at offsets that are wrapped, by linear interpolation in a table."""
        entry = np.abs(offset) * self._per_radian
        below = entry.astype(np.intp)
        lower = self._pattern.take(below, mode="clip")
        return np.asarray(lower + (entry - below) * (self._pattern.take(below + 1, mode="clip") - lower))

    def _past(self, without: Floats, from_bow: Floats, offset: Floats) -> Complexes:
        """The one-way field at offsets that are wrapped, by that without structures."""
        field = without.astype(np.complex128)
        for table in self._tables:
            table.subtract(field, np.broadcast_to(from_bow, offset.shape), offset)
        return field

    def reaches(self, from_bow: Floats) -> Flags:
        """To which directions (E,) from the bow [rad] the structures change the field."""
        near = [np.abs(wrap_angle(from_bow - table.bearing)) < table.reach for table in self._tables]
        return np.asarray(np.any(near, axis=0))

    @property
    def extent(self) -> float:
        """Offset from boresight [rad] up to which they change it."""
        return max(table.extent for table in self._tables)

    def clutter_power(self, boresight: Floats) -> Floats:
        """Two-way power of what lies all round, at boresights clockwise from the bow (any shape) [rad], over that without
        structures."""
        angle, power = self._clutter
        return np.interp(boresight % (2.0 * np.pi), angle, power)

    @cached_property
    def _clutter(self) -> tuple[Floats, Floats]:
        beamwidth = 1.0 / self._cycles
        angle = np.linspace(0.0, 2.0 * np.pi, int(np.ceil(2.0 * np.pi / beamwidth * CLUTTER_STEPS)) + 1)
        offset = np.linspace(-CLUTTER_EXTENT * beamwidth, CLUTTER_EXTENT * beamwidth, 16 * int(CLUTTER_EXTENT) + 1)
        field = self.one_way(angle[:, None] + offset, np.broadcast_to(offset, (len(angle), len(offset))))
        without = self._aperture.pattern(self._cycles * offset)
        return angle, (np.abs(field) ** 4).sum(axis=1) / (without**4).sum()


def structure_shadow(radar: Radar, extent: float = MAX_OFFSET) -> StructureShadow | None:
    """The antenna of a radar among the structures of its ship; None without any. extent: as of `StructureShadow`."""
    aperture = _aperture_among_structures(radar)
    return None if aperture is None else _kept(aperture, radar.wavelength, radar.structures, min(extent, MAX_OFFSET))


def structure_reflectors(radar: Radar) -> tuple[Reflector, ...]:
    """The structures of a radar's ship that reflect."""
    aperture = _aperture_among_structures(radar)
    return () if aperture is None else reflectors(aperture, radar.wavelength, radar.structures, radar.polarization)


def _aperture_among_structures(radar: Radar) -> Aperture | None:
    """The aperture of a radar with structures; None of one without."""
    return aperture_of(radar.pattern, radar.beamwidth, radar.wavelength) if radar.structures else None


@lru_cache(maxsize=8)
def _kept(aperture: Aperture, wavelength: float, structures: tuple[Structure, ...], extent: float) -> StructureShadow:
    return StructureShadow(aperture, wavelength, structures, extent)


def _cells(values: Floats, first: float, per_radian: float) -> tuple[Indices, Floats]:
    """The entry (E,) below each value (E,), and how far on to the next one it is, from 0 to 1."""
    position = (values - first) * per_radian
    entry = position.astype(np.intp)
    return entry, position - entry
