"""Builds the seaway of a scene, the hulls that it moves, and how it moves each."""

import math
from dataclasses import replace
from typing import NamedTuple

from radar_service.numerics import LEAN, generator, name_key
from radar_service.scene_file.convert import seaway_from_model, stream_from_model
from radar_service.scene_file.model.environment import EnvironmentModel
from radar_service.scene_file.model.moving import AMPLITUDES, MovingSection
from radar_service.scene_file.model.seaway import HullModel
from radar_service.stages.fields import record_of
from radar_service.world import (
    Bounds,
    HullForm,
    Mesh,
    Motion,
    SceneError,
    Seaway,
    SeawayMotion,
    SteeredMotion,
    Stream,
    Waves,
    bounds_of,
    bounds_on_any_course,
    drawn_waves,
    easing_of,
)

DRAUGHT_PER_BEAM = 0.4  # of cargo ships; of boats somewhat less
STABILITY_PER_BEAM = 0.1  # metacentric height over beam: cargo ships have 0.05 to 0.1, boats 0.1 to 0.2


class HullExtent(NamedTuple):
    """Length and breadth [m] of a body, how deep it reaches [m], and its middle, starboard and forward [m]."""

    length: float
    breadth: float
    depth: float
    middle: tuple[float, float]


OWN_SHIP = HullExtent(75.0, 12.5, 0.0, (0.0, 0.0))  # that is no body


def extent_of(mesh: Mesh, up: float) -> HullExtent:
    """Returns the extent of a mesh whose origin is `up` [m] above the sea."""
    low, high = mesh.used_vertices.min(axis=0), mesh.used_vertices.max(axis=0)
    beam, length = (high - low)[:2].tolist()
    east, north = ((low + high) / 2.0)[:2].tolist()
    return HullExtent(length, beam, max(0.0, -float(low[2]) - up), (east, north))


def hull_from_model(model: HullModel, extent: HullExtent | None, draught: float | None, location: str) -> HullForm:
    """Returns the hull of a ship; extent: of its mesh, None without one. draught: of the body, or None. Raises SceneError.

    Its roll period by default is 2 C B / sqrt(GM), C = 0.373 + 0.023 B / T - 0.043 L / 100: IMO MSC.267(85), 2008 Intact
    Stability Code, part A, 2.3.4. Its waterplane by default is that of Schneekluth and Bertram 1998, (1 + 2 C_B) / 3.
    """
    extent = HullExtent(0.0, 0.0, 0.0, (0.0, 0.0)) if extent is None else extent
    length, breadth = model.length_m or extent.length, model.beam_m or extent.breadth
    if not length or not breadth:
        missing = "length_m" if not length else "beam_m"
        raise SceneError(
            f"{location}.hull.{missing}: the body has no size of its own; give {missing}, or hull.floats = false"
        )
    deep = next((value for value in (model.draught_m, draught, extent.depth) if value), DRAUGHT_PER_BEAM * breadth)
    coefficient = 0.373 + 0.023 * breadth / deep - 0.043 * length / 100.0
    stability = STABILITY_PER_BEAM * breadth
    waterplane = (1.0 + 2.0 * model.block) / 3.0 if model.waterplane is None else model.waterplane
    roll_period = max(1.0, 2.0 * coefficient * breadth / math.sqrt(stability))
    return record_of(
        HullForm, model, length=length, breadth=breadth, draught=deep, waterplane=waterplane,
        roll_period=roll_period if model.roll_period_s is None else model.roll_period_s, middle=extent.middle,
    )  # fmt: skip


class SeawayBuilder:
    """Puts ships into the seaway of a scene."""

    def __init__(self, seaway: Seaway, stream: Stream) -> None:
        self.seaway, self._stream = seaway, stream
        self._waves: Waves = drawn_waves(seaway, stream)
        self._bounds: dict[tuple[HullForm, float, float], Bounds] = {}

    def moves(self, section: MovingSection, is_vessel: bool) -> bool:
        """Returns whether the seaway moves a body: it floats, and has no sway of its own."""
        if any(getattr(section, amplitude) for amplitude in AMPLITUDES.values()):
            return False
        floats = None if section.hull is None else section.hull.floats
        return (is_vessel or section.hull is not None) if floats is None else floats

    def moved(self, motion: Motion, section: MovingSection, form: HullForm, name: str) -> Motion:
        """Returns the motion of a ship with the sway of the seaway; name: of the ship, which keys its list."""
        rng = generator(self.seaway.seed, LEAN, name_key(name))
        drawn_list, drawn_trim = (rng.standard_normal(2) * [self.seaway.list_rms, self.seaway.trim_rms]).tolist()
        lean = (
            drawn_list if section.list_deg is None else math.radians(section.list_deg),
            drawn_trim if section.trim_deg is None else math.radians(section.trim_deg),
        )
        steady = len(motion.time) == 1 and not (motion.final_turn or isinstance(motion, SteeredMotion))
        if steady and motion.time[0] <= 0.0:
            velocity = motion.final_velocity[None, :2] - self._stream
            bounds = bounds_of(self._waves, form, motion.heading, velocity)
        else:
            key = form, motion.top_speed + math.hypot(*self._stream), motion.top_turn_rate
            if key not in self._bounds:
                self._bounds[key] = bounds_on_any_course(self._waves, *key)
            bounds = self._bounds[key]
        sway = SeawayMotion(self._waves, form, bounds, lean, easing_of(motion), self._stream)
        return replace(motion, sway=sway)


def builder_from_model(model: EnvironmentModel) -> SeawayBuilder | None:
    """Returns what puts ships into the seaway of a scene, None where it has none. Raises SceneError."""
    seaway = seaway_from_model(model)
    return None if seaway is None else SeawayBuilder(seaway, stream_from_model(model))
