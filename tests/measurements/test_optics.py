"""Opt-in: what physical optics costs (`python -m pytest tests/measurements/test_optics.py -m bench -s`)."""

import time
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.scattering.physical_optics.model import PhysicalOptics
from tests.reference.make_ships import coaster
from tests.scattering.physical_optics.meshes import echoes_toward, loaded, optical


@pytest.mark.bench
def test_one_aspect_of_a_coaster(tmp_path: Path) -> None:
    """CPU milliseconds for one aspect of a ship of 88 m with her fittings; below 30 even on a busy core."""
    body = optical(loaded(tmp_path, coaster()))
    antenna = np.array([800.0, 600.0, 20.0])
    echoes_toward(body, antenna)
    spent = []
    for _ in range(10):
        start = time.process_time()
        echoes_toward(body, antenna)
        spent.append(time.process_time() - start)
    print(f"coaster: {1e3 * np.median(spent):.1f} ms, {len(body.optics.pieces)} pieces")
    assert np.median(spent) < 0.03


@pytest.mark.bench
def test_share_of_optics_in_the_harbour(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ratio of two times of one run: under a third of a revolution's work, once per revolution and ship."""
    inner, spent = PhysicalOptics.echoes, [0.0]

    def timed(self: PhysicalOptics, *arguments: object) -> object:
        start = time.process_time()
        result = inner(self, *arguments)  # type: ignore[arg-type]
        spent[0] += time.process_time() - start
        return result

    monkeypatch.setattr(PhysicalOptics, "echoes", timed)
    sim = rs.Simulator(rs.load_scene("harbour"))
    sim.scan()
    spent[0], start = 0.0, time.process_time()
    for _ in range(4):
        sim.scan()
    whole = time.process_time() - start
    print(f"optics: {1e3 * spent[0] / 4:.0f} ms of {1e3 * whole / 4:.0f} ms a revolution")
    assert spent[0] < whole / 3
