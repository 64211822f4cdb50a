"""Multiple echoes in the engine, as further paths of the echoes of ships: their line of the plan, and their truth."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from radar_service.echo import Beam, BeamWeightedEchoes, Sights, concatenated, false_echoes
from radar_service.numerics import Complexes, Flags, Floats, Indices, Profiles
from radar_service.propagation import received_amplitude
from radar_service.radar import Radar
from radar_service.records import FalseEcho, Fidelity, PlanItem
from radar_service.stages.effect import EffectTruth
from radar_service.stages.multiple_echoes.effect import MultipleEchoes
from radar_service.stages.stage import Stage
from radar_service.trace import OcclusionScene
from radar_service.world import Scene, is_land


class MultiplePaths:
    """Echoes of ships near by that own ship throws back to them: at n times the range, each weaker than the one before.

    A wave that a ship of cross-section s at R has sent back meets own ship, of s', and returns once more: its field falls by
    root(s s') / (4 pi R^2) each time (the radar equation twice). The ship's own field, all its echoes added, is that of the
    azimuth; it counts as one echo at its centre of power, and own ship as a point below the antenna.
    """

    def __init__(self, radar: Radar, multiple: MultipleEchoes, beam: Beam, ships: Flags, source: int) -> None:
        """ships: which bodies (B,) of the scene have such echoes; source: as of `false_echoes`."""
        self._radar, self._multiple, self._beam, self._ships, self._source = radar, multiple, beam, ships, source

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The second, third, ... traces of all ships."""
        near = (echoes.body >= 0) & self._ships[echoes.body] & (echoes.range <= self._multiple.max_range)
        which = np.flatnonzero(near)
        if not len(which):
            return concatenated([], len(sights.boresight))
        chosen = echoes.chosen(which)
        beam = self._beam.field(Sights(sights.bearing[which], sights.boresight, sights.heading)) ** 2
        once_more, farther = self._once_more(chosen)
        parts, factor = [], beam
        for order in range(1, self._multiple.orders + 1):
            factor = factor * once_more
            parts.append(false_echoes(self._radar, chosen, factor, order * farther, self._source))
        return concatenated(parts, len(sights.boresight))

    def _once_more(self, echoes: BeamWeightedEchoes) -> tuple[Complexes, Floats]:
        """By what the field (E, K) changes each time, and how much farther off (E, K) it appears [m]."""
        _, ship = np.unique(echoes.body, return_inverse=True)
        distance = echoes.range[:, None] + echoes.range_migration.astype(np.float64)
        power = np.abs(echoes.amplitude) ** 2 + np.float64(np.finfo(np.float32).tiny)
        total = _sums(power, ship)
        middle = _sums(power * distance, ship) / total
        # Of the root of the ship's cross-section, with its phase:
        field = _sums(echoes.amplitude, ship) / received_amplitude(self._radar, middle)
        field *= np.sqrt(self._multiple.own_rcs) / (4.0 * np.pi * np.maximum(middle, self._radar.range_min) ** 2)
        return field[ship], middle[ship]


def _sums(values: Floats | Complexes | Profiles, group: Indices) -> Any:
    """Sums of values (E, K) over the rows of each group, by their numbers (E,) from 0 on."""
    total = np.zeros((int(group.max()) + 1, values.shape[1]), dtype=np.result_type(values.dtype, np.float64))
    np.add.at(total, group, values)
    return total


class MultipleTruth(EffectTruth):
    """The multiple echoes of a scene. Safe to call from several threads."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._multiple = scene, _of(scene)

    def false_echoes(self, body: int, distance: float, bearing: float, heading: float) -> list[FalseEcho]:
        """The second, third, ... traces of a ship near by, with their levels where its cross-section is declared."""
        multiple, ship = self._multiple, self._scene.bodies[body]
        if distance > multiple.max_range:
            return []
        level = None
        if ship.rcs is not None:
            level = 10.0 * math.log10(ship.rcs * multiple.own_rcs / (4.0 * math.pi * distance**2) ** 2)
        return [
            FalseEcho("multiple", "own ship", (1 + n) * distance, bearing, None if level is None else n * level)
            for n in range(1, multiple.orders + 1)
        ]


class MultipleStage(Stage):
    """Multiple echoes are echoes of bodies by further paths: it adds nothing else."""

    @classmethod
    def paths(cls, scene: Scene, beam: Beam, echo_sources: Mapping[str, int]) -> list[MultiplePaths]:
        ships = np.array([not is_land(body) for body in scene.bodies], dtype=np.bool_)
        return [MultiplePaths(scene.radar, _of(scene), beam, ships, echo_sources["multiple"])]

    @classmethod
    def truth(cls, scene: Scene, line_of_sight: OcclusionScene) -> MultipleTruth:
        return MultipleTruth(scene)

    @classmethod
    def plan(cls, scene: Scene, fidelity: Fidelity, microseconds: float | None) -> list[PlanItem]:
        """How they are modelled; their cost is part of that of moving echoes."""
        multiple, ships = _of(scene), sum(not is_land(body) for body in scene.bodies)
        how = (
            f"{multiple.orders} of each of {ships} ships within {multiple.max_range:g} m, by "
            f"{10 * math.log10(multiple.own_rcs):.0f} dBsm of own ship; each ship counts as one echo"
        )
        return [PlanItem("multiple echoes", ships > 0, how)]


def _of(scene: Scene) -> MultipleEchoes:
    record: MultipleEchoes = scene.radar.effects["multiple"]
    return record
