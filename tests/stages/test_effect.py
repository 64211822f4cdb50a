"""What all effects have in common."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from pydantic import Field

import radar_service as rs
from radar_service.effects import Attenuator, Effect, Stage
from radar_service.engine import land_rows
from radar_service.stages.interference.effect import InterferenceEffect
from radar_service.truth.ground_truth import scene_hash
from tests.scenes import point, scene
from tests.stages.fixtures import Installed

OTHER = {"bearing_deg": 40, "level_db": 60}


def test_an_effect_is_in_a_scene_that_has_its_record() -> None:
    effect = InterferenceEffect()
    assert (
        effect.is_in(scene(interference=[OTHER])) and not effect.is_in(scene()) and not effect.is_in(scene(interference=[]))
    )
    assert len(effect.of_scene(scene(interference=[OTHER, OTHER]))) == 2 and effect.of_scene(scene()) is None
    assert effect.stage().__name__ == "InterferenceStage"


@dataclass(frozen=True)
class Fog(Attenuator):
    """A decibel in 100 m of fog, east of a line that comes nearer."""

    speed: float
    text = "fog"

    def one_way_db(self, radar: Any, lines: Any) -> Any:
        border = 1000.0 - self.speed * np.asarray(lines.time) - np.asarray(lines.antenna)[..., 0]
        return np.maximum(lines.distance - border / np.maximum(np.sin(lines.azimuth), 1e-9), 0.0) / 100.0


class FogStage(Stage):
    """Adds nothing."""


class FogEffect(Effect):
    """Fog on the east."""

    name, stage_at = "fog", f"{__name__}:FogStage"
    environment_keys = {"fog": (tuple[float, ...], Field(()))}

    def environment_value(self, key: str, value: Sequence[float]) -> Any:
        return Fog(value[0]) if value else ()


QUAY = {"name": "quay", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 8, "material": "concrete"}


@pytest.mark.parametrize("own_ship", [{}, {"speed_kn": 10, "course_deg": 45}], ids=["at rest", "under way"])
@pytest.mark.parametrize("body", [point("buoy", 1300, 200), QUAY | {"position_m": [1300, 200, 0]}], ids=["point", "land"])
def test_what_attenuates_by_place_and_time_acts_on_all_echoes(
    installed: Installed, monkeypatch: pytest.MonkeyPatch, own_ship: dict[str, Any], body: dict[str, Any]
) -> None:
    """Two ways through fog take 2 dB in 100 m, of land on its grid too, and more as the fog comes nearer."""
    installed.package("fogs", FogEffect)
    monkeypatch.setattr(land_rows, "ROW_SECONDS", 0.0)
    radar = {"range_max_m": 2000, "azimuths": 360, "beamwidth_deg": 2}
    clear, foggy = (
        scene([body], radar=radar, own_ship=own_ship, environment={"fog": fog} if fog else {}) for fog in ((), (20.0,))
    )
    assert scene_hash(clear) != scene_hash(foggy)
    free, dim = (rs.Simulator(made, "fast", seed=3) for made in (clear, foggy))
    assert "fog" in str(dim.plan)
    for _ in range(2):
        free_scan, dim_scan = free.scan(), dim.scan()
        row, cell = np.unravel_index(free_scan.power.argmax(), free_scan.power.shape)
        east, *_ = foggy.antenna(free_scan.time[row : row + 1])[0]
        distance, sine = free_scan.range[cell], np.sin(free_scan.azimuth[row])
        lost = 2.0 * (distance - (1000.0 - 20.0 * free_scan.time[row] - east) / sine) / 100.0
        np.testing.assert_allclose(10.0 * np.log10(free_scan.power[row, cell] / dim_scan.power[row, cell]), lost, atol=0.1)
