"""Scattering by radar reflectors: points whose cross-section follows the aspect by a pattern in closed form.

They turn, roll and pitch with their bodies. Of a body that moves the aspect is renewed at each visibility step.
"""

import math

import numpy as np
from typing_extensions import override

from radar_service.numerics import Floats, Indices
from radar_service.radar import Radar
from radar_service.records import Fidelity
from radar_service.scattering.fixed_scatterers import FixedScatterers
from radar_service.scattering.model import BodyEchoes, Conditions, ScatteringContext
from radar_service.scattering.reflector_patterns import highest_rcs, reflector_area, reflector_text
from radar_service.scattering.surface_sampling import Scatterers, point_scatterer
from radar_service.world import Body, PoseArrays

LOBE_DB = 1.6  # against physical optics, rms within 6 dB of a lobe's peak (tests/scattering/test_reflector_patterns.py)


class ReflectorScattering(FixedScatterers):
    """Corner, octahedral and lens reflectors. The path by the sea has the aspect of the direct one."""

    @staticmethod
    def sample(body: Body, context: ScatteringContext) -> Scatterers:
        """One point: the apex of the trihedrals, or the middle of the lens."""
        return point_scatterer(np.zeros(3))

    def visible_echoes(
        self, which: Indices, position: Floats, projected: Floats, antenna: Floats, poses: PoseArrays
    ) -> BodyEchoes:
        """One echo of each reflector, of the amplitude that its pattern has toward the antenna."""
        body, wavelength = self._body[which], self.context.radar.wavelength
        ends = np.broadcast_to(antenna, position.shape)
        direction = poses.frames_from_map(0, ends, body, self.context.earth_radius)
        direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9)
        polarization = self._polarization(direction, body, poses)
        area = np.zeros(len(body))
        for e, b in enumerate(body.tolist()):
            reflector, row = self.bodies[b].reflector, slice(e, e + 1)
            assert reflector is not None
            area[row] = reflector_area(reflector, direction[row], polarization[row], wavelength)
        amplitude = (math.sqrt(4.0 * np.pi) / wavelength * area).astype(np.complex128)
        return BodyEchoes.of_points(np.zeros(position.shape), amplitude, body)

    def _polarization(self, direction: Floats, body: Indices, poses: PoseArrays) -> Floats:
        """Unit vectors (E, 3) of the field in the frames of bodies (E,), from unit directions (E, 3) there."""
        up = np.tile((0.0, 0.0, 1.0), (len(body), 1))
        for b, rotation in poses.rotation.items():
            up[body == b] = rotation[0][2]
        level = np.cross(up, direction)
        level /= np.maximum(np.linalg.norm(level, axis=1, keepdims=True), 1e-9)
        return level if self.context.radar.polarization == "h" else np.cross(direction, level)

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """The highest of its pattern."""
        assert body.reflector is not None
        return highest_rcs(body.reflector, radar.wavelength)

    @staticmethod
    @override
    def description(body: Body, conditions: Conditions, computed: str) -> str:
        assert body.reflector is not None
        within = "" if body.reflector.kind == "lens" else f", its lobes to {LOBE_DB:g} dB"
        return f"{reflector_text(body.reflector, conditions.radar)}; a pattern in closed form{within}, {computed}"

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """None at an instant; the closed form is the model. Between two visibility steps the aspect is held."""
        return 0.0
