"""How fast the shadows of other bodies move over one, while the beam passes it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radar_service.echo.aspect_rates import NEAREST
from radar_service.numerics.types import Floats
from radar_service.scattering.model import Caster
from radar_service.scene.body import Body
from radar_service.scene.world import Scene

STEADY = 0.001  # of a body's diagonal by which the edge of a shadow may move between two nodes


@dataclass(frozen=True)
class ShadowRates:
    """The shadows on one body.

    scene: with own ship and all bodies. body: the one that is shadowed.
    """

    scene: Scene
    body: Body

    def moving(self, others: Sequence[int], time: Floats) -> list[int]:
        """Those of other bodies whose shadow may move noticeably over the body between times (K,) [s], wherever it is."""
        antenna, span = self.scene.antenna(time), float(np.ptp(time))
        moving = []
        for key in others:
            body = self.scene.bodies[key]
            nearest = float(np.hypot(*(body.middles_at(time) - antenna)[:, :2].T).min()) - body.radius
            if float(self.rate([Caster(key, nearest)], time).max()) * span > 1.0:
                moving.append(key)
        return moving

    def rate(self, casters: list[Caster], time: Floats) -> Floats:
        """How many times `STEADY` the fastest shadow moves in a second (K,) at times (K,) [s], at least two."""
        antenna = self.scene.antenna(time)
        own, spin = self._velocity(self.body, time, antenna)
        position = self.body.middles_at(time) - antenna
        distance = np.maximum(np.linalg.norm(position, axis=1), NEAREST)
        fastest = np.zeros(len(time))
        for caster in casters:
            other, other_spin = self._velocity(self.scene.bodies[caster.key], time, antenna)
            ratio = distance / max(caster.distance, NEAREST)
            edge = ratio[:, None] * other - own
            radial = np.einsum("kx,kx->k", edge, position) / distance
            across = np.sqrt(np.maximum((edge**2).sum(axis=1) - radial**2, 0.0))
            np.maximum(fastest, across + spin + ratio * other_spin, out=fastest)
        return fastest / (STEADY * self.body.diagonal)

    def _velocity(self, body: Body, time: Floats, antenna: Floats) -> tuple[Floats, Floats]:
        """Velocities (K, 3) of a body's middle against the antenna, and speeds (K,) of its parts about it [m/s]."""
        velocity = np.gradient(body.middles_at(time) - antenna, time, axis=0)
        turn = np.abs(np.gradient(np.unwrap(body.motion.pose(time).heading), time))
        return velocity, turn * body.radius + (body.top_speed - body.motion.top_speed)
