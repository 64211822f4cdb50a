"""Aspects rounded for traces that are kept from scan to scan."""

import math

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_body
from radar_service.scattering.physical_optics.rounded_aspect import RoundedAspect, rounded_distance
from radar_service.world.poses import BodyPose

STEP = math.radians(0.2)


@pytest.mark.parametrize("height", [3.0, 15.0, 60.0])
def test_elevation_and_parts_are_off_by_a_fortieth_of_a_degree_at_most(height: float) -> None:
    """Half of 0.05 degrees, and far off half an eighth of an octave, which is less there."""
    for distance in np.geomspace(30.0, 40_000.0, 3000).tolist():
        rounded = rounded_distance(distance, height)
        assert abs(math.degrees(height / distance - height / rounded)) < 0.02501
        assert abs(math.log2(rounded / distance)) < 1.0 / 16.0 + 1e-9 or math.degrees(height / distance) > 0.5


def test_the_aspect_is_that_of_the_body_wherever_it_is_and_heads() -> None:
    """By sines of the differences of unit vectors: the antenna lies within half a step of where the body has it."""
    draw = np.random.default_rng(3)
    for _ in range(200):
        pose = BodyPose(np.append(draw.uniform(-5e3, 5e3, 2), draw.uniform(-2, 2)), float(draw.uniform(-4.0, 8.0)))
        toward = np.append(draw.uniform(-4e3, 4e3, 2), 0.0)
        antenna = map_from_body(toward, pose.position, pose.heading)
        antenna[2] = 15.0
        aspect = RoundedAspect.of(antenna, pose, STEP, np.zeros(3), 40.0)
        assert (aspect.height, aspect.level) == (15.0, pose.position[2])
        synthetic = aspect.antenna[:2] / np.hypot(*aspect.antenna[:2])
        off = synthetic[0] * toward[1] - synthetic[1] * toward[0]
        assert abs(off) <= math.sin(STEP / 2.0) * np.hypot(*toward[:2]) * (1.0 + 1e-9)
        assert synthetic @ toward[:2] > 0.0
        assert aspect.pose.heading == 0.0 and aspect.pose.position[2] == pose.position[2]


def test_each_part_of_a_ship_turns_little_however_near_she_is_and_wherever_her_frame() -> None:
    """Bow, stern and sides of a ship of 80 x 20 m have the antenna within 0.15 degrees of where they see it: half a step of
    bearing and half of one of distance, which the parts that are nearest have up to a quarter more."""
    draw = np.random.default_rng(4)
    for _ in range(300):
        middle = np.append(draw.uniform(-3e3, 3e3, 2), 0.0)
        pose = BodyPose(np.append(draw.uniform(-5e3, 5e3, 2), 0.0), float(draw.uniform(-4.0, 8.0)))
        toward, distance = draw.uniform(0.0, 2.0 * math.pi), float(np.exp(draw.uniform(np.log(200.0), np.log(20e3))))
        there = middle + np.array([distance * math.sin(toward), distance * math.cos(toward), 0.0])
        antenna = map_from_body(there, pose.position, pose.heading) + [0.0, 0.0, 3.0]
        aspect = RoundedAspect.of(antenna, pose, STEP, middle, math.hypot(40.0, 10.0))
        for part in ((0.0, 40.0, 0.0), (0.0, -40.0, 0.0), (10.0, 0.0, 0.0), (-10.0, 0.0, 0.0)):
            seen = there - (middle + part)
            kept = aspect.antenna - map_from_body(middle + part, aspect.pose.position, aspect.pose.heading)
            angle = math.atan2(kept[0] * seen[1] - kept[1] * seen[0], kept[:2] @ seen[:2])
            assert abs(math.degrees(angle)) < 0.15
