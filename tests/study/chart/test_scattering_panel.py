"""Scattering models on the canonical targets."""

import numpy as np
import pytest

from radar_service.numerics.frames import wrap_angle
from radar_service.scattering.model import BodyEchoes
from radar_service.study.chart.frozen_scene import frozen
from radar_service.study.chart.scattering_panel import (
    canonical_targets,
    coherent_cross_sections,
    random_turns,
    scattering_points,
    targets_scene,
)
from tests.scenes import scene
from tests.study.chart.settings import PLATE, SMALL


def test_a_corner_needs_as_many_bounces_as_it_has_faces() -> None:
    """Three bounces reach 0.2 dB on five targets. Without the third the trihedral is over 33 dB too weak, 15 dB in the root mean
    square; without the second the dihedral is too."""
    points = {p.setting: p for p in scattering_points(frozen(scene([PLATE], radar=SMALL)), 4, 0, lambda: None)}
    one, two, three = (points[key].error_db or 0.0 for key in ("1 bounce", "2 bounces", "3 bounces"))
    assert three < 0.2 and 15 < two < one and points["3 bounces"].missed == 0.0
    assert {p.preset for p in points.values()} == {None, "fast", "balanced, reference"}


def test_echoes_add_with_the_phase_of_their_range() -> None:
    """Two echoes of 1 m^2, the second 0.3 wavelengths behind. A phase that compensates it gives 4 m^2, no phase
    4 cos^2(0.6 pi). 1e-4: of the range."""
    made = frozen(scene([PLATE]))
    antenna, wavelength = made.antenna(0.0)[0], made.radar.wavelength
    position = antenna + np.array([[0.0, 1000.0, 0.0], [0.0, 1000.0 + 0.3 * wavelength, 0.0]])
    for phase, expected in ((1.2j * np.pi, 4.0), (0j, 4.0 * np.cos(0.6 * np.pi) ** 2)):
        echoes = BodyEchoes.of_points(position, np.array([1.0, np.exp(phase)]), np.zeros(2, dtype=np.int64))
        assert coherent_cross_sections(made, position, echoes) == pytest.approx(expected, rel=1e-4)


def test_targets_have_the_turn_of_their_draw() -> None:
    """Draw k is that of scan k: each target faces the antenna but for its turn."""
    made = frozen(scene([PLATE]))
    targets = canonical_targets(made.radar.wavelength)
    turns = random_turns(targets, 3, 5)
    bodies = targets_scene(made, targets, turns, "optics").bodies
    for k, body in enumerate(bodies):
        heading = body.motion.pose(made.radar.rotation_period * np.arange(3)).heading
        np.testing.assert_allclose(wrap_angle(heading - (k + 0.5) * 2 * np.pi / 5 - np.pi - turns[:, k]), 0.0, atol=1e-9)
