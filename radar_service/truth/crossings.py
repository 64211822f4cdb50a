"""Ground truth of each time that the beam crosses a body, and of all bodies at the end of each scan."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from radar_service.numerics import BLAS_LIMIT, Floats, Indices, polar_from_map, turned, wrap_bearing
from radar_service.records import Crossing, FalseEcho, Kinematics, OwnShipTruth, Snapshot
from radar_service.stages.points import crossing_search
from radar_service.stages.registry import changed_pattern, effects_in
from radar_service.truth.ground_truth import GroundTruth, triple, water_tracks
from radar_service.world import PastMotion, Pose, geographic_from_map, is_land

NO_RELATIVE_SPEED = 1e-9  # m/s: below it two bodies neither approach nor part


class References(NamedTuple):
    """Reference points of bodies at E instants: position (E, 3) [m], velocity (E, 3) [m/s], and of the bodies heading (E,)
    [rad] and turn rate (E,) [rad/s]."""

    position: Floats
    velocity: Floats
    heading: Floats
    turn_rate: Floats


class CrossingTruth:
    """The crossings and snapshots of a scene. truth: of the same scene. Safe to call from several threads."""

    @BLAS_LIMIT.held()
    def __init__(self, truth: GroundTruth) -> None:
        self._truth, self._scene = truth, truth.scene
        bodies, radar = self._scene.bodies, self._scene.radar
        self._motions = [body.motion for body in bodies]
        truths = {effect.name: effect.stage().truth(self._scene, truth.line_of_sight) for effect in effects_in(self._scene)}
        self._effects = {name: part for name, part in truths.items() if part is not None}
        self._steered = any(isinstance(motion, PastMotion) for motion in (self._scene.own_ship, *self._motions))
        self._reference = np.array([body.reference for body in bodies]).reshape(-1, 3)
        self._moves = np.array([not motion.at_rest for motion in self._motions], dtype=np.bool_)
        self._pattern = changed_pattern(radar)
        self._identities = [
            {"radar": self._scene.radar_id, "body": body.name, "mmsi": body.mmsi, "length": body.length, "beam": body.beam}
            for body in bodies
        ]
        every, (points, numbers) = np.arange(len(bodies)), (np.empty((2, len(bodies), 3)), np.empty((2, len(bodies))))
        self._at_start = self._filled(References(*points, *numbers), every, every, np.zeros(len(bodies)))
        self._search = crossing_search(self._scene, lambda which, time: self._references(which, time).position, len(bodies))

    @BLAS_LIMIT.held()
    def crossings(self, scan: int, count: int = 1) -> tuple[Crossing, ...]:
        """Returns the crossings of so many scans by time."""
        bodies, time, scans = self._search.within(scan, count)
        spokes = np.rint(self._scene.radar.spokes_at(time)).astype(np.int64).tolist()
        offset = self._search.offsets(bodies, time)
        boresights = wrap_bearing(np.arctan2(offset[:, 0], offset[:, 1])).tolist()
        effects = map(self._of_effects, bodies.tolist(), time.tolist(), boresights)
        states = self._own_ship(time), self._kinematics(bodies, time)
        rows = zip(scans.tolist(), bodies.tolist(), spokes, boresights, effects, *states, strict=True)
        return tuple(
            Crossing(
                scan=number, spoke=spoke, boresight=boresight, own_ship=own_ship, effects=of_effects,
                structure_db=None if self._pattern is None else self._pattern.loss_db(kinematics["relative_bearing"]),
                false_echoes=self._false_echoes(body, kinematics, own_ship.heading), **kinematics,
            )
            for number, body, spoke, boresight, of_effects, own_ship, kinematics in rows
        )  # fmt: skip

    @BLAS_LIMIT.held()
    def snapshot(self, scan: int) -> Snapshot:
        """Returns all bodies at the end of one scan, before any command that acts from the next one on."""
        time = self._scene.radar.time_of_turns(scan + 1.0)
        instant = math.nextafter(time, 0.0) if self._steered else time
        every = np.arange(len(self._motions))
        bodies = tuple(Kinematics(**kinematics) for kinematics in self._kinematics(every, np.full(len(every), instant)))
        own_ship = self._own_ship(np.array([instant]))[0]
        contents = {name: part.at_end(instant) for name, part in self._effects.items()}
        effects = {name: content for name, content in contents.items() if content is not None}
        return Snapshot(scan=scan, time=time, radar=self._scene.radar_id, own_ship=own_ship, bodies=bodies, effects=effects)

    def _of_effects(self, body: int, time: float, boresight: float) -> dict[str, Any]:
        """What effects tell of a body, by its index, at `time` [s] for a boresight [rad], by their names."""
        records = {name: part.at_crossing(body, time, boresight) for name, part in self._effects.items()}
        return {name: record for name, record in records.items() if record is not None}

    def _false_echoes(self, body: int, kinematics: Mapping[str, Any], heading: float) -> tuple[FalseEcho, ...] | None:
        """The false echoes of a body within range; None in a scene that has none. heading: of own ship [rad]."""
        where = body, kinematics["range"], kinematics["bearing"], heading
        parts = [echoes for part in self._effects.values() if (echoes := part.false_echoes(*where)) is not None]
        if not parts or is_land(self._scene.bodies[body]):
            return () if parts else None
        return tuple(echo for echoes in parts for echo in echoes if echo.range <= self._scene.radar.range_max)

    def _references(self, bodies: Indices, time: Floats) -> References:
        """The reference points of bodies (E,) at times (E,) [s]."""
        references = References(*(column[bodies] for column in self._at_start))
        return self._filled(references, np.flatnonzero(self._moves[bodies]), bodies, time)

    def _filled(self, references: References, rows: Indices, bodies: Indices, time: Floats) -> References:
        """The references with `rows` computed for bodies (E,) at times (E,) [s]: all rows of a body together."""
        order = rows[np.argsort(bodies[rows], kind="stable")]
        for which in np.split(order, np.flatnonzero(np.diff(bodies[order])) + 1) if len(order) else ():
            body, when = int(bodies[which[0]]), time[which]
            motion = self._motions[body]
            pose, rate = motion.pose(when), motion.turn_rate(when)
            position, velocity = _reference_moved(pose, rate, self._reference[body])
            if motion.sway is not None and pose.rotation is not None:
                position = pose.position + pose.rotation @ self._reference[body]
                swung = motion.sway_state(when).rotation_rate(pose.heading, rate) @ self._reference[body]
                velocity = pose.velocity + swung
            for column, values in zip(references, (position, velocity, pose.heading, rate), strict=True):
                column[which] = values
        return references

    def _kinematics(self, bodies: Indices, time: Floats) -> list[dict[str, Any]]:
        """The fields of Kinematics of bodies (E,) at times (E,) [s]."""
        scene, earth_radius = self._scene, self._truth.earth_radius
        points, own = self._references(bodies, time), scene.own_ship.pose(time)
        polar = polar_from_map(points.position, scene.antenna(time), earth_radius)
        course = Pose(points.position, points.velocity, points.heading)
        cpa, tcpa = closest_approach(points.position - own.position, points.velocity - own.velocity)
        columns = {
            "time": time, "range": polar.range, "bearing": wrap_bearing(polar.azimuth), "elevation": polar.elevation,
            "relative_bearing": wrap_bearing(polar.azimuth - own.heading), "course": course.course, "speed": course.speed,
            "heading": points.heading, "turn_rate": points.turn_rate,
            "aspect": wrap_bearing(polar.azimuth + np.pi - points.heading), "cpa": cpa,
        }  # fmt: skip
        water = water_tracks(scene, course)
        rows = zip(*(column.tolist() for column in columns.values()), *water, strict=True)
        keys = (*columns, "water_course", "water_speed")
        arrays = bodies, points.position, points.velocity, tcpa
        texts = self._truth.why_invisible(bodies, time), self._geographic(points.position)
        others = zip(*(array.tolist() for array in arrays), *texts, strict=True)
        return [
            dict(zip(keys, row, strict=True)) | self._identities[body] | place
            | {"position": triple(position), "velocity": triple(velocity), "reason": reason, "visible": not reason,
               "tcpa": None if math.isnan(until) else until}
            for row, (body, position, velocity, until, reason, place) in zip(rows, others, strict=True)
        ]  # fmt: skip

    def _geographic(self, position: Floats) -> list[dict[str, float | None]]:
        """Latitude and longitude of positions (E, 3) [m], None where the scene has no origin."""
        if self._scene.origin is None:
            return [{"latitude_deg": None, "longitude_deg": None}] * len(position)
        pairs = geographic_from_map(position, self._scene.origin).tolist()
        return [{"latitude_deg": latitude, "longitude_deg": longitude} for latitude, longitude in pairs]

    def _own_ship(self, time: Floats) -> list[OwnShipTruth]:
        """Own ship at each time (E,) [s]."""
        motion = self._scene.own_ship
        pose = motion.pose(time)
        sway = motion.sway_state(time).values[:, :3]
        columns = (pose.position, pose.velocity, pose.heading, pose.course, pose.speed, sway)
        return [
            OwnShipTruth(
                position=triple(position), velocity=triple(velocity), heading=heading, course=course, speed=speed,
                roll=roll, pitch=pitch, yaw=yaw, water_course=water_course, water_speed=water_speed,
            )
            for position, velocity, heading, course, speed, (roll, pitch, yaw), water_course, water_speed in zip(
                *(column.tolist() for column in columns), *water_tracks(self._scene, pose), strict=True
            )
        ]  # fmt: skip


def closest_approach(offset: Floats, velocity: Floats) -> tuple[Floats, Floats]:
    """Returns distance (E,) [m] and time from now (E,) [s] of the closest approach in plan at constant relative velocity.

    offset: relative position (E, 2 or more) [m]; velocity: relative (E, 2 or more) [m/s]. The time is nan where there is no
    relative speed.
    """
    offset, velocity = offset[:, :2], velocity[:, :2]
    speed2 = np.einsum("ij,ij->i", velocity, velocity)
    moves = speed2 > NO_RELATIVE_SPEED**2
    progress = np.einsum("ij,ij->i", offset, velocity)
    time = np.divide(-progress, speed2, out=np.full(len(offset), np.nan), where=moves)
    distance = np.linalg.norm(offset + np.where(moves, time, 0.0)[:, None] * velocity, axis=1)
    return distance, time


def _reference_moved(pose: Pose, turn_rate: Floats, offset: Floats) -> tuple[Floats, Floats]:
    """Map positions (K, 3) [m] and velocities (K, 3) [m/s] of a point of a body's frame (3,) [m] that turns at (K,) [rad/s]."""
    arm = turned(offset, np.cos(pose.heading), np.sin(pose.heading))
    swung = np.stack([turn_rate * arm[:, 1], -turn_rate * arm[:, 0], np.zeros(len(arm))], axis=-1)
    return pose.position + arm, pose.velocity + swung
