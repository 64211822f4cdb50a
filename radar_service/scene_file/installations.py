"""What a scene file's radars mean for all of it: where they can reach, and sentences that name one of them."""

import contextlib
import math
from collections.abc import Iterator, Sequence

import numpy as np

from radar_service.numerics import EARTH_RADIUS
from radar_service.radar import Radar
from radar_service.scene_file.model.platform import RadarEntry
from radar_service.scene_file.readers.heightmap import Coverage
from radar_service.world import Platform, SceneError, SteeredMotion

MAX_ORIGIN_DISTANCE = 200_000.0  # m; there the map is stretched by 0.02 %: 44 m in 200 km, below radar accuracy


def reach(radars: Sequence[Radar], platforms: Sequence[Platform | None]) -> Coverage:
    """Returns a circle that no radar reaches beyond from any position of its platform; unlimited where one never stops.

    A platform that is None could not be read.
    """
    circles = [_circle(radar, platform) for radar, platform in zip(radars, platforms, strict=True)]
    east, north, _ = circles[0]
    return Coverage(
        east, north, max(math.hypot(circle.east - east, circle.north - north) + circle.radius for circle in circles)
    )


def _circle(radar: Radar, platform: Platform | None) -> Coverage:
    """The circle that one radar reaches."""
    knots = np.zeros((1, 3)) if platform is None else platform.motion.position
    endless = platform is not None and (
        isinstance(platform.motion, SteeredMotion) or bool(platform.motion.final_velocity.any())
    )
    travel = np.inf if endless else float(np.hypot(*(knots - knots[0])[:, :2].T).max())
    max_range = np.inf if radar.second_time_around else radar.range_max
    return Coverage(float(knots[0, 0]), float(knots[0, 1]), max_range + travel)


def distance_warnings(entries: Sequence[RadarEntry], platforms: Sequence[Platform]) -> Iterator[str]:
    """Yields a warning with the distortion of the map for each platform that is far from the origin of the scene."""
    for entry, platform in zip(entries, platforms, strict=True):
        distance = float(np.hypot(platform.motion.position[:, 0], platform.motion.position[:, 1]).max())
        if distance > MAX_ORIGIN_DISTANCE:
            arc = distance / EARTH_RADIUS
            name = "own_ship" if entry.platform is None else f"{entry.location}.platform"
            yield (
                f"{name}: at {distance / 1000:.0f} km from the origin the map is stretched by {arc / np.sin(arc) - 1:.2%} "
                "across the line from the origin and its north is not true north: move [origin] nearer"
            )


def located(sentence: str, location: str) -> str:
    """Returns a sentence about `radar` as one about the radar at a key path."""
    return f"{location}{sentence.removeprefix('radar')}" if sentence.startswith("radar.") else sentence


@contextlib.contextmanager
def at_location(location: str) -> Iterator[None]:
    """Names the radar at a key path in the lines of a SceneError."""
    try:
        yield
    except SceneError as error:
        raise SceneError(*(located(problem, location) for problem in error.problems)) from None
