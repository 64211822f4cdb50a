"""Radar settings that the physics cannot carry are refused with the reason; odd places of bodies are said."""

from typing import Any

import numpy as np
import pytest

from radar_service.radar.patterns import PATTERNS, Table, Taylor
from radar_service.scene.describe import describe
from radar_service.scene.error import SceneError
from radar_service.scene.load import load_scene
from radar_service.scene.odd_places import surfaces_above
from tests.scenes import point, radar, scene

LIGHT = 299_792_458.0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"sample_rate_hz": 40e6}, "radar.sample_rate_hz: 4e+07 is below the bandwidth; complex sampling needs at least"),
        ({"beamwidth_deg": 0.4}, "radar.beamwidth_deg: 0.4 degrees are narrower than the 0.5 degrees from spoke to spoke"),
        ({"beamwidth_deg": 0.4}, "raise azimuths to 900 or set coarse_azimuths = true"),
        ({"pulse_s": 0.05e-6}, 'radar.pulse_s: bandwidth x pulse is 2.5; a chirp needs at least 4: lengthen the pulse'),
        ({"pulse_s": 1e-3, "prf_hz": 1000, "bandwidth_hz": 1e6}, "radar.pulse_s: 0.001 s is not below the 0.001 s"),
        ({"prf_hz": 250}, "radar.prf_hz: 250 is less than a pulse for each of the 288 spokes a second"),
        ({"prf_hz": 40_000}, "radar.range_max_m: 5000 m is beyond the 3747 m from which echoes of 40000 pulses a second"),
        ({"second_time_around": True}, "radar.second_time_around: it takes a pulse repetition frequency; add prf_hz"),
        ({"modulation": "none"}, None),
        ({"modulation": "none", "bandwidth_hz": 50e6}, "radar.bandwidth_hz: 5e+07 Hz x 1e-05 s is 500; the receiver"),
        ({"modulation": "none", "window": "hamming"}, 'radar.window: "hamming" weighs a chirp, and modulation = "none"'),
        ({"pattern_el": [[0, 0], [0, -3]]}, "radar.pattern_el: the offsets start at 0 and rise strictly"),
        (
            {"beamwidth_deg": 0.1, "coarse_azimuths": True, "range_max_m": 20_000},
            "radar.beamwidth_deg: 0.1 degrees take a grid of 18720 rows x 10007 range bins; at most 134217728 cells",
        ),
        ({"pattern": [[0, 0], [0.1, -3.0103], [1, -40]]}, "radar.pattern: 0.2016 degrees are narrower than the 0.5 degrees"),
        ({"pattern": [[0, 0], [1e-3, -40]], "coarse_azimuths": True}, "radar.pattern: 0.0036"),
        ({"taylor_nbar": 1}, "radar.taylor_nbar: 1 is not allowed; a whole number from 2 to 20; raise it"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_the_remedy(settings: dict[str, Any], said: str | None) -> None:
    if said is None:
        load_scene({"radar": settings})
        return
    with pytest.raises(SceneError) as fault:
        load_scene({"radar": settings})
    assert said in str(fault.value)


@pytest.mark.parametrize(
    "settings",
    [
        {"beamwidth_deg": 0.4, "coarse_azimuths": True},
        {"beamwidth_deg": 0.5},  # exactly a step
        {"prf_hz": 288},  # exactly a pulse to a spoke
        {"prf_hz": 40_000, "second_time_around": True},
        {"prf_hz": LIGHT / 10_000},  # exactly to range_max_m
        {"sample_rate_hz": 50e6},
    ],
)
def test_what_just_can_be_is_taken(settings: dict[str, Any]) -> None:
    load_scene({"radar": settings})


WIDTHS = {"sinc2": 0.8859, "gaussian": 0.8859, "printed": 2.783, "taylor": 1.125, "cosine": 1.1889, "cosine2": 1.4406}


def test_every_pattern_has_a_width() -> None:
    assert set(WIDTHS) == set(PATTERNS)


@pytest.mark.parametrize("name", PATTERNS)
def test_the_bound_on_the_grid_is_that_of_the_engine(name: str) -> None:
    """The grid has 2.9 x 2 rows for each wavelength over the aperture, whose half-power widths are WIDTHS lambda / a (Balanis
    2016, table 12.1; Harris 1978). The margin of 1 % covers four digits and whole multiples of 16 azimuths."""
    settings = {"pattern": name, "azimuths": 16, "coarse_azimuths": True, "range_max_m": 20_000}
    finest_deg = 2.9 * 2.0 * WIDTHS[name] * 360.0 * 10_007 / 2**27
    assert load_scene({"radar": settings | {"beamwidth_deg": finest_deg * 1.01}}).radar.bins == 10_007
    with pytest.raises(SceneError, match="at most 134217728 cells"):
        load_scene({"radar": settings | {"beamwidth_deg": finest_deg * 0.99}})


def test_defaults_of_a_plain_pulse() -> None:
    """A receiver of 1.2 / T, sampled 1.5 times as fast, and no window."""
    made = radar(modulation="none", pulse_s=0.25e-6)
    assert (made.bandwidth, made.sample_rate, made.window) == (pytest.approx(4.8e6), pytest.approx(7.2e6), "none")
    assert made.unambiguous_range == np.inf
    assert radar(prf_hz=1500).unambiguous_range == pytest.approx(LIGHT / 3000)


def test_patterns_of_both_planes() -> None:
    """The vertical pattern is the horizontal one by default, sinc2 where that is a table, and its own where it is given."""
    assert radar(pattern="cosine").pattern_el == PATTERNS["cosine"]
    assert radar(pattern=[[0, 0], [2, -20]]).pattern_el == PATTERNS["sinc2"]
    assert radar(pattern="taylor", taylor_sidelobe_db=35, taylor_nbar=5).pattern == Taylor(35.0, 5)
    table = radar(pattern_el=[[0, 0], [10, -3]]).pattern_el
    assert isinstance(table, Table) and table.rows[1] == (pytest.approx(np.deg2rad(10)), pytest.approx(10**-0.3))


def test_description_says_waveform_and_repetition() -> None:
    settings = {"modulation": "none", "pulse_s": 0.3e-6, "prf_hz": 1500, "second_time_around": True, "eclipsing": True}
    text = describe(scene([point("mine", 100, 0, -3)], radar=settings))
    for part in (
        "0.3 us, 4 MHz, not modulated, 1500 a second: unambiguous to 99931 m, second-time-around echoes fold",
        "deaf to 45 m",
        "resolves  44.969 m, the length of the pulse",
        "bearing 090.0 (below the sea)",
    ):
        assert part in text, part


def test_odd_places_are_said_and_plain_ones_are_not() -> None:
    box = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 40}
    made = scene(
        [
            {"name": "around", **box},
            {"name": "beside", **box, "position_m": [30, 0, 0]},
            {"name": "overhead", "shape": "plate", "width_m": 9, "height_m": 9, "position_m": [0, 50, 30]},
            {"name": "sunk", **box, "position_m": [300, 0, -41]},
            {"name": "awash", **box, "position_m": [300, 0, -39]},
            point("drowned", 100, 100, -0.1),
            point("touching", 0.3, 0, 15.4),
            point("near", 1.0, 0, 15.0),
        ]
    )
    assert [w.split(":")[0] + w.split(";")[0][8:] for w in made.warnings] == [
        "body[0] the antenna stands in or under around, which then hides all else from it",
        "body[3] sunk lies wholly below the sea, so nothing of it is seen",
        "body[5] drowned lies wholly below the sea, so nothing of it is seen",
        "body[6] touching stands 0.5 m from the antenna",
    ]


def test_plumb_lines_count_surfaces_once() -> None:
    """Two square floors of two triangles each: the line falls on their diagonals, and counts one triangle of each."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    vertices = np.concatenate([corners, corners + [0, 0, 5]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    assert [surfaces_above(vertices, faces, np.array([0.0, 0.0, up])) for up in (-1.0, 2.0, 6.0)] == [2, 1, 0]
    assert surfaces_above(vertices, faces, np.array([3.0, 0.0, -1.0])) == 0
