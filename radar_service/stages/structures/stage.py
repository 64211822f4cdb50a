"""Own ship's structures: their lines of the plan, what they take from the beam, their indirect echoes and the truth of these."""

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from radar_service.echo import (
    AzimuthTimes,
    Beam,
    BeamTable,
    BeamWeightedEchoes,
    MovingEchoes,
    Visibility,
    concatenated,
    max_echo_range,
    max_power,
)
from radar_service.numerics import wrap_angle, wrap_bearing
from radar_service.radar import FAINTEST, Aperture
from radar_service.receive import receiver_noise_power
from radar_service.records import FalseEcho, Fidelity, PlanItem
from radar_service.scattering import build_scatterers, scattering_model
from radar_service.stages.effect import EffectTruth
from radar_service.stages.registry import changed_pattern
from radar_service.stages.stage import Context, Stage
from radar_service.stages.structures.reflection import HeldPassages, IndirectPaths, LitStructure, structure_reflectors
from radar_service.stages.structures.structure import Structure, TakenTable
from radar_service.trace import OcclusionScene
from radar_service.world import Scene, is_land

STRUCTURES_DB = -54.0  # of the one-way pattern against elements behind a strip (tests/stages/structures/test_shadow.py)
# Of the power of indirect echoes, abeam of the structure and farther round (tests/stages/structures/test_reflection.py):
INDIRECT_DB = 1.0
MAX_FAINT = -20.0  # dB of the noise, below which false echoes are left out: each changes a mean power by 0.04 dB at most
SPAN = 0.5  # rad of boresights computed together, at most
BORESIGHTS = 181  # over the sector that lights a structure, among which the brightest is looked for
SIDELOBE = 0.1  # one-way field of the direct beam at a target while it lights a structure elsewhere


class StructureTruth(EffectTruth):
    """The indirect echoes of a scene. Safe to call from several threads."""

    def __init__(self, scene: Scene) -> None:
        self._reflectors = structure_reflectors(scene.radar)

    def false_echoes(self, body: int, distance: float, bearing: float, heading: float) -> list[FalseEcho]:
        relative = float(wrap_angle(np.array([bearing - heading]))[0])
        indirect = [_brightest(reflector, distance, relative, heading) for reflector in self._reflectors]
        return [echo for echo in indirect if echo is not None]


def _brightest(reflector: LitStructure, distance: float, relative: float, heading: float) -> FalseEcho | None:
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


class StructureStage(Stage):
    """The indirect echoes of a scene: of bodies all round, at the azimuths at which the antenna lights a structure. All echoes
    have what structures take from the beam.

    They come from the range histories of moving echoes, with a beam of gain 1 all round. So bodies by aspect have echoes at the
    azimuths that light a structure too, where the beam has long passed them: with the aspect of its crossing (`reflection`),
    or with nodes as close as on boresight.
    """

    def __init__(
        self, scene: Scene, visibility: Visibility, paths: IndirectPaths, seed: int, direct: MovingEchoes | None
    ) -> None:
        """direct: echoes whose aspects serve; None: bodies have aspects of their own."""
        self._scene, self._paths = scene, paths
        self.is_held, self.has_echoes = direct is not None, len(visibility.scatterers) > 0
        all_round = BeamTable(np.ones_like, scene.radar.beamwidth, np.pi, SPAN)
        held = None if direct is None else HeldPassages(scene, visibility, direct.passages)
        self.indirect = MovingEchoes(scene, visibility, all_round, seed, paths=[paths], passages=held)

    @classmethod
    def of(cls, context: Context) -> Self:
        scene, fidelity, radar = context.scene, context.fidelity, context.scene.radar
        without = {*context.silent, *faint_bodies(scene, fidelity)}
        keys = [key for key in _ships(scene) if key not in without] if structure_reflectors(radar) else []
        scatterers = build_scatterers([scene.bodies[key] for key in keys], keys, context.scattering)
        visibility = Visibility(scene, scatterers, context.line_of_sight, max_echo_range(radar), fidelity.visibility_step)
        beam = Beam(radar, changed_pattern(radar, min(np.pi, fidelity.beam_extent * radar.beamwidth)))
        paths = IndirectPaths(radar, beam, context.echo_sources.get("indirect", 0))
        return cls(scene, visibility, paths, context.seed, context.moving if fidelity.held_false_echoes else None)

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        if not self._paths.are_lit(self._scene, azimuths).any():
            return concatenated([], len(azimuths.time))
        return self.indirect.echoes(azimuths)

    @classmethod
    def field_changes(
        cls, record: Sequence[Structure], aperture: Aperture, wavelength: float, extent: float
    ) -> list[TakenTable]:
        return [TakenTable(structure, aperture, wavelength, extent) for structure in record]

    @classmethod
    def truth(cls, scene: Scene, line_of_sight: OcclusionScene) -> StructureTruth:
        return StructureTruth(scene)

    @classmethod
    def plan(cls, scene: Scene, fidelity: Fidelity, microseconds: float | None) -> list[PlanItem]:
        structures, pattern = scene.radar.effects["structures"], changed_pattern(scene.radar)
        assert pattern is not None  # they change it
        losses = ", ".join(f"{each.name} {pattern.loss_db(each.bearing):.1f} dB" for each in structures)
        how = f"diffraction by black strips, summed over the aperture; two-way loss behind {losses}"
        indirect = [] if fidelity.engine == "documented" else [_indirect(scene, fidelity, microseconds)]
        return [PlanItem("structures", True, how, field_db=STRUCTURES_DB), *indirect]


def _indirect(scene: Scene, fidelity: Fidelity, microseconds: float | None) -> PlanItem:
    """How indirect echoes by structures are modelled, with their highest level behind each."""
    reflectors, ships = structure_reflectors(scene.radar), _ships(scene)
    if not reflectors:
        return PlanItem("indirect echoes", False, "no structure reflects")
    faint, count = len(faint_bodies(scene, fidelity).keys() & set(ships)), len(ships)
    levels = ", ".join(f"{each.structure.name} {40.0 * math.log10(max(each.max_field, 1e-9)):.0f} dB" for each in reflectors)
    how = f"there and back and one way by {levels} of the direct echo at most; {count - faint} of {count} bodies, land apart"
    if faint == count:
        return PlanItem("indirect echoes", False, f"{how}: all others below the noise")
    if fidelity.held_false_echoes and any(scattering_model(scene.bodies[key]).by_aspect for key in ships):
        how += "; metal has the aspect of the beam's crossing, as another look at it"
    return PlanItem("indirect echoes", True, how, power_db=INDIRECT_DB, microseconds=microseconds)


def faint_bodies(scene: Scene, fidelity: Fidelity) -> dict[int, float]:
    """The bodies whose indirect echoes stay MAX_FAINT below the noise, by index, with the highest power of these [dB of it]; none
    where the fidelity allows no error."""
    fields = [reflector.max_field for reflector in structure_reflectors(scene.radar)]
    if not fields or not scene.environment.noise or not fidelity.error_db:
        return {}
    ways = sum((field**2 + 2.0 * SIDELOBE * field) ** 2 for field in fields)
    noise = receiver_noise_power(scene.radar)
    powers = [max_power(body, scene, fidelity) * ways / noise for body in scene.bodies]
    levels = [10.0 * math.log10(power) if power > 0.0 else -math.inf for power in powers]
    return {key: level for key, level in enumerate(levels) if level < MAX_FAINT}


def _ships(scene: Scene) -> list[int]:
    return [key for key, body in enumerate(scene.bodies) if not is_land(body)]
