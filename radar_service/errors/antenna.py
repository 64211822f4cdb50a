"""Errors of the angle from the bow that the antenna's encoder reports. The beam itself looks where it did."""

import numpy as np

from radar_service.errors.noise import SensorNoise
from radar_service.numerics.types import Floats, Indices
from radar_service.scene.error_settings import AntennaErrors


def backlash(from_bow: Floats) -> Floats:
    """Returns the share (K,) of the play, -1 to 1, that the wind takes up at angles from the bow (K,) [rad].

    The encoder turns with the motor; gears have play. Wind from ahead turns a flat antenna with a torque that is zero along
    and across the wind, and changes its sign four times a turn. The share follows it as a triangle wave of twice the angle,
    so that it is evenly distributed over a turn: the rectangular distribution of A.823(19), appendix 3.
    """
    return np.asarray(np.arcsin(np.sin(2.0 * from_bow)) * (2.0 / np.pi))


class AntennaLaw:
    """The errors of one antenna. seed, key: of its random generators."""

    def __init__(self, errors: AntennaErrors, seed: int, *key: int) -> None:
        self._errors = errors
        self._noise = SensorNoise(0.0, seed, *key)

    def error(self, number: Indices, time: Floats, from_bow: Floats) -> Floats:
        """Returns reported angle from the bow minus true angle (K,) [rad] of spokes of these numbers, times [s] and true
        angles from the bow (K,) [rad]."""
        its = self._errors
        error = its.misalignment + its.backlash * backlash(from_bow)
        if its.encoder_noise:
            error = error + its.encoder_noise * self._noise.at(number, time)
        if its.encoder_step:
            error = np.rint((from_bow + error) / its.encoder_step) * its.encoder_step - from_bow
        return np.asarray(error)
