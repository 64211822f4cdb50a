"""Azimuth: a beam narrower than the step between spokes."""

import numpy as np

from radar_service.simulator import Simulator
from radar_service.study.stability.finding import (
    Axis,
    Expected,
    Finding,
    crossing,
    curve,
    decibels,
    error_db,
    plain,
    point,
    point_fields,
    scene_of,
)


def narrow_beam(fine: int = 1) -> Finding:
    """Drives the beamwidth over the step between spokes: power of a target half-way between two spokes."""
    ratios = np.array([0.3, 0.5, 0.7, 0.85, 1.0, 1.15, 1.3, 1.45, 1.6, 2.0, 3.0, 4.0])
    step, losses, errors = 2.0 * np.pi / 72, [], []
    for ratio in ratios:
        radar = {"azimuths": 72, "beamwidth_deg": float(np.rad2deg(step) * ratio), "coarse_azimuths": True}
        scene = scene_of(point(300 * np.sin(step / 2), 300 * np.cos(step / 2)), radar=radar)
        on_boresight = Simulator(scene_of(point(0, 300), radar=radar), "balanced").scan().power.max()
        scan = Simulator(scene, "balanced").scan()
        losses.append(float(-decibels(scan.power.max() / on_boresight)))
        errors.append(error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range)))
    return Finding(
        name="beam narrower than the step",
        method="spokes farther apart than the beam is wide",
        setup="a target half-way between two spokes",
        parameter=Axis("beamwidth / step between spokes [1]"),
        values=plain(ratios),
        measured=Axis("loss, field error [dB]"),
        curves=(curve("loss of the strongest spoke", losses), curve("field error of the engine", errors)),
        limit=3.0,
        limit_reason="half of the power",
        boundary=crossing(ratios[::-1], np.array(losses)[::-1], 3.0),
        expected=Expected(1.0 / 0.72, 0.01, "two-way half-power width of a sinc^2 beam: 0.7200 beamwidths"),
        response="refusal",
        instead="a refusal below one step, `check` states the loss up to 1.39 steps",
        details="The service refuses a beam narrower than one step unless the scene sets coarse_azimuths. Between 1 and 1.39 "
        "steps `check` states the loss between spokes. The field of each spoke is correct at every width.",
    )


STUDIES = (narrow_beam,)
