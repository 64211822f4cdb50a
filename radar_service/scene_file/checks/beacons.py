"""Warns of racons and search and rescue transponders (SARTs) that no radar of a scene triggers."""

from collections.abc import Sequence

import numpy as np

from radar_service.world.beacon import Beacon, Sart
from radar_service.world.body import Body
from radar_service.world.platform import Installation

MAX_MULTIPATH = 2.0  # of the field, direct and reflected ray in phase: a pulse triggers as much farther


def beacon_warnings(bodies: Sequence[Body], installations: Sequence[Installation]) -> tuple[str, ...]:
    """Returns a warning for each beacon that answers no radar: none has its band, or it is out of reach of all while all rest."""
    return tuple(
        warning
        for k, body in enumerate(bodies)
        if body.beacon is not None
        and (warning := _beacon_warning(body, body.beacon, f"body[{k}].{body.beacon.kind}", installations))
    )


def _beacon_warning(body: Body, beacon: Beacon, location: str, installations: Sequence[Installation]) -> str:
    reaches = [max(beacon.triggering_range(radar) for radar in each.radar.of_each_pulse) for each in installations]
    if max(reaches) == 0.0:
        return f"{location}: {body.name} answers no radar of this scene, {_taken(beacon)}; {_remedy(beacon, installations)}"
    if not body.motion.at_rest or not all(each.platform.motion.at_rest for each in installations):
        return ""
    position = body.motion.position[0]
    distances = [
        float(np.linalg.norm(position - each.platform.antenna(0.0, each.radar.height)[0])) for each in installations
    ]
    nearest = min(zip(distances, reaches, strict=True), key=lambda pair: pair[0] / max(pair[1], 1e-9))
    if nearest[0] <= MAX_MULTIPATH * nearest[1]:
        return ""
    return (
        f"{location}: {body.name} is {nearest[0] / 1000.0:.3g} km off, but the peak power of the radar's pulses triggers it "
        f"within {nearest[1] / 1000.0:.3g} km in free space; raise power_w of the radar or lower sensitivity_dbm"
    )


def _taken(beacon: Beacon) -> str:
    bands = " or ".join(f"{low / 1e9:.4g} to {high / 1e9:.4g} GHz" for low, high in beacon.listens)
    return f"for it takes {bands}" + ("" if beacon.max_pulse is None else f" and pulses up to {beacon.max_pulse:g} s")


def _remedy(beacon: Beacon, installations: Sequence[Installation]) -> str:
    if any(low <= each.radar.frequency <= high for each in installations for low, high in beacon.listens):
        return "raise max_pulse_s or shorten the radar's pulse"
    return "give the radar such a frequency_hz" + ("" if isinstance(beacon, Sart) else ' or the racon band = "both"')
