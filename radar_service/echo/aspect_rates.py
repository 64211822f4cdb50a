"""How fast the aspect of a body changes the phases of its echoes, and where it has corners.

An echo stands for `coherence` metres of the body. Their ends change their phase against its middle at the rate omega, which is
k coherence x (rate of the line of sight in the body's frame). Roll and pitch turn its height, `upright`, instead.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radar_service.numerics import Floats, Indices
from radar_service.scattering import NEAREST
from radar_service.world import Body, Scene

JUMP_PHASE = 0.02  # rad: jumps of the phase at the ends of an echo below it are no corners
KINK_PHASE = 0.16  # rad: what a rate that jumps changes from one node to the next; cubics across it err by a tenth


@dataclass(frozen=True)
class AspectRates:
    """The aspect of one body.

    scene: with own ship, the radar and the sea.
    body: of the scene.
    radius: of the body [m]. size: its longest extent [m].
    coherence: size [m] of what an echo stands for, at a distance [m]. upright: its height.
    """

    scene: Scene
    body: Body
    radius: float
    size: float
    coherence: Callable[[float], float]
    upright: Callable[[float], float]

    def track(self, time: Floats) -> tuple[Floats, Floats]:
        """Middle of the body relative to the antenna (K, 3) [m] and its heading (K,) [rad] at each time (K,) [s]."""
        return self.body.middles_at(time) - self.scene.antenna(time), self.body.motion.pose(time).heading

    def phase_rate(self, time: Floats) -> Floats:
        """Rates (K,) [rad/s] at which the ends of what an echo stands for change their phase against its middle.

        time: (K,) [s], at least two, without a corner between them.
        """
        position, heading = self.track(time)
        distance = np.linalg.norm(position, axis=1)
        velocity = np.gradient(position, time, axis=0)
        radial = np.einsum("ij,ij->i", velocity, position) / np.maximum(distance, 1e-9)
        speed = np.linalg.norm(velocity, axis=1)
        across = np.sqrt(np.maximum(speed**2 - radial**2, 0.0)) + np.abs(radial) * np.minimum(1.0, self.radius / distance)
        nearest = np.maximum(distance - self.radius, NEAREST)
        rate = np.abs(np.gradient(np.unwrap(heading), time)) + np.minimum(across, speed) / nearest
        antenna_height, middle = self.scene.radar.height, float(distance[len(distance) // 2])
        if self.scene.environment.multipath:
            rate += 2.0 * antenna_height * np.abs(radial) / nearest**2  # of the reflected ray against the direct one
        rate *= self._phase_per_radian(self.coherence(middle))
        if self.body.motion.sway is not None:
            sway_rates = self.body.motion.sway_rates(time).T
            rate += self._phase_per_radian(self.upright(middle)) * self._tilt_rate(position, heading, nearest, sway_rates)
            rise = waterline_rise(self.body, sway_rates)
            rate += 8.0 * np.pi / self.scene.radar.wavelength * rise * antenna_height / nearest
        return np.asarray(rate)

    def corners(self, time: Floats, spacing: float) -> Indices:
        """Indices (C,) of the times (K,) [s], evenly apart, whose aspect does not follow smoothly from the time before.

        spacing: how many times nodes are apart at most.
        """
        begins = np.flatnonzero(self.body.motion.corners(time) | self.scene.own_ship.corners(time)) + 1
        begins = begins[(begins > 1) & (begins < len(time) - 1)]
        if not len(begins):
            return begins
        position, heading = self.track(time)
        aspect = np.unwrap(heading - np.arctan2(position[:, 0], position[:, 1]))
        distance = float(np.linalg.norm(position[len(position) // 2]))
        step = np.diff(aspect) * self._phase_per_radian(self.coherence(distance))
        jump = np.abs(step[begins - 1] - (step[begins - 2] + step[begins]) / 2.0)
        kink = np.abs(step[begins] - step[begins - 2])
        fastest = np.abs(np.delete(step, begins - 1)).max()
        return np.asarray(begins[(jump > JUMP_PHASE) | (kink * min(spacing, 1.0 / max(fastest, 1e-12)) > KINK_PHASE)])

    def _phase_per_radian(self, size: float) -> float:
        """Change of phase at the ends of what an echo stands for, of a size [m], while the body turns by 1 rad [rad]."""
        return 2.0 * np.pi / self.scene.radar.wavelength * min(self.size, size)

    def _tilt_rate(self, position: Floats, heading: Floats, nearest: Floats, sway_rates: Floats) -> Floats:
        """Rates (K,) [rad/s] at which roll and pitch turn the body against the line of sight. A rotation about the line of
        sight changes no phase.

        position: (K, 3) relative to the antenna [m]; nearest: distance of the nearest part (K,) [m]; sway_rates: (4, K or 1)
        about its swings.
        """
        sway = self.body.motion.sway
        assert sway is not None
        roll, pitch, _, _ = sway_rates
        off_bow = np.arctan2(position[:, 0], position[:, 1]) - heading
        spread = (self.radius + np.abs(position[:, 2]) + self.scene.radar.height) / nearest + np.sin(sway.max_tilt)
        about_bow, about_beam = (np.minimum(np.abs(part) + spread, 1.0) for part in (np.sin(off_bow), np.cos(off_bow)))
        return np.asarray(roll * about_bow + pitch * about_beam)


def waterline_rise(body: Body, sway_rates: Floats) -> Floats:
    """The highest speeds (K) [m/s] at which a swaying body rises through the sea at its waterline; 0 where it has none.

    sway_rates: (4, K) about its swings [rad/s, m/s].

    The waterline stays at the sea: its echoes leave those of the body by 2 k z sin(elevation). Twice that is counted: else a
    heaving hull errs by up to -7 dB between nodes, and now by -23 dB (tests/test_sway_of_bodies.py).
    """
    sway = body.motion.sway
    assert sway is not None and body.mesh is not None
    lowest = float(body.motion.position[:, 2].min() + body.mesh.vertices[:, 2].min())
    if lowest > sway.max_heave + body.arm * np.sin(sway.max_tilt):
        return np.zeros(1)
    aside, ahead = np.abs(body.mesh.vertices[:, :2]).max(axis=0)
    roll, pitch, _, heave = sway_rates
    return np.asarray(heave + aside * roll + ahead * pitch)
