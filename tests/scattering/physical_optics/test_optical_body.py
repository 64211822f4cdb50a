"""Physical optics through the whole engine: the energy of a body along range, against that of points."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from tests.scattering.physical_optics.meshes import (
    WAVELENGTH,
    decibels,
    plate,
    sphere,
    trihedral,
    write_obj,
)
from tests.scenes import point, scene

RADAR = {"range_max_m": 1300, "azimuths": 360, "pulse_s": 2e-6}
FLAT = {"earth": "flat"}


def energy_db(body: dict[str, Any], reference: dict[str, Any], folder: Path, **sections: Any) -> float:
    """Energy along range over the beam's middle half degrees [dB], against a point's of 1 m^2 at the same place."""
    energies = []
    for one in (body, reference):
        made = rs.load_scene({"body": [one], "radar": RADAR, "environment": FLAT, **sections}, folder=folder)
        power = rs.Simulator(made).scan().power.astype(np.float64)
        energies.append(power.sum(axis=1).max())
    return decibels(energies[0] / energies[1])


@pytest.mark.sample(5)
@pytest.mark.parametrize("motion", [{}, {"speed_kn": 12, "course_deg": 90}], ids=["at rest", "under way"])
@pytest.mark.parametrize("range_m", [300.0, 1000.0])
@pytest.mark.parametrize("name", ["sphere", "corner", "square corner", "plate"])
def test_energy_along_range_is_the_cross_section(tmp_path: Path, name: str, range_m: float, motion: dict[str, Any]) -> None:
    """As level with the antenna, heading south: pi r^2, 4 pi a^4 / 3 lambda^2, 12 pi a^4 / lambda^2 and 4 pi A^2 /
    lambda^2 to 0.5 dB. (A plate under way is square on for one spoke only: within its lobe of 3 degrees it loses 0.1
    dB.)"""
    axis = np.array([[1, -1, 0], [1, 1, 1], [1, 1, -2]]) / np.sqrt([[2], [3], [6]])  # rows: across, along the axis, other
    mesh, theory = {
        "sphere": (sphere(0.3, 20), np.pi * 0.09),
        "corner": (trihedral(0.5, 2, False) @ axis.T, 4 * np.pi * 0.5**4 / (3 * WAVELENGTH**2)),
        "square corner": (trihedral(0.4, 3, True) @ axis.T, 12 * np.pi * 0.4**4 / WAVELENGTH**2),
        "plate": (plate(0.3, 0.3, 2), 4 * np.pi * 0.3**4 / WAVELENGTH**2),
    }[name]
    write_obj(tmp_path / "body.obj", mesh)
    position = [0, range_m, 15]
    body = {"name": "b", "mesh": "body.obj", "scattering": "optics", "position_m": position, "heading_deg": 180, **motion}
    nearest = range_m - 0.3 * (name == "sphere")  # its front
    reference = point("p", 0, nearest, rcs_dbsm=0.0, **({**motion, "heading_deg": 180} if motion else {}))
    assert energy_db(body, reference, tmp_path) == pytest.approx(decibels(theory), abs=0.5)


@pytest.mark.parametrize("scattering", ["optics", "diffuse"])
def test_a_mesh_may_lie_far_from_its_origin(tmp_path: Path, scattering: str) -> None:
    """As tiles of a map do: the same field to -48 dB as from a mesh about its origin, though that lies where the beam never
    comes meanwhile, on the other side of an own ship at 40 kn; its lattice lies elsewhere.
    Float32 along the lines of sight may see a point or two more of
    the many that lie on the edge of a shadow (diffuse: -40 dB)."""
    fields = []
    for east, north in ((0.0, 0.0), (1800.0, -1200.0)):
        write_obj(tmp_path / "body.obj", sphere(6.0, 12) + (east, north, 0.0))
        body = {"name": "b", "mesh": "body.obj", "scattering": scattering, "material": "steel",
                "position_m": [900 - east, -600 - north, 4]}  # fmt: skip
        own = {"course_deg": 90, "speed_kn": 40}
        made = rs.load_scene({"body": [body], "radar": {**RADAR, "beamwidth_deg": 1}, "own_ship": own}, folder=tmp_path)
        fields.append(np.concatenate([block.field for block in rs.Simulator(made, seed=1).blocks(2)]))
    assert np.abs(fields[0]).max() > 0
    error = np.sum(np.abs(fields[1] - fields[0]) ** 2) / np.sum(np.abs(fields[0]) ** 2)
    assert error < {"optics": 1.6e-5, "diffuse": 1e-4}[scattering]


def test_a_plate_observed_edge_on_returns_nothing() -> None:
    """Edge on, no surface is visible: nothing is returned, and nothing is NaN."""
    sheet = {"name": "p", "shape": "plate", "width_m": 1, "height_m": 1, "heading_deg": 90, "scattering": "optics"}
    power = rs.Simulator(scene([{**sheet, "position_m": [0, 700, 15]}], radar=RADAR, environment=FLAT)).scan().power
    assert np.isfinite(power).all()
    assert power.max() < 1e-3 * rs.Simulator(scene([point("p", 0, 700, rcs_dbsm=0.0)], radar=RADAR)).scan().power.max()
