"""Tiles tell what is requested of their sources, and nothing is computed for what is not."""

import numpy as np
import pytest

from radar_service.cell_sources import SourceRequest
from radar_service.engine import labels, source_powers
from radar_service.engine.source_numbers import source_names
from radar_service.fidelity import PRESETS
from radar_service.simulation.engine_set_up import engine_set_up
from radar_service.simulation.source_tiles import SourceTiles
from radar_service.simulator import Simulator
from tests.scenes import point, scene

RADAR = {"azimuths": 32, "beamwidth_deg": 20, "range_max_m": 600, "pulse_s": 1e-6}
TWO = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 300}, {"pulse_s": 1e-6}]
MADE = scene([point("p", 100, 200, speed_kn=10), point("q", -100, 200)], radar=RADAR, environment={"noise": True})


def tiles(request: SourceRequest, fidelity: str = "fast") -> SourceTiles:
    engine, set_up, _ = engine_set_up(MADE, PRESETS[fidelity], fidelity, 0, 1, labels=False)
    return SourceTiles(engine, set_up, request)


def test_labels_and_powers_are_those_of_a_simulator() -> None:
    simulator = Simulator(MADE, "fast", labels=True)
    scan, powers = simulator.scan(), simulator.source_powers(0)
    told = list(tiles(SourceRequest(labels=True, powers="all")).scan(0, None))
    assert np.concatenate([tile.labels for tile in told]).tobytes() == scan.labels.tobytes()
    assert np.concatenate([tile.field for tile in told]).tobytes() == scan.field.tobytes()
    assert {number for tile in told for number in tile.powers} == set(powers) == {0, 256, 257}
    for number, power in powers.items():
        assert np.concatenate([tile.powers[number] for tile in told]).tobytes() == power.tobytes()


def test_named_powers_come_alone() -> None:
    (tile, *_) = tiles(SourceRequest(powers=(1, 257))).scan(0, None)
    assert tile.labels is None and list(tile.powers) == [257]  # there is no sea


def test_what_is_not_requested_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object) -> None:
        raise AssertionError("computed")

    made = tiles(SourceRequest())
    monkeypatch.setattr(labels.Labeller, "__init__", fail)
    monkeypatch.setattr(source_powers.SourcePowers, "__init__", fail)
    assert all(tile.labels is None and tile.powers is None for tile in made.scan(0, None))
    made.request = SourceRequest(labels=True)
    with pytest.raises(AssertionError, match="computed"):
        list(made.scan(0, None))


@pytest.mark.parametrize(("radar", "fidelity", "words"), [({"pulses": TWO}, "fast", "several pulses"),
                                                           ({}, "documented", "documented")])  # fmt: skip
def test_a_radar_that_cannot_tell_its_sources_says_why(radar: dict, fidelity: str, words: str) -> None:
    without_pulse = {name: value for name, value in RADAR.items() if name != "pulse_s" or not radar}
    made = scene(radar=without_pulse | radar)
    engine, set_up, _ = engine_set_up(made, PRESETS[fidelity], fidelity, 0, 1, labels=False)
    sources = SourceTiles(engine, set_up, SourceRequest()).sources(source_names(made))
    assert words in sources.no_labels and words in sources.no_powers and sources.names[0] == "noise"
    with pytest.raises(ValueError, match=f"powers: .*{words}.* leave powers out"):
        Simulator(made, fidelity, powers="all")
