"""The truth of own ship's structures and of false echoes: losses, and where echoes stand that are no targets."""

import math

import numpy as np

from radar_service.numerics.frames import wrap_angle, wrap_bearing
from radar_service.radar.structure_reflection import Reflector
from radar_service.radar.structure_shadow import structure_reflectors, structure_shadow
from radar_service.records.truth import FalseEcho
from radar_service.world.materials import is_land
from radar_service.world.scene import Scene

FAINTEST = 1e-6  # of a one-way field: losses are -240 dB at most
BORESIGHTS = 181  # over the sector that lights a structure, among which the brightest is looked for


class FalseEchoTruth:
    """What the structures and the multiple echoes of a scene do to its bodies. Safe to call from several threads."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._shadow, self._reflectors = structure_shadow(scene.radar), structure_reflectors(scene.radar)
        self._has_any = bool(scene.radar.structures) or scene.radar.multiple is not None

    def structure_db(self, relative_bearing: float) -> float | None:
        """Two-way loss [dB] on boresight behind structures, of a target at a bearing from the bow [rad]; None without any."""
        if self._shadow is None:
            return None
        field = abs(self._shadow.one_way(np.array([relative_bearing]), np.zeros(1))[0])
        return float(-40.0 * math.log10(max(field, FAINTEST)))

    def at(self, body: int, distance: float, bearing: float, heading: float) -> tuple[FalseEcho, ...] | None:
        """The false echoes of a body, by its index in the scene, as it is at an instant; None in a scene that has none.

        distance: of its reference point [m]; bearing: of that, heading: of own ship [rad].
        """
        if not self._has_any:
            return None
        relative = float(wrap_angle(np.array([bearing - heading]))[0])
        indirect = [_indirect(reflector, distance, relative, heading) for reflector in self._reflectors]
        echoes = [echo for echo in indirect if echo is not None] + self._multiple(body, distance, bearing)
        return tuple(echo for echo in echoes if echo.range <= self._scene.radar.range_max)

    def _multiple(self, body: int, distance: float, bearing: float) -> list[FalseEcho]:
        """The second, third, ... traces of a ship near by, with their levels where her cross-section is declared."""
        multiple, ship = self._scene.radar.multiple, self._scene.bodies[body]
        if multiple is None or is_land(ship) or distance > multiple.max_range:
            return []
        level = None
        if ship.rcs is not None:
            level = 10.0 * math.log10(ship.rcs * multiple.own_rcs / (4.0 * math.pi * distance**2) ** 2)
        return [
            FalseEcho("multiple", "own ship", (1 + n) * distance, bearing, None if level is None else n * level)
            for n in range(1, multiple.orders + 1)
        ]


def _indirect(reflector: Reflector, distance: float, relative: float, heading: float) -> FalseEcho | None:
    """The echo there and back by a structure where it is brightest; None where there is none."""
    half = reflector.lit_within
    boresight = reflector.structure.bearing + np.linspace(-half, half, BORESIGHTS)
    field, ray = reflector.field(np.full((1, BORESIGHTS), relative), boresight)
    k = int(np.abs(field[0]).argmax())
    if abs(field[0, k]) < FAINTEST:
        return None
    bearing = float(wrap_bearing(np.array([boresight[k] + heading]))[0])
    level = 40.0 * math.log10(abs(field[0, k]))
    return FalseEcho("indirect", reflector.structure.name, distance + float(ray.detour[0, k]), bearing, level)
