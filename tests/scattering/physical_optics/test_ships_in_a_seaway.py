"""Ships of boxes that a seaway moves, spoke by spoke, against `tests.reference.ship_fields`, which has laws of its own."""

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.world.seaway_motion import SeawayMotion
from tests.reference import ship_tracks
from tests.reference.seaway_motions import stand_in_seaway
from tests.reference.ship_draws import SIX_HOURS, STEP, Case, Table, drawn
from tests.scattering.physical_optics.test_ships_under_way import SEED, USUAL, outcome

SWAY = ("roll", "pitch", "yaw", "heave")
SEA = {"height_m": 1.2, "period_s": 4.5, "from_deg": 250.0, "list_deg": 0.0, "trim_deg": 0.0}


@dataclass(frozen=True)
class SeawayCase(Case):
    """A draw whose metal floats in a seaway; own ship stands on the sea bed."""

    sea: Table = field(default_factory=dict)

    @property
    def scene(self) -> Table:
        """The scene file."""
        table = super().scene
        own = table["own_ship"] | {"hull": {"floats": False}}
        return table | {"own_ship": own, "environment": table["environment"] | {"seaway": self.sea}}


def in_a_seaway(case: Case) -> SeawayCase:
    """The draw, moved by a seaway instead of its sines."""
    bodies = [{key: value for key, value in body.items() if not key.startswith(SWAY)} for body in case.bodies]
    bodies[0] |= {"hull": {}}
    values = {name: getattr(case, name) for name in Case.__dataclass_fields__} | {"bodies": tuple(bodies)}
    return SeawayCase(**values, sea=SEA)


def judged(case: SeawayCase, monkeypatch: pytest.MonkeyPatch, every: int) -> float:
    """The largest error of all presets; with sway switched off in the oracle it would be much larger, which is asserted."""
    made = rs.load_scene(case.scene)
    law = made.bodies[0].motion.sway
    assert isinstance(law, SeawayMotion)
    plain: Any = ship_tracks.stand
    still = outcome(case, ["balanced"], every)
    with monkeypatch.context() as patch:
        patch.setattr(ship_tracks, "stand", partial(_stand, plain, patch, law.waves))
        result = outcome(case, every=every)
    assert still.error["balanced"] > 5.0 * USUAL, "the sway matters"
    assert max(result.error.values()) < USUAL, str(result)
    return max(result.error.values())


def _stand(plain: Any, patch: pytest.MonkeyPatch, waves: Any, table: Table, time: float, tracks: Any) -> ship_tracks.Stand:
    with pytest.MonkeyPatch.context() as inner:
        inner.setattr(ship_tracks, "stand", plain)
        return stand_in_seaway(table, time, tracks, waves)


@pytest.mark.sample(2)
@pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.study)], ids=["fewer", "all"])
@pytest.mark.parametrize(
    "number", [0, 1, 3, 6, *(pytest.param(n, marks=pytest.mark.study) for n in (10, 11, 13, 51, 79)), 14, 64, 16]
)
def test_ships_in_a_seaway_are_the_oracles(number: int, every: int, monkeypatch: pytest.MonkeyPatch) -> None:
    judged(in_a_seaway(drawn(number, SEED)), monkeypatch, every)


def test_a_ship_that_slows_and_turns_late_in_a_run_is_the_oracles(monkeypatch: pytest.MonkeyPatch) -> None:
    """After six hours, 4 s after its speed fell from 16 to 6 knots, as it turns by 3 degrees a second."""
    case = in_a_seaway(drawn(0, SEED))
    time = SIX_HOURS * 2.5 + 500 * STEP
    hull = {key: value for key, value in case.bodies[0].items() if key not in ("heading_deg", "drift_deg")}
    change = {"time_s": time - 4.0, "speed_kn": 6.0, "turn_rate_deg_s": 3.0}
    moving = hull | {"course_deg": 40.0, "speed_kn": 16.0, "manoeuvre": [change], "position_m": [0.0, 0.0, -0.6]}
    place = ship_tracks.stand(moving, time, {}).position
    angle = 2.0 * np.pi * 500 / 720
    start = 700.0 * np.array([np.sin(angle), np.cos(angle)]) - place[:2]
    moving["position_m"] = [*start.tolist(), -0.6]
    late = replace(
        case,
        bodies=(moving,),
        own={},
        crossing=SIX_HOURS * 720 + 500,
        kind="manoeuvre",
        radar=case.radar | {"range_max_m": 1200.0},
    )
    judged(late, monkeypatch, 2)
