"""Ships in a seaway from end to end, beside land and aids to navigation: bytes whatever the threads, blocks and commands."""

from typing import Any

import numpy as np

import radar_service as rs
from radar_service.sources.numbers import source_names
from tests.scenes import point, scene

RADAR = {"range_max_m": 600, "azimuths": 32, "beamwidth_deg": 12, "pulse_s": 1e-6, "rpm": 60, "height_m": 12}
SEA = {"sea_state": 3, "multipath": True, "current_kn": 1.5, "current_to_deg": 20, "seaway": {"period_s": 5.0, "seed": 3}}
STEEL = {"name": "steel", "shape": "box", "length_m": 4, "width_m": 2, "height_m": 2, "position_m": [0, 300, -0.5], "hull": {},
         "scattering": "optics", "course_deg": 80, "speed_kn": 8, "turn_rate_deg_s": 2.0, "steerable": {}}  # fmt: skip
WOOD = STEEL | {"name": "wood", "scattering": "diffuse", "material": "wood", "position_m": [-150, -250, -0.5]}
OWN = {"course_deg": 20, "speed_kn": 6, "steerable": {}}


LAND_AND_AIDS = [
    {"name": "island", "shape": "box", "length_m": 200, "width_m": 400, "height_m": 1, "material": "sand",
     "position_m": [0, 450, 0]},
    point("launch", -40, 580, 3.0, speed_kn=30, course_deg=90), point("tower", 20, 450, 10, racon={"letter": "K"}),
    point("raft", -300, -100, 1, sart={"offset_m": [0, 0, 1]}, roll_deg=8, roll_period_s=4.0),
    {"name": "corner", "shape": "reflector", "reflector": "corner", "edge_m": 0.4, "position_m": [300, 0, 4],
     "heading_deg": 270, "roll_deg": 12, "roll_period_s": 5.0},
]  # fmt: skip


def simulator(*others: dict[str, Any], **more: Any) -> rs.Simulator:
    made = scene([STEEL, WOOD, *others], radar=RADAR, environment=SEA | {"noise": bool(others)}, own_ship=OWN)
    return rs.Simulator(made, "balanced", 3, **more)


def test_bytes_depend_on_no_thread_no_block_and_no_history() -> None:
    """Commands as they come, in the second scan, and all known before: with two threads, and a scan alone, block by block."""
    sim = simulator(*LAND_AND_AIDS)
    scans = [sim.scan()]
    sim.command("steel", speed_kn=2.0, course_deg=200.0)
    sim.command(None, turn_rate_deg_s=3.0, speed_kn=12.0)
    scans += [sim.scan(), sim.scan()]
    again = simulator(*LAND_AND_AIDS, threads=2, commands=sim.commands)
    again.skip_to(1)
    np.testing.assert_array_equal(again.scan().field, scans[1].field)
    alone = simulator(*LAND_AND_AIDS, labels=True, commands=sim.commands)
    alone.skip_to(2)
    blocks = list(alone.blocks(1, size=7))
    np.testing.assert_array_equal(np.concatenate([block.field for block in blocks]), scans[2].field)
    labels = np.concatenate([block.labels for block in blocks if block.labels is not None])
    assert {*source_names(sim.scene)} - {*np.unique(labels).tolist()} == {2, 3, 4}, (
        "all but rain, interference, second time around"
    )
