"""The tidal stream: what a ship that keeps course and speed over ground does through the water.

A stream is the velocity (2,) of the water over ground, east and north [m/s]. Velocity through the water is that over ground less
the stream.
"""

import numpy as np

from radar_service.numerics import Floats, wrap_bearing

Stream = tuple[float, float]
NO_STREAM: Stream = (0.0, 0.0)


def crab_angle(velocity: Floats, stream: Stream) -> Floats:
    """Returns course through the water minus course over ground (...) [rad, -pi to pi] at velocities (..., 2 or more) [m/s].

    It is 0 for what stands over ground, and for what drifts with the stream: these have one course alone.
    """
    east, north = velocity[..., 0] - stream[0], velocity[..., 1] - stream[1]
    ahead = east * velocity[..., 0] + north * velocity[..., 1]
    aside = east * velocity[..., 1] - north * velocity[..., 0]  # + 0.0 below: the angle of (-0.0, 0.0) would be pi
    return np.asarray(np.arctan2(aside + 0.0, ahead + 0.0))


def turn_factor(velocity: Floats, stream: Stream) -> Floats:
    """Returns how many times as fast (...) the course through the water turns as that over ground, at a constant speed over
    ground: v (v - c) / |v - c|^2, the derivative of the course of v - c; 1 where `crab_angle` is 0 by definition."""
    east, north = velocity[..., 0] - stream[0], velocity[..., 1] - stream[1]
    square = east**2 + north**2
    ahead = east * velocity[..., 0] + north * velocity[..., 1]
    defined = (square > 0.0) & (np.hypot(velocity[..., 0], velocity[..., 1]) > 0.0)
    return np.divide(ahead, square, out=np.ones_like(square), where=defined)


def through_water(velocity: Floats, heading: Floats, stream: Stream) -> tuple[Floats, Floats]:
    """Returns course (...) [rad, 0 to 2 pi) and speed (...) [m/s] through the water at velocities (..., 2 or more) [m/s].

    heading: (...) [rad], which is the course of what does not move through the water.
    """
    east, north = velocity[..., 0] - stream[0], velocity[..., 1] - stream[1]
    speed = np.hypot(east, north)
    return wrap_bearing(np.where(speed > 0.0, np.arctan2(east, north), heading)), speed
