"""Scattering by declared cross-sections: of points, and of meshes over which scatterers decide what is visible."""

from functools import cached_property

import numpy as np
from typing_extensions import override

from radar_service.numerics import Flags, Floats, Indices
from radar_service.radar import Radar
from radar_service.records import Fidelity
from radar_service.scattering.declared_cells import CellEchoes, CellSpacing, cell_echoes, cell_spacing
from radar_service.scattering.fixed_scatterers import PEAK_TO_MEAN, FixedScatterers, sampled
from radar_service.scattering.model import (
    ALL_PATHS,
    NEAREST,
    BearingWedge,
    BodyEchoes,
    BodyRun,
    Conditions,
    RunError,
    ScatteringContext,
)
from radar_service.scattering.surface_sampling import Scatterers, point_scatterer, surface_db
from radar_service.world import Body, PoseArrays

TURNED_DB, WIDE_DB = 0.2, 0.4  # energy between two visibility steps: within the beam, and wider than it
MAX_DECLARED = 512  # scatterers of a declared body: they decide where its cross-section is visible, but are no echoes


class DeclaredScattering(FixedScatterers):
    """Points and bodies of a declared cross-section, which their visible scatterers share by projected area."""

    @staticmethod
    def sample(body: Body, context: ScatteringContext) -> Scatterers:
        """One point where there is no mesh, or a mesh within one resolution cell; else scatterers over the mesh."""
        if body.mesh is None:
            return point_scatterer(np.zeros(3))
        if np.hypot(body.length, body.beam) < context.radar.range_resolution:
            corners = body.mesh.used_vertices
            low, high = corners.min(axis=0), corners.max(axis=0)
            return point_scatterer((low + high) / 2.0, float(high[2] - low[2]))
        return sampled(body, context, MAX_DECLARED)

    def _in_wedge(self, poses: PoseArrays, wedge: BearingWedge | None) -> tuple[Indices, Floats]:
        """An echo may lie one spacing of cells beside all scatterers of its body."""
        if wedge is not None and len(self._body) > len(self.bodies):
            wedge = wedge._replace(half=wedge.half + self._spacing.azimuth)
        return super()._in_wedge(poses, wedge)

    def _counted(self, inside: Flags, which: Indices) -> Flags:
        """All of a body or nothing, as its scatterers share its cross-section."""
        body = self._body[which]
        shared = np.zeros(len(self.bodies), dtype=np.bool_)
        shared[body[inside]] = True
        return shared[body]

    @cached_property
    def _spacing(self) -> CellSpacing:
        """The spacing of cells."""
        return cell_spacing(self.context.radar)

    @cached_property
    def _rcs(self) -> Floats:
        """Declared cross-sections (B,) [m^2]."""
        return np.array([body.rcs for body in self.bodies], dtype=np.float64)

    def visible_echoes(
        self, which: Indices, position: Floats, projected: Floats, antenna: Floats, poses: PoseArrays
    ) -> BodyEchoes:
        """One echo for each resolution cell of a body. Together they have the energy of a point of the declared cross-section
        at the middle of the body, whatever the aspect (`declared_cells`)."""
        body, (middle, span) = self._body[which], self._heights(which, position)
        position = position.copy()
        position[:, 2] = middle
        power = np.bincount(body, projected, len(self.bodies))[body]
        alone = np.flatnonzero(self.scatterers[body] == 1)
        shared = np.flatnonzero((self.scatterers[body] > 1) & (power > 0.0))
        points = CellEchoes(body[alone], position[alone], np.ones(len(alone), dtype=np.complex128), span[alone])
        if len(shared):
            cells = self._cells(body[shared], position.take(shared, axis=0), projected[shared], span[shared], antenna, poses)
            points = CellEchoes(*(np.concatenate(column) for column in zip(points, cells, strict=True)))
        body = points.body
        own = poses.frames_from_map(0, points.position, body, np.inf)
        echoes = BodyEchoes(
            own, np.sqrt(self._rcs[body]) * points.amplitude, body, np.full(len(body), ALL_PATHS), points.span
        )
        return echoes.chosen(np.argsort(body, kind="stable"))

    def _cells(
        self, body: Indices, position: Floats, power: Floats, span: Floats, antenna: Floats, poses: PoseArrays
    ) -> CellEchoes:
        """Echoes of bodies whose scatterers (A,), by rising body, share a cross-section (`cell_echoes`)."""
        begins = np.diff(body, prepend=-1) > 0
        bodies, number = body[begins], np.cumsum(begins) - 1
        middle = poses.map_from_bodies(0, self._plan_circles[0].take(bodies, axis=0), bodies)
        cells = cell_echoes(position, power, span, number, middle, antenna, self.context, self._spacing)
        return cells._replace(body=bodies[cells.body])

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """The declared cross-section, or the peak of its fluctuation."""
        assert body.rcs is not None
        return (1.0 if body.swerling == 0 else PEAK_TO_MEAN) * body.rcs

    @staticmethod
    @override
    def description(body: Body, conditions: Conditions, computed: str) -> str:
        fluctuation = f"Swerling {body.swerling}" if body.swerling else "steady"
        return f"declared cross-section, as the scene gives one: no aspect; {fluctuation}, {computed}"

    @staticmethod
    def sampling_db(scatterers: int, multipath: bool) -> float:
        """None, as scatterers share the cross-section exactly, except in the lobes of sea reflection."""
        return surface_db(scatterers, multipath) if multipath else 0.0

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """Returns 0 for a single echo, otherwise the error of sampling a mesh [dB]."""
        if conditions.scatterers is None or conditions.scatterers <= 1:
            return 0.0
        return cls.sampling_db(conditions.scatterers, conditions.environment.multipath)

    @staticmethod
    def run_error(body: Body, conditions: Conditions, run: BodyRun) -> RunError:
        """The energy of a declared body between two visibility steps; at each of them it is exact."""
        if conditions.scatterers == 1 or run.turn == 0.0:
            return RunError()
        wide = 2.0 * body.radius > cell_spacing(conditions.radar).azimuth * max(run.approach, NEAREST)
        remark = "at its closest it is wider than the beam; " if wide else ""
        text = f"{remark}its phases change at each visibility step, its energy does not"
        return RunError(WIDE_DB if wide else TURNED_DB, (text,))
