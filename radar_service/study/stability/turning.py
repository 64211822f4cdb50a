"""Where the turn fails: at north, with a beam narrower than the step, and where headings wrap."""

import numpy as np

from radar_service.display.ppi import image_position
from radar_service.frames import wrap_angle
from radar_service.scene.world import Motion
from radar_service.simulator import Simulator
from radar_service.study.stability.finding import Axis, Finding, crossing, curve, decibels, places
from radar_service.study.stability.twin import error_db, point, point_fields, scene_of


def north(fine: int = 1) -> Finding:
    """A target at bearings about 0/360 degrees, at rest and moving, against the closed form."""
    bearings = np.array([-20.0, -15.0, -7.5, -1.0, -1e-3, -1e-9, 0.0, 1e-9, 1e-3, 1.0, 7.5, 15.0, 20.0])
    errors: dict[float, list[float]] = {0.0: [], 12.0: []}
    for bearing in np.deg2rad(bearings):
        for speed, found in errors.items():
            scene = scene_of(point(300 * np.sin(bearing), 300 * np.cos(bearing), speed_kn=speed))
            scan = Simulator(scene, "balanced").scan()
            found.append(error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range)))
    return Finding(
        "kernel at 0/360 degrees", "the azimuth grid about north",
        Axis("bearing of the target [degrees]"), places(bearings), Axis("field error [dB]"),
        (curve("at rest", errors[0.0]), curve("moving", errors[12.0])), -50.0, "DESIGN section 4: -55 dB",
        crossing(bearings, np.maximum(errors[0.0], errors[12.0]), -50.0), "computes right", "The grid is a circle.",
    )  # fmt: skip


def narrow_beam(fine: int = 1) -> Finding:
    """A target half-way between two spokes against the beam's width in steps."""
    ratios = np.array([0.3, 0.5, 0.7, 0.85, 1.0, 1.15, 1.3, 1.45, 1.6, 2.0, 3.0, 4.0])
    step, lost, errors = 2.0 * np.pi / 72, [], []
    for ratio in ratios:
        radar = {"azimuths": 72, "beamwidth_deg": float(np.rad2deg(step) * ratio), "coarse_azimuths": True}
        scene = scene_of(point(300 * np.sin(step / 2), 300 * np.cos(step / 2)), radar=radar)
        best = Simulator(scene_of(point(0, 300), radar=radar), "balanced").scan().power.max()
        scan = Simulator(scene, "balanced").scan()
        lost.append(float(-decibels(scan.power.max() / best)))
        errors.append(error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range)))
    return Finding(
        "beam narrower than the step", "a target half-way between two spokes",
        Axis("beamwidth / step between spokes [1]"), places(ratios), Axis("[dB]"),
        (curve("loss of the loudest spoke", lost), curve("field error of the engine", errors)), 3.0, "half the power",
        crossing(ratios[::-1], np.array(lost)[::-1], 3.0), "refuses",
        "Below one step a scene is refused unless coarse_azimuths asks for it; between one and 1.39 check says how much "
        "falls between spokes. What is there is computed right throughout.",
    )  # fmt: skip


def straddling_loss_db(ratio: float) -> float:
    """Loss [dB], out and back, half-way between spokes, of a sinc^2 beam `ratio` steps wide."""
    return float(-40.0 * np.log10(np.sinc(0.8858929413789047 * 0.5 / ratio)))


def headings(fine: int = 1) -> Finding:
    """Headings and bearings over several turns: a turning ship, wrapped angles, the picture's top."""
    turned = np.linspace(-1080.0, 1080.0, 73)
    angles = np.deg2rad(turned)
    wrapped = np.abs(np.exp(1j * wrap_angle(angles)) - np.exp(1j * angles))
    across = Motion(np.array([0.0, 1.0]), np.zeros((2, 3)), np.deg2rad([350.0, 370.0 % 360.0]), turning=True)
    middle = across.pose(np.array([0.25, 0.5, 0.75])).heading
    ship = np.abs(np.exp(1j * middle) - np.exp(1j * np.deg2rad([355.0, 0.0, 5.0]))).max()
    row, column = image_position(np.full(73, 100.0), angles, 400, 200.0, 0.7)
    at = image_position(100.0, angles % (2.0 * np.pi), 400, 200.0, 0.7 + 2.0 * np.pi)
    moved = np.hypot(row - at[0], column - at[1])
    return Finding(
        "wrap of heading and bearing", "angles over six turns: wrapped, turned through north, drawn head up",
        Axis("angle [degrees]"), places(turned), Axis("error [rad, pixels]", log=True),
        (curve("wrapped angles [rad]", np.maximum(wrapped, 1e-17)),
         curve("a ship turning through north [rad]", np.full(73, max(float(ship), 1e-17))),
         curve("picture [pixels]", np.maximum(moved, 1e-17))),
        1e-9, "rounding of three turns", crossing(turned, np.maximum(wrapped, moved), 1e-9), "computes right",
        "Turns go the short way round; angles are compared on the circle.",
    )  # fmt: skip
