"""What `check` says of a radar."""

import math

import pytest

from radar_service.radar.description import far_field, radar_lines, two_way_beamwidth
from tests.scenes import radar, scene


def test_the_two_way_beam() -> None:
    squared = scene(radar={"pattern": "gaussian", "beamwidth_deg": 2}).radar
    assert two_way_beamwidth(squared) == pytest.approx(math.radians(2) / math.sqrt(2))
    assert two_way_beamwidth(scene(radar={"pattern": "taylor"}).radar) is None


def test_nonlinear_chirps_and_inverse_filters_are_described() -> None:
    settings = {"modulation": "nlfm", "compression": "inverse", "window": "nuttall"}
    text = "\n".join(radar_lines(scene(radar=settings).radar))
    assert "10 us, 50 MHz, nonlinear chirp, product 500, compressed by the inverse filter" in text
    assert "before the window (nuttall) widens it" in text


def test_nearer_pulses_are_described() -> None:
    pulses = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 1500}, {"bandwidth_hz": 20e6}]
    text = "\n".join(radar_lines(scene(radar={"pulses": pulses, "eclipsing": True}).radar))
    assert "pulse     10 us, 20 MHz, product 200, eclipsed to 1499 m" in text
    assert "nearer    to 1500 m: 0.08 us, 15 MHz, not modulated, eclipsed to 12 m" in text


def test_it_is_said_where_the_far_field_begins() -> None:
    """3.9 degrees: D = 0.8859 x 31.859 mm / 0.068068 = 0.41465 m, 2 D^2 / lambda = 10.79 m."""
    assert far_field(radar()) == pytest.approx(10.79, abs=0.01)
    assert far_field(radar(beamwidth_deg=90, beamwidth_el_deg=3.9)) == pytest.approx(10.79, abs=0.01)
    assert "far field begins at 10.8 m" in "\n".join(radar_lines(radar()))
