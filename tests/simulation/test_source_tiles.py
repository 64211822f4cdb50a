"""Tiles tell what is requested of their sources, and nothing is computed for what is not."""

import numpy as np
import pytest

from radar_service.records.cell_sources import SourceRequest
from radar_service.records.fidelity import PRESETS
from radar_service.simulation.engine_set_up import SourceTiles, engine_set_up
from radar_service.simulator import Simulator
from radar_service.sources import labels, power_window
from radar_service.sources.numbers import source_names
from radar_service.world.scene import Scene
from tests.scenes import point, scene

RADAR = {"azimuths": 32, "beamwidth_deg": 20, "range_max_m": 600, "pulse_s": 1e-6}
TWO = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 300}, {"pulse_s": 1e-6}]
ENVIRONMENT = {"noise": True, "sea_state": 3}
BODIES = [point("p", 100, 200, speed_kn=10), point("q", -100, 200)]
MADE = scene(BODIES, radar=RADAR, environment=ENVIRONMENT)
STITCHED = scene(BODIES, radar={name: value for name, value in RADAR.items() if name != "pulse_s"} | {"pulses": TWO},
                 environment=ENVIRONMENT)  # fmt: skip


def tiles(request: SourceRequest, made: Scene = MADE) -> SourceTiles:
    engine, _, _, pulses = engine_set_up(made, PRESETS["fast"], "fast", 0)
    return SourceTiles(engine, pulses, request)


@pytest.mark.parametrize("made", [MADE, STITCHED], ids=["one pulse", "two pulses"])
def test_labels_and_powers_are_those_of_a_simulator(made: Scene) -> None:
    simulator = Simulator(made, "fast", labels=True)
    scan, powers = simulator.scan(), simulator.source_powers(0)
    told = list(tiles(SourceRequest(labels=True, powers="all"), made).scan(0, None))
    assert np.concatenate([tile.labels for tile in told]).tobytes() == scan.labels.tobytes()
    assert np.concatenate([tile.field for tile in told]).tobytes() == scan.field.tobytes()
    assert {number for tile in told for number in tile.powers} == set(powers) == {0, 1, 256, 257}
    for number, power in powers.items():
        assert np.concatenate([tile.powers[number] for tile in told]).tobytes() == power.tobytes()


def test_named_powers_come_alone() -> None:
    (tile, *_) = tiles(SourceRequest(powers=(2, 257))).scan(0, None)
    assert tile.labels is None and list(tile.powers) == [257]  # there is no rain


def test_what_is_not_requested_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object) -> None:
        raise AssertionError("computed")

    made = tiles(SourceRequest())
    monkeypatch.setattr(labels.Labeller, "__init__", fail)
    monkeypatch.setattr(power_window.SourcePowers, "__init__", fail)
    assert all(tile.labels is None and tile.powers is None for tile in made.scan(0, None))
    made.request = SourceRequest(labels=True)
    with pytest.raises(AssertionError, match="computed"):
        list(made.scan(0, None))


def test_the_specification_as_printed_tells_no_sources_and_says_why() -> None:
    made = scene(radar=RADAR)
    engine, _, _, pulses = engine_set_up(made, PRESETS["documented"], "documented", 0)
    sources = SourceTiles(engine, pulses, SourceRequest()).sources(source_names(made))
    assert "documented" in sources.no_labels and "documented" in sources.no_powers and sources.names[0] == "noise"
    with pytest.raises(ValueError, match="powers: .*documented.* leave powers out"):
        Simulator(made, "documented", powers="all")
