"""Small scenes, as unlike each other as the plan's choices."""

from collections.abc import Callable
from typing import Any

import radar_service as rs
from tests.engine.test_pipeline import scattered
from tests.scenes import point, scene

SMALL = {"azimuths": 120, "beamwidth_deg": 7.5, "range_max_m": 1500, "pulse_s": 2e-6}
WAY = {"speed_kn": 12, "course_deg": 30}
HOUSE = {"name": "house", "shape": "box", "length_m": 40, "width_m": 12, "height_m": 9, "position_m": [300, 700, 0],
         "material": "concrete", "scattering": "diffuse"}  # fmt: skip
SHIP = {"name": "ship", "shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 14, "position_m": [-200, 500, 0],
        "material": "steel"}  # fmt: skip
WALL = {"name": "wall", "shape": "plate", "width_m": 300, "height_m": 80, "position_m": [200, 450, 20], "rcs_dbsm": 20,
        "heading_deg": 200}  # fmt: skip
CORNER = {"name": "corner", "shape": "trihedral", "edge_m": 0.5, "position_m": [0, 800, 15], "heading_deg": 180,
          "material": "steel"}  # fmt: skip
NOISY = {"environment": {"noise": True}}


def made(bodies: list[dict[str, Any]], radar: dict[str, Any] | None = None, **sections: Any) -> rs.Scene:
    """A scene of these bodies on a small radar, changed as said."""
    return scene(bodies, radar=SMALL | (radar or {}), **sections)


WIDE, UPWARD = {"azimuths": 60, "beamwidth_deg": 15}, {"beamwidth_el_deg": 5, "tilt_deg": 13, "range_max_m": 500}
FAR = {"range_max_m": 20_000, "azimuths": 90, "beamwidth_deg": 8.0}
SCENES: dict[str, Callable[[], rs.Scene]] = {
    "points at rest": lambda: made(scattered(5, 1400, 1)),
    "points in noise": lambda: made(scattered(5, 1400, 2), **NOISY),
    "points under way": lambda: made(scattered(5, 1400, 3, **WAY)),
    "own ship under way": lambda: made([HOUSE, *scattered(3, 1400, 4)], own_ship=WAY),
    "Taylor beam under way": lambda: made(scattered(5, 1400, 5), {"pattern": "taylor"}, own_ship=WAY),
    "Gaussian beam, ships under way": lambda: made([SHIP | {"rcs_dbsm": 30} | WAY], {"pattern": "gaussian"}),
    "metal ship under way in noise": lambda: made([SHIP | WAY, point("buoy", 900, 0, 3)], **NOISY),
    "corner reflector at rest": lambda: made([CORNER, point("t", 800, 300)]),
    "wall before a house": lambda: made([WALL, HOUSE, point("t", -500, -700)]),
    "ship passing before a house": lambda: made([HOUSE, SHIP | {"position_m": [150, 350, 0], "rcs_dbsm": 20} | WAY]),
    "far and low": lambda: made([point("low", 0, 19_500, 0.05, 30), point("high", 0, 15_000, 30), SHIP,
                                 point("gone", 40_000, 30_000, 40, 40)], FAR),
    "ship that never comes": lambda: made([point("t", 0, 900), SHIP | {"position_m": [90_000, 0, 0], "speed_kn": 12,
                                                                       "course_deg": 10}]),
    "faint beside plain, in noise": lambda: made([point("t", 0, 9000, 15, 20), point("faint", 5000, 12_000, 15, -45),
                                                  point("fly", -9000, 12_000, 15, -50, **WAY)], FAR, **NOISY),
    "multipath": lambda: made([point("t", 0, 900, 4), HOUSE], environment={"multipath": True, "noise": True}),
    "near ship with multipath": lambda: made([SHIP | {"rcs_dbsm": 30} | WAY, point("t", 0, 1400, 5, **WAY)],
                                                  {"azimuths": 360}, environment={"multipath": True}),
    "sea and rain": lambda: made([point("t", 0, 900), SHIP | {"rcs_dbsm": 25} | WAY], WIDE | {"range_max_m": 950},
                                 environment={"noise": True, "sea_state": 3, "rain_mm_h": 4}),
    "plain pulse": lambda: made(scattered(5, 1400, 6, **WAY), {"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 2e7}),
    "nonlinear chirp, inverse filter": lambda: made(
        scattered(5, 1400, 9, **WAY), {"modulation": "nlfm", "window": "nuttall", "compression": "inverse"}, **NOISY),
    "eclipsed chirp": lambda: made(scattered(5, 1400, 7, **WAY), {"eclipsing": True}, **NOISY),
    "sampled coarsely": lambda: made(scattered(5, 1400, 8), {"sample_rate_hz": 62.5e6}, own_ship=WAY),
    "fluctuating in gas": lambda: made([point("t", 0, 900, swerling=1), point("u", 700, 0)],
                                       environment={"gas_db_per_km": 2e-4}),
    "high above a rough sea": lambda: made([point("t", 0, 300, 80), point("u", 400, 0, 110)], WIDE | UPWARD,
                                           environment={"multipath": True, "sea_state": 6, "noise": True}),
}  # fmt: skip
