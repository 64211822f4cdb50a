"""The reference of the samplers, against the radar equation and geometry."""

import numpy as np
import pytest

from radar_service.propagation.radar_equation import received_amplitude
from radar_service.study.chart.frozen_scene import all_echoes, frozen
from radar_service.study.chart.power_panel import target_windows
from radar_service.study.chart.reference_surface import ReferenceSurface
from tests.scenes import scene
from tests.study.chart.settings import PLATE, SMALL


def test_mean_power_of_a_plate_at_normal_incidence() -> None:
    """sigma = gamma A; the tolerance is the step of the lattice at the edges, 1/128 + 1/256, 0.05 dB."""
    world = frozen(scene([PLATE], radar=SMALL, environment={"earth": "flat"}))
    (window,) = target_windows(world, all_echoes(world, 0), 1)
    exact = float(received_amplitude(world.radar, np.full(1, 800.0))[0] ** 2) * world.bodies[0].material.gamma * 200.0
    assert 10 * np.log10(ReferenceSurface(world).power(window, 128, 256) / exact) == pytest.approx(0.0, abs=0.05)


def test_a_wall_shadows_the_plate_behind_it() -> None:
    """Antenna at 15 m, plate from 10 to 20 m at 800 m. A wall of 3 m at 400 m shadows nothing (the line over its top meets
    the sea before the plate). A wall of 40 m shadows all (the line is at 65 m at the plate)."""
    low, high = ({**PLATE, "name": "w", "height_m": h, "position_m": [0, 400, h / 2]} for h in (3, 40))
    powers = []
    for wall in (low, high):
        world = frozen(scene([PLATE, wall], radar=SMALL))
        (window,) = target_windows(world, all_echoes(frozen(scene([PLATE], radar=SMALL)), 0), 1)
        powers.append(ReferenceSurface(world).power(window, 32, 64))
    assert powers[0] > 0.0 and powers[1] == 0.0
