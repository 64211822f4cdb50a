"""The truth of beacons: whether the beam triggers one as it crosses, and where on the range axis its answer lies."""

import math

import numpy as np

from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.stages.beacons.beacon import DOT_SPACING, BeaconTruth, Racon, Sart
from radar_service.stages.beacons.link import BeaconLink
from radar_service.stages.effect import EffectTruth
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.scene import Scene


class BeaconTruths(EffectTruth):
    """What the beacons of a scene do as the boresight meets them. Safe to call from several threads."""

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self._scene = scene
        keys = [key for key, body in enumerate(scene.bodies) if "beacon" in body.effects]
        self._links = {key: BeaconLink(scene, key, line_of_sight) for key in keys}

    def at_crossing(self, body: int, time: float, boresight: float) -> BeaconTruth | None:
        """The beacon of a body, by its index in the scene, at `time` [s] for a boresight [rad]; None of a body without one."""
        link = self._links.get(body)
        if link is None:
            return None
        radar, beacon, when = self._scene.radar, link.beacon, np.array([time])
        state = link.at(when)
        gain = link.azimuth_gain(state, np.array([boresight]), when)
        reachable = not self._scene.blind(when, np.array([boresight]))[0] and link.visible(time)
        begin = link.delay(state)[0] * SPEED_OF_LIGHT / 2.0
        pulses = beacon.pulses(radar.frequency, time)
        one_way = float((state.transfer * gain)[0])
        return BeaconTruth(
            kind=beacon.kind,
            letters=beacon.letters if isinstance(beacon, Racon) else None,
            triggered=bool(reachable and link.triggers(state, gain, when)[0]),
            pulse_dbm=_dbm(radar.power * one_way),
            answer_dbm=_dbm(beacon.power * one_way),
            carrier_offset=beacon.carrier_offset(radar.frequency, time) if isinstance(beacon, Racon) else None,
            begin=float(begin),
            end=float(begin + pulses.duration * SPEED_OF_LIGHT / 2.0),
            dot=beacon.dot * SPEED_OF_LIGHT / 2.0 if isinstance(beacon, Racon) else None,
            first_dot=float(begin + beacon.first_dot(radar.frequency) * SPEED_OF_LIGHT / 2.0)
            if isinstance(beacon, Sart)
            else None,
            dot_spacing=DOT_SPACING if isinstance(beacon, Sart) else None,
        )


def _dbm(power: float) -> float | None:
    """A power [W] in dBm, None for none."""
    return 10.0 * math.log10(power) + 30.0 if power > 0.0 else None
