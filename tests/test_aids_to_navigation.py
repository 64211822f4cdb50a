"""Racons, SARTs and reflectors from end to end: commands, several radars and pulses, sway, shadows, threads, other starts."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from tests.scenes import point, scene

PLAIN = {"modulation": "none", "bandwidth_hz": 5e6, "pulse_s": 0.2e-6, "sample_rate_hz": 15e6}
RADAR: dict[str, Any] = {"range_max_m": 4000, "azimuths": 120, "beamwidth_deg": 6, "rpm": 60, "pattern": "taylor", **PLAIN}
RACON = point("racon", 0, 1500, racon={"letter": "K", "mark_m": 1800, "sensitivity_dbm": -20.0}, steerable={})
RACON_LABEL = 5


def marked(scan: Any, label: int = RACON_LABEL) -> int:
    """How many cells of a scan have a label."""
    return int(np.count_nonzero(scan.labels == label))


def simulator(*bodies: dict[str, Any], **sections: Any) -> rs.Simulator:
    return rs.Simulator(
        scene([*bodies], **({"radar": RADAR, "environment": {"noise": True}} | sections)), "fast", labels=True
    )


def test_commands_move_it_and_take_it_away() -> None:
    """The mark turns to where the racon is put, and goes with it."""
    sim = simulator(RACON)
    assert marked(sim.scan()) > 20
    sim.command("racon", position_m=[1500, 0])
    sim.scan()
    labels = sim.scan().labels
    assert labels is not None
    rows = np.flatnonzero((labels == RACON_LABEL).any(axis=1))
    assert rows.min() > 20 and rows.max() < 40  # bearing 090 is row 30
    sim.command("racon", present=False)
    sim.scan()
    assert marked(sim.scan()) == 0
    sim.command("racon", present=True)
    sim.scan()
    assert marked(sim.scan()) > 20


def test_each_radar_has_its_own_answer() -> None:
    """A racon of X band alone, seen by an X-band and an S-band radar of one scene; the reflector beside it by both."""
    reflector = {"name": "r", "shape": "reflector", "reflector": "octahedral", "rcs_dbsm": 20.0, "position_m": [900, 0, 15]}
    of = scene(
        [RACON | {"racon": RACON["racon"] | {"band": "x"}}, reflector],
        radar=[{"id": "x", **RADAR}, {"id": "s", **RADAR, "frequency_hz": 3.05e9}],
        environment={"noise": True},
    )
    x, s = (rs.Simulator(of, "fast", radar=name, labels=True).scan() for name in ("x", "s"))
    assert marked(x) > 20 and marked(s) == 0
    assert marked(x, 257) > 0 and marked(s, 257) > 0


def test_near_and_far_pulses_trigger_it_each() -> None:
    """The mark of the near pulse in its part, that of the far one behind the seam: with one delay from both leading edges."""
    near = {**PLAIN, "range_max_m": 1800}
    far = {"modulation": "lfm", "bandwidth_hz": 5e6, "pulse_s": 2e-6}
    radar = {key: value for key, value in RADAR.items() if key not in PLAIN} | {
        "sample_rate_hz": 15e6,
        "pulses": [near, far],
    }
    radar["pulses"] = [{key: value for key, value in pulse.items() if key != "sample_rate_hz"} for pulse in radar["pulses"]]
    stitched = simulator(RACON, radar=radar)
    labels = stitched.scan().labels
    assert labels is not None
    cells = np.flatnonzero(labels[0] == RACON_LABEL) * stitched.scene.radar.range_step
    assert cells.min() == pytest.approx(1500 + 75 - 15, abs=40) and cells.max() > 3000


def test_a_ship_that_passes_before_it_hides_it() -> None:
    """40 m high, 750 m off, crossing at 40 m/s: for some scans there is no mark, before and after there is."""
    ship = {"name": "ship", "shape": "box", "length_m": 120, "width_m": 30, "height_m": 40, "position_m": [-240, 750, 0],
            "course_deg": 90, "speed_kn": 78, "rcs_dbsm": -60.0}  # fmt: skip
    sim = simulator(RACON, ship)
    labels = [sim.scan().labels for _ in range(12)]
    visible = [bool((each[0] == RACON_LABEL).any()) for each in labels if each is not None]  # at north, where a scan begins
    crossings = [crossing for k in range(12) for crossing in sim.crossings(k) if crossing.body == "racon"]
    triggered = {crossing.scan: crossing.effects["beacon"].triggered for crossing in crossings}
    assert visible[0] and not all(visible) and visible[-1]
    assert visible == [triggered[k] for k in range(12)]


def test_a_beacon_adds_its_answer_and_nothing_else() -> None:
    """Without it every byte is that of the scene before; with it, rows that do not point its way stay as they were."""
    plain, with_racon = (
        rs.Simulator(scene([body], radar=RADAR, environment={"noise": True, "sea_state": 3}), "fast").scan()
        for body in ({key: value for key, value in RACON.items() if key != "racon"}, RACON)
    )
    changed = np.flatnonzero((plain.field != with_racon.field).any(axis=1))
    assert 3 <= len(changed) < 20 and set(changed.tolist()) <= {*range(10), *range(110, 120)}
