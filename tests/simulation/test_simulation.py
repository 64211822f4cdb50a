"""The short modules of simulation, each under its name."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.documented import DocumentedEngine
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.fidelity import PRESETS
from radar_service.simulation.engine_set_up import SourceTile, SourceTiles, chosen_fidelity, engine_set_up
from radar_service.simulation.tile_processes import NOBODY, TileShares, shares
from radar_service.simulator import Simulator
from radar_service.sources import labels, power_window
from radar_service.sources.labels import LabellingEngine, LabellingStitchedEngine
from radar_service.world.scene import Scene
from tests.scenes import point, scene

# engine_set_up: what a simulator computes with, by scene and fidelity.
RADAR = {"azimuths": 32, "beamwidth_deg": 20, "range_max_m": 600, "pulse_s": 1e-6}
PULSES = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 300}, {"pulse_s": 1e-6}]
TWO = {name: value for name, value in RADAR.items() if name != "pulse_s"} | {"pulses": PULSES}


@pytest.mark.parametrize(
    ("radar", "fidelity", "kind"),
    [(RADAR, "balanced", LabellingEngine), (TWO, "fast", LabellingStitchedEngine), (TWO, "balanced", LabellingStitchedEngine),
     (RADAR, "documented", DocumentedEngine)],
)  # fmt: skip
def test_the_engine_is_that_of_the_fidelity_and_the_pulses(radar: dict, fidelity: str, kind: type) -> None:
    made = scene([point("p", 100, 200)], radar=radar)
    engine, set_up, line_of_sight, pulses = engine_set_up(made, PRESETS[fidelity], fidelity, 0)
    assert type(engine) is kind and (set_up is None) == (fidelity == "documented")
    expected = [] if set_up is None else [300, 600] if radar is TWO else [600]
    assert [prepared.scene.radar.range_max for prepared in pulses] == expected
    assert set_up is None or set_up.prepared.line_of_sight is line_of_sight
    (start, field, power), *_ = engine.tiles(0)
    assert start == 0 and field.shape == power.shape and field.shape[1] == made.radar.bins == len(engine.range)


def test_auto_is_planned_and_names_are_presets() -> None:
    made = scene([point("p", 100, 200)], radar=RADAR)
    assert chosen_fidelity(made, "fast") is PRESETS["fast"] and chosen_fidelity(made, PRESETS["fast"]) is PRESETS["fast"]
    assert chosen_fidelity(made, "auto").name == "auto"
    with pytest.raises(ValueError, match="fidelity"):
        chosen_fidelity(made, "best")


# tile_processes: shares of tiles: consecutive ones to each process, as even as tiles allow, by what they took.
@pytest.mark.parametrize("seed", range(12))
def test_shares_are_consecutive_and_as_even_as_tiles_allow(seed: int) -> None:
    """Each tile belongs to the process in whose share of the time its middle lies, so no share is longer by more than a tile."""
    random = np.random.default_rng(seed)
    tiles, count = int(random.integers(1, 65)), int(random.integers(1, 5))
    seconds = random.exponential(1.0, tiles)
    owners = shares(seconds, count)
    assert owners.min() >= 0 and owners.max() < count and np.all(np.diff(owners) >= 0)
    taken = np.bincount(owners, seconds, count)
    assert np.abs(taken - seconds.sum() / count).max() <= seconds.max() * (1.0 + 1e-9)


def test_tiles_of_unknown_time_are_shared_out_evenly() -> None:
    np.testing.assert_array_equal(shares(np.ones(8), 2), [0, 0, 0, 0, 1, 1, 1, 1])
    np.testing.assert_array_equal(shares(np.ones(7), 3), [0, 0, 1, 1, 1, 2, 2])
    np.testing.assert_array_equal(shares(np.ones(2), 2), [0, 1])


def test_shares_follow_what_tiles_took() -> None:
    """Two dear tiles of eight, which take a second in all others' hundredth: each process has one of them."""
    cut = TileShares(8)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 0, 0, 0, 1, 1, 1, 1])
    assert not cut.are_uneven(2, 1.0)
    for tile in range(8):
        cut.note(tile, 1.0 if tile < 2 else 0.01)
    assert cut.are_uneven(2, 1.9) and not cut.are_uneven(2, 1.91)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 1, 1, 1, 1, 1, 1, 1])
    assert not cut.are_uneven(2, 1.0)


def test_a_later_time_counts_by_a_quarter() -> None:
    """A tile of 1 s counts 2 s after one of 5 s, and 4 s after one more of 10 s: its process has 5 s of 7, in place of 4."""
    cut = TileShares(4)
    cut.share_out(np.arange(4), 2)
    for tile in range(4):
        cut.note(tile, 1.0)
    cut.note(0, 5.0)
    assert not cut.are_uneven(2, 1.0)
    cut.note(0, 10.0)
    assert cut.are_uneven(2, 1.24) and not cut.are_uneven(2, 1.26)


def test_tiles_that_nobody_asks_for_have_no_owner() -> None:
    cut = TileShares(6)
    cut.share_out(np.array([1, 2, 5]), 3)
    np.testing.assert_array_equal(cut.owners, [NOBODY, 0, 1, NOBODY, NOBODY, 2])


# engine_set_up: tiles tell what is requested of their sources, and nothing is computed for what is not.
ENVIRONMENT = {"noise": True, "sea_state": 3}
BODIES = [point("p", 100, 200, speed_kn=10), point("q", -100, 200)]
MADE = scene(BODIES, radar=RADAR, environment=ENVIRONMENT)
STITCHED = scene(BODIES, radar=TWO, environment=ENVIRONMENT)


def tiles(request: SourceRequest, made: Scene = MADE) -> SourceTiles:
    engine, _, _, pulses = engine_set_up(made, PRESETS["fast"], "fast", 0)
    return SourceTiles(engine, pulses, request)


@pytest.mark.parametrize("made", [MADE, STITCHED], ids=["one pulse", "two pulses"])
def test_labels_and_powers_are_those_of_a_simulator(made: Scene) -> None:
    simulator = Simulator(made, "fast", labels=True)
    scan, powers = simulator.scan(), simulator.source_powers(0)
    told = [SourceTile(*tile) for tile in tiles(SourceRequest(labels=True, powers="all"), made).scan(0, None)]
    assert np.concatenate([tile.labels for tile in told]).tobytes() == scan.labels.tobytes()
    assert np.concatenate([tile.field for tile in told]).tobytes() == scan.field.tobytes()
    assert {number for tile in told for number in tile.powers} == set(powers) == {0, 1, 256, 257}
    for number, power in powers.items():
        assert np.concatenate([tile.powers[number] for tile in told]).tobytes() == power.tobytes()


def test_named_powers_come_alone() -> None:
    tile = SourceTile(*next(tiles(SourceRequest(powers=(2, 257))).scan(0, None)))
    assert tile.labels is None and list(tile.powers) == [257]  # there is no rain


def test_what_is_not_requested_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object) -> None:
        raise AssertionError("computed")

    made = tiles(SourceRequest())
    monkeypatch.setattr(labels.Labeller, "__init__", fail)
    monkeypatch.setattr(power_window.SourcePowers, "__init__", fail)
    assert all(SourceTile(*tile)[3:] == (None, None) for tile in made.scan(0, None))
    made.request = SourceRequest(labels=True)
    with pytest.raises(AssertionError, match="computed"):
        list(made.scan(0, None))


def test_the_specification_as_printed_tells_no_sources_and_says_why() -> None:
    made = scene(radar=RADAR)
    engine, _, _, pulses = engine_set_up(made, PRESETS["documented"], "documented", 0)
    sources = SourceTiles(engine, pulses, SourceRequest()).sources(made)
    assert "documented" in sources.no_labels and "documented" in sources.no_powers and sources.names[0] == "noise"
    with pytest.raises(ValueError, match="powers: .*documented.* leave powers out"):
        Simulator(made, "documented", powers="all")


# engine_set_up: the power of sources and radiometric truth of runs with commands: computed from what was commanded at each time.
SCENE = {
    "name": "steered",
    "radar": {"azimuths": 128, "beamwidth_deg": 6, "range_max_m": 900, "pulse_s": 1e-6, "rpm": 60},
    "environment": {"noise": True},
    "body": [{**point("runner", 0, 400, 5, 10), "steerable": {"max_speed_kn": 60}}, point("fixed", -300, -300, 5, 10)],
}


def test_a_steered_body_is_measured_where_it_was_steered_to() -> None:
    """The centroid lies on the crossing within a fiftieth of a spoke and 5 cm, as the 20 dB gate cuts at whole cells."""
    sim = rs.Simulator(rs.load_scene(SCENE), "balanced")
    sim.scan()
    sim.command("runner", course_deg=90, speed_kn=40)
    for _ in range(3):
        sim.scan()
    for scan in (1, 2, 3):
        for crossing in sim.crossings(scan, radiometric=True):
            assert crossing.rcs_dbsm == pytest.approx(10.0, abs=0.05), (scan, crossing.body)
            assert crossing.centroid_range == pytest.approx(crossing.range, abs=0.05)
            off = (crossing.centroid_bearing - crossing.bearing + np.pi) % (2 * np.pi) - np.pi
            assert abs(np.degrees(off)) < 2.8 / 50
    ranges = [c.range for scan in (1, 3) for c in sim.crossings(scan) if c.body == "runner"]
    assert len(ranges) >= 2 and ranges[-1] > ranges[0] + 0.5


def test_powers_follow_commands_given_later() -> None:
    sim = rs.Simulator(rs.load_scene(SCENE), "balanced")
    sim.scan()
    before = sim.source_powers(0)
    sim.command("runner", present=False)
    sim.scan()
    assert {sim.label_names[number] for number in sim.source_powers(0)} == {"noise", "runner", "fixed"}
    assert {sim.label_names[number] for number in sim.source_powers(1)} == {"noise", "fixed"}
    np.testing.assert_array_equal(before[257], sim.source_powers(0)[257])


def test_several_pulses_follow_commands_too() -> None:
    """The runner stands at the seam between two pulses; each part of it is measured where it was steered to."""
    pulses = [{"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 15e6, "range_max_m": 400}, {"pulse_s": 1e-6}]
    radar = {key: value for key, value in SCENE["radar"].items() if key != "pulse_s"} | {"pulses": pulses}
    sim = rs.Simulator(rs.load_scene({**SCENE, "radar": radar}), "balanced", labels=True)
    sim.scan()
    sim.command("runner", course_deg=90, speed_kn=4)
    scan = [sim.scan() for _ in range(3)][-1]
    seen = [each for number in (1, 2, 3) for each in sim.crossings(number, radiometric=True)]
    assert len(seen) >= 6 and {each.body for each in seen} == {"runner", "fixed"}
    for crossing in seen:
        assert crossing.rcs_dbsm == pytest.approx(10.0, abs=0.05), (crossing.scan, crossing.body)
    power = sim.source_powers()[256]
    seam = int(400 / sim.range_step)
    assert power[:, :seam].any() and power[:, seam:].any()
    row, column = np.unravel_index(power.argmax(), power.shape)
    assert scan.labels is not None and scan.labels[row, column] == 256
    sim.command("runner", present=False)
    sim.scan()
    assert 256 not in sim.source_powers()
