"""Bodies by aspect as indirect echoes have them: one aspect a scan, in cells. Against all centres, and against every aspect."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.engine.pipeline import tile_azimuths
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.frames import effective_earth_radius, polar_from_map
from radar_service.numerics.types import Complexes
from radar_service.propagation.radar_equation import two_way_phase
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.stages.structures.held_passages import HeldPassages, in_cells
from radar_service.stages.structures.stage import StructureStage
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import scene
from tests.stages.structures.false_ship import FalseShip

SCENES = Path(__file__).parents[3] / "scenes"
BALANCED = PRESETS["balanced"]
EACH = replace(BALANCED, held_false_echoes=False)
RADAR: dict[str, Any] = {
    "azimuths": 256, "beamwidth_deg": 3.0, "range_max_m": 900, "pattern": "cosine2", "pulse_s": 1e-6, "bandwidth_hz": 20e6,
    "height_m": 12, "structure": [{"bearing_deg": 90, "distance_m": 5, "width_m": 1.0}],
}  # fmt: skip
PILOT = {"name": "pilot", "shape": "hull", "hull_type": "pilot", "length_m": 12, "beam_m": 4, "height_m": 4,
         "position_m": [-300, 200, 0], "course_deg": 30, "speed_kn": 16, "turn_rate_deg_s": 3}  # fmt: skip
QUAY = {"name": "quay", "shape": "box", "length_m": 6, "width_m": 3, "height_m": 5, "material": "steel", "heading_deg": 40,
        "position_m": [100, -350, 0], "scattering": "optics"}  # fmt: skip
CORNER = {"name": "corner", "shape": "trihedral", "edge_m": 0.3, "scattering": "optics", "position_m": [-250, 120, 5],
          "heading_deg": 115, "course_deg": 80, "speed_kn": 10}  # fmt: skip


def made(bodies: list[dict[str, Any]], fidelity: rs.Fidelity = BALANCED, **sections: Any) -> Prepared:
    return prepare(scene(bodies, radar=RADAR, **sections), fidelity, 1)


def lit(prepared: Prepared, scan: int) -> list[BeamWeightedEchoes]:
    """Indirect echoes of the azimuths that light the mast in a scan."""
    stage = prepared.stages["structures"]
    first = 64 // prepared.tile * prepared.tile
    starts = range(first - prepared.tile, first + 2 * prepared.tile, prepared.tile)
    return [stage.echoes(tile_azimuths(prepared, scan, start)) for start in starts]


def in_bins(echoes: BeamWeightedEchoes) -> Complexes:
    """Fields (K, 1000) of echoes in bins of a metre."""
    distance = (echoes.range[:, None] + echoes.range_migration).astype(np.int64)
    field = np.zeros((echoes.amplitude.shape[1], 1000), dtype=np.complex128)
    np.add.at(field, (np.arange(len(field))[None], np.minimum(distance, 999)), echoes.amplitude)
    return field


def test_cells_have_the_field_of_their_centres() -> None:
    """3000 drawn centres by all three paths: the field of all is that of their cells, to the 1 % by which a loss of R^-2 differs
    within 3.7 m of 360; and no centre is moved by more than a cell, in which the way by the mast 5 m off differs by 1 rad."""
    rng = np.random.default_rng(5)
    over_sea = scene([], radar=RADAR, environment={"multipath": True, "earth": "flat"})
    own = rng.uniform([-4, -20, 0], [4, 20, 8], (3000, 3))
    position, antenna = own + [800.0, 200.0, 0.0], np.array([500.0, 0.0, 12.0])
    amplitude = rng.normal(size=3000) + 1j * rng.normal(size=3000)
    path = rng.integers(0, 3, 3000)
    observed = ObservedEchoes(BodyEchoes(own, amplitude, np.zeros(3000, dtype=np.int64), path, np.zeros(3000)), position)
    sight = OcclusionScene(over_sea.bodies, effective_earth_radius(over_sea.environment.earth_factor))
    cells = in_cells(observed, 7, antenna, over_sea, sight)
    assert 100 < len(cells.echoes) < 900 and set(cells.echoes.body.tolist()) == {7}

    def field(echoes: ObservedEchoes) -> complex:
        polar, height = polar_from_map(echoes.position, antenna, np.inf), echoes.position[:, 2]
        paths = Paths(echoes.echoes.path, echoes.echoes.height_span)
        sight = over_sea.radar, over_sea.environment, polar, height, np.full(len(height), antenna[2])
        length, factor = range_and_factor(*sight, paths)
        return complex(np.sum(echoes.echoes.amplitude * factor * two_way_phase(length, over_sea.radar.wavelength)))

    assert set(cells.echoes.path.tolist()) == {0}
    wood = {"name": "wood", "shape": "box", "length_m": 500, "width_m": 500, "height_m": 0.1, "material": "vegetation",
            "position_m": [650, 100, 0]}  # fmt: skip
    ashore = in_cells(observed, 7, antenna, over_sea, OcclusionScene(scene([wood]).bodies, np.inf))
    direct = ObservedEchoes(observed.echoes.chosen(np.flatnonzero(path == 0)), position[path == 0])  # all that land leaves
    assert abs(field(ashore) - field(direct)) < 0.01 * abs(field(direct))
    assert abs(field(cells) - field(observed)) < 0.01 * abs(field(observed))
    np.testing.assert_allclose(cells.position - cells.echoes.position, np.tile([800.0, 200.0, 0.0], (len(cells.echoes), 1)))
    apart = np.linalg.norm((position[:, None] - cells.position)[..., :2], axis=2).min(axis=1)
    size = np.hypot(over_sea.radar.range_resolution / 2.0, 380.0 * over_sea.radar.wavelength / (2.0 * np.pi * 5.0))
    assert apart.max() < size
    assert (
        len(in_cells(ObservedEchoes(observed.echoes.chosen(np.arange(0)), position[:0]), 7, antenna, over_sea, sight).echoes)
        == 0
    )


def test_aspects_are_those_of_direct_echoes_and_cost_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """In two scans, past the first, a ship under way has no aspect but those of its direct echoes, a body at rest one for all."""
    counted: list[str] = []
    evaluated = PhysicalOptics.body_echoes

    def counting(self: PhysicalOptics, b: int, *given: Any, **more: Any) -> BodyEchoes:
        counted.append(self.bodies[b].name)
        return evaluated(self, b, *given, **more)

    prepared = made([PILOT, QUAY])
    for scan in range(2):
        prepared.moving.echoes(tile_azimuths(prepared, scan, round(0.84 * 256) // prepared.tile * prepared.tile))
    monkeypatch.setattr(PhysicalOptics, "body_echoes", counting)
    fields = [lit(prepared, scan) for scan in (1, 2)]
    assert all(any(np.abs(tile.amplitude).max(initial=0.0) > 0.0 for tile in tiles) for tiles in fields)
    assert counted == ["quay"]


def test_a_held_aspect_is_that_of_the_node_next_to_the_crossing() -> None:
    prepared = made([PILOT])
    direct, visibility = prepared.moving.passages, prepared.moving.visibility
    held = HeldPassages(prepared.scene, visibility, direct)
    crossing = direct.crossing(0, 2.0 + 0.84)
    node = int(min(direct.nodes(0, crossing), key=lambda spoke: abs(spoke - crossing)))
    time = prepared.scene.radar.time_of_spokes(float(crossing))
    observed = direct.node(0, node, time)
    antenna = prepared.scene.antenna(prepared.scene.radar.time_of_spokes(float(node)))[0]
    expected = in_cells(observed, 0, antenna, prepared.scene, prepared.line_of_sight)
    for later in (0.0, 1.0):  # half a scan on, by then the mast is lit
        result = held.held(0, crossing, time + later)
        np.testing.assert_array_equal(result.echoes.amplitude, expected.echoes.amplitude)
        np.testing.assert_array_equal(result.position, expected.position)
    assert not np.array_equal(held.held(0, direct.crossing(0, 3.84), time).echoes.amplitude, expected.echoes.amplitude)


def test_a_corner_has_the_level_that_every_aspect_gives() -> None:
    """It passes at 10 kn, in the middle of its lobe: powers of indirect echoes agree late in a run, to the 0.1 dB that the lobe
    falls within half a scan."""
    powers = []
    for fidelity in (BALANCED, EACH):
        prepared = made([CORNER], fidelity)
        powers.append(np.concatenate([(np.abs(in_bins(tile)) ** 2).sum(axis=1) for tile in lit(prepared, 7)]))
    strong = powers[1] > 1e-6 * powers[1].max()
    assert strong.sum() >= 10
    np.testing.assert_allclose(10.0 * np.log10(powers[0][strong] / powers[1][strong]), 0.0, atol=0.1)


def test_shadows_of_passing_ships_fall_on_what_rests() -> None:
    """A quay that a ship hides as the beam crosses it has no indirect echo in that scan; it has one again when the ship has gone.
    That of the ship is 80 dB weaker."""
    ship = {"name": "ship", "shape": "box", "length_m": 40, "width_m": 8, "height_m": 30, "rcs_dbsm": -80.0,
            "position_m": [40, -250, 0], "course_deg": 90, "speed_kn": 30}  # fmt: skip
    prepared = made([QUAY, ship])
    levels = []
    for scan in (0, 1, 5):
        tiles = lit(prepared, scan)
        levels.append(max(float(np.abs(tile.amplitude).max(initial=0.0)) for tile in tiles))
    assert levels[0] < 0.03 * levels[2]
    assert levels[1] == pytest.approx(levels[2], rel=0.01)


def test_reference_has_every_aspect() -> None:
    for name, held in (("fast", True), ("balanced", True), ("reference", False)):
        stage = made([QUAY], PRESETS[name]).stages["structures"]
        assert isinstance(stage, StructureStage) and stage.is_held is held


@pytest.mark.study
@pytest.mark.parametrize(("mesh", "distance"), [("coaster.obj", 1000.0), ("ferry.obj", 500.0), ("tanker.obj", 1800.0)])
def test_ships_have_the_mean_level_of_every_aspect(mesh: str, distance: float) -> None:
    """A ship that turns by 14.6 degrees a scan, in 40 scans: at the azimuth in the middle of a funnel abeam of it the mean level
    [dB] of one aspect a scan is that of each azimuth's aspect within three standard errors. One look differs by 2 to 6 dB."""
    ship = {"name": "ship", "mesh": mesh, "scattering": "optics", "position_m": [0.6 * distance, 0.8 * distance, 0],
            "course_deg": 20, "speed_kn": 1, "turn_rate_deg_s": 5.83}  # fmt: skip
    radar = {"azimuths": 720, "beamwidth_deg": 1.9, "pattern": "taylor", "range_max_m": 5000, "bandwidth_hz": 50e6}
    table = {"radar": radar, "environment": {"multipath": True, "sea_state": 3}, "body": [ship]}
    false = FalseShip(rs.load_scene(table, folder=SCENES))
    azimuth = round(false.bearing % (2.0 * np.pi) / false.scene.radar.azimuth_step)
    off = []
    for scan in range(1, 41):
        held, each = (false.power(passages, scan * 720 + azimuth) for passages in (false.held, false.every_aspect))
        off.append(10.0 * np.log10(held / each))
    assert 2.0 < np.std(off) < 6.5
    assert abs(np.mean(off)) < 3.0 * np.std(off) / np.sqrt(40.0)
