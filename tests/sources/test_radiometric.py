"""Radiometric truth against full scans of each body alone, measured by slow code of this file."""

from collections.abc import Collection
from dataclasses import asdict, replace
from typing import Any, Protocol

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.receive.compression import receiver_noise_power
from radar_service.records.fidelity import PRESETS
from radar_service.records.truth import Crossing, Radiometry
from tests.alone import Alone, Fields, clutter_of, crowded, crowded_alone, power_of
from tests.scenes import point, scene

Power = NDArray[np.float64]
RADAR = {"range_max_m": 1200, "azimuths": 120, "beamwidth_deg": 6, "pulse_s": 1e-6, "bandwidth_hz": 25e6}


class Separate(Protocol):
    """Runs bodies alone."""

    def bodies(self, bodies: Collection[int], scan: int) -> Fields: ...


def three_scans(alone: Separate, scan: int, body: int) -> Power:
    """The power (3 A, N) of a body alone in the scan before, the scan and the scan after; 0 before the start."""
    parts = [alone.bodies([body], k) for k in range(max(0, scan - 1), scan + 2)]
    parts = [np.zeros_like(parts[0])] * (3 - len(parts)) + parts
    return np.abs(np.concatenate(parts).astype(np.complex128)) ** 2


def gate_by_flood(power: Power, about: int, half: int) -> NDArray[np.bool_]:
    """The cells within 20 dB of the peak that connect with it, found cell by cell from the peak on."""
    near = np.zeros(len(power), dtype=bool)
    first = max(0, about - half)
    near[first : min(about + half + 1, first + 2 * half)] = True
    limited = np.where(near[:, None], power, 0.0)
    peak = np.unravel_index(limited.argmax(), limited.shape)
    gate, waiting = np.zeros(power.shape, dtype=bool), [peak]
    while waiting:
        row, cell = waiting.pop()
        inside = 0 <= row < len(power) and 0 <= cell < power.shape[1] and not gate[row, cell]
        if inside and limited[row, cell] >= 0.01 * power[peak]:
            gate[row, cell] = True
            waiting += [(row + i, cell + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return gate


def measured(made: rs.Scene, alone: Separate, scan: int, crossing: Crossing) -> dict[str, Any]:
    """Centroid, peak and extent of a body by itself."""
    radar, body = made.radar, [b.name for b in made.bodies].index(crossing.body)
    power = three_scans(alone, scan, body)
    if not power.any():
        return {"gate": np.zeros(power.shape, dtype=bool), "power": power}
    first = (scan - 1) * radar.azimuths  # number of row 0
    gate = gate_by_flood(power, crossing.spoke - first, radar.azimuths // 2)
    inside = np.where(gate, power, 0.0)
    number, cell = first + np.arange(len(power)), np.arange(power.shape[1])
    row, column = np.flatnonzero(gate.any(axis=1)), np.flatnonzero(gate.any(axis=0))
    step, turn = radar.range_step, 2.0 * np.pi / radar.azimuths
    return {
        "gate": gate, "power": power, "peak": inside.max(), "energy": inside.sum(),
        "where": np.unravel_index(inside.argmax(), inside.shape),
        "centroid_range": (inside.sum(axis=0) @ (cell + 0.5)) / inside.sum() * step,
        "centroid_bearing": (inside.sum(axis=1) @ number) / inside.sum() * turn,
        "range": (column[0] * step, (column[-1] + 1) * step),
        "bearing": ((number[row[0]] - 0.5) * turn, (number[row[-1]] + 0.5) * turn),
    }  # fmt: skip


def assert_angle(angle: float, expected: float, within: float) -> None:
    assert 0.0 <= angle < 2.0 * np.pi
    assert abs((angle - expected + np.pi) % (2.0 * np.pi) - np.pi) < within


@pytest.mark.parametrize(("moves", "scan"), [(False, 0), (False, 30_000), (True, 1)])
def test_crossings_measure_what_each_body_alone_lays(moves: bool, scan: int) -> None:
    """To single precision of the power: 1e-5 of a cell. Many moving echoes are shifted by series, which errs by -60 dB: 1e-3 of
    a cell. A body of no power has nothing."""
    made, part = crowded(moves), 1e-3 if moves else 1e-5
    crossings, separate = rs.Simulator(made, fidelity="balanced").crossings(scan, radiometric=True), crowded_alone(moves)
    assert sum(assert_measured(made, separate, scan, crossing, part) for crossing in crossings) >= 5


def assert_measured(made: rs.Scene, separate: Separate, scan: int, crossing: Crossing, part: float) -> bool:
    """Compares a crossing to what its body alone has, within a part of a cell; returns whether it has any power."""
    alone, noise = measured(made, separate, scan, crossing), receiver_noise_power(made.radar)
    if not alone["gate"].any():
        assert crossing.centroid_range is crossing.snr_db is crossing.extent is crossing.foreign_share is None
        return False
    assert crossing.centroid_range == pytest.approx(alone["centroid_range"], abs=part * made.radar.range_step)
    assert crossing.centroid_bearing is not None and crossing.snr_db is not None and crossing.extent is not None
    assert_angle(crossing.centroid_bearing, alone["centroid_bearing"], part * made.radar.azimuth_step)
    assert crossing.snr_db == pytest.approx(10 * np.log10(alone["peak"] / noise), abs=10 * part)
    assert crossing.extent.range == pytest.approx(alone["range"])
    for angle, expected in zip(crossing.extent.bearing, alone["bearing"], strict=True):
        assert_angle(angle, expected, 1e-9)
    detectable = alone["gate"] & (alone["power"] >= 10**1.3 * noise)
    assert (crossing.extent_13db is None) == (not detectable.any())
    if crossing.extent_13db is not None:
        column = np.flatnonzero(detectable.any(axis=0)) * made.radar.range_step
        assert crossing.extent_13db.range == pytest.approx((column[0], column[-1] + made.radar.range_step))
    assert 0.0 <= (crossing.foreign_share or 0.0) < 1.0
    return True


class BySimulators:
    """Bodies by themselves, each in a simulator of its own."""

    def __init__(self, made: rs.Scene) -> None:
        self._made = made.with_world(environment=replace(made.environment, noise=False))

    def bodies(self, bodies: Collection[int], scan: int) -> Fields:
        made = self._made.with_world(bodies=tuple(self._made.bodies[k] for k in bodies))
        sim = rs.Simulator(made, fidelity="balanced")
        sim.skip_to(scan)
        return sim.scan().field


def test_bodies_at_the_seams_of_several_pulses_are_measured_as_their_parts_are_stitched() -> None:
    """The power of each part has the factor of its pulse; so has that of the 1 m^2 to which the cross-section refers."""
    pulses = [{"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 15e6, "range_max_m": 300},
              {"pulse_s": 5e-7, "bandwidth_hz": 20e6, "range_max_m": 702}, {"pulse_s": 1e-6, "bandwidth_hz": 20e6}]  # fmt: skip
    radar = {"range_max_m": 1200, "azimuths": 120, "beamwidth_deg": 6, "eclipsing": True, "pulses": pulses}
    spots = [(0, 200), (296, 50), (702, 0), (-698, 3), (0, -300), (-600, 700)]
    bodies = [point(f"p{k}", east, north, 15, 10 + k) for k, (east, north) in enumerate(spots)]
    made = scene(bodies, radar=radar, environment={"noise": True})
    separate = BySimulators(made)
    for crossing in rs.Simulator(made, fidelity="balanced").crossings(1, radiometric=True):
        assert assert_measured(made, separate, 1, crossing, 1e-5)
        assert crossing.rcs_dbsm == pytest.approx(10 + int(crossing.body[1]), abs=0.01)


@pytest.mark.parametrize("moves", [False, True], ids=["at rest", "own ship under way"])
def test_foreign_share_and_clutter_are_those_of_separate_runs(moves: bool) -> None:
    made, scan = crowded(moves), 1
    separate, prepared, compared = crowded_alone(moves), prepare(made, PRESETS["balanced"], 0), 0
    sources, noise = every_source(made, separate, scan), receiver_noise_power(made.radar)
    assert (clutter := clutter_of(prepared)) is not None
    for crossing in rs.Simulator(made, fidelity="balanced").crossings(scan, radiometric=True):
        alone, middle = measured(made, separate, scan, crossing), slice(made.radar.azimuths, 2 * made.radar.azimuths)
        gate = alone["gate"][middle]
        if not gate.any() or gate.sum() != alone["gate"].sum() or crossing.foreign_share is None:
            continue  # absent, or partly in another scan
        every = sum(float(power[gate].sum()) for power in sources) + noise * np.count_nonzero(gate)
        assert crossing.foreign_share == pytest.approx(1.0 - alone["energy"] / every, abs=1e-4)
        peak = alone["where"][0] - made.radar.azimuths, alone["where"][1]
        first = peak[0] // prepared.tile * prepared.tile
        number = scan * made.radar.azimuths + np.arange(first, min(first + prepared.tile, made.radar.azimuths))
        rows = clutter.rows(number, np.ones((len(number), 1), dtype=bool))
        assert rows is not None
        if peak[1] >= rows.field.shape[1]:  # beyond the clutter that is above the floor
            assert crossing.scr_db is None
            continue
        compared += 1
        mean = float(rows.amplitude[peak[0] - first, peak[1]]) ** 2
        assert crossing.scr_db == pytest.approx(10 * np.log10(alone["peak"] / mean), abs=1e-3)
    assert compared >= 3


def every_source(made: rs.Scene, alone: Alone, scan: int) -> list[Power]:
    """The power of every source of a scan but noise, each body by itself, land too."""
    bodies = [alone.bodies([k], scan) for k in range(len(made.bodies))]
    return [power_of(field) for field in (*bodies, *alone.others(scan).values())]


@pytest.mark.parametrize("up", [2.0, 15.0, 60.0])
@pytest.mark.parametrize("more", [{}, {"speed_kn": 25, "course_deg": 40}], ids=["at rest", "under way"])
def test_a_point_in_free_space_has_its_declared_cross_section(up: float, more: dict[str, Any]) -> None:
    """Within 0.01 dB, wherever it stands between samples and spokes: with gas, rain and the beam's elevation gain; also near
    north, where its cells are in two scans."""
    spots = [(300, 411.3), (2.0, 900.7), (-3.1, 600), (-900, -300.9), (0.0, -377.7)]
    made = scene(
        [point(f"p{k}", east, north, up, rcs_dbsm=3.0 * k - 5, **more) for k, (east, north) in enumerate(spots)],
        radar=RADAR | {"beamwidth_el_deg": 20, "tilt_deg": 1}, environment={"gas_db_per_km": 0.5, "rain_mm_h": 30.0},
    )  # fmt: skip
    simulator = rs.Simulator(made, fidelity="balanced")
    seen = [crossing for scan in (1, 2) for crossing in simulator.crossings(scan, radiometric=True)]
    assert len(seen) >= 9
    for crossing in seen:
        assert crossing.rcs_dbsm == pytest.approx(3.0 * int(crossing.body[1]) - 5, abs=0.01)
        assert crossing.snr_db is None and crossing.extent_13db is None and crossing.rcs_drawn_dbsm is None
        assert abs(crossing.centroid_along or 0.0) < 0.1 * crossing.range * made.radar.beamwidth


def test_a_swaying_antenna_and_a_fluctuating_point() -> None:
    """The drawn value is the realised one: nothing but the draw differs from the declared cross-section. In free space again."""
    bodies = [point(f"p{case}", 300.0 - 150 * case, 500.0, 15, rcs_dbsm=5, swerling=case) for case in (0, 1, 3)]
    made = scene(bodies, radar=RADAR, own_ship={"roll_deg": 6, "pitch_deg": 3, "speed_kn": 5})
    drawn = []
    for crossing in (c for k in (0, 1, 7) for c in rs.Simulator(made, fidelity="balanced").crossings(k, radiometric=True)):
        expected = 5.0 if crossing.body == "p0" else crossing.rcs_drawn_dbsm
        assert crossing.rcs_dbsm == pytest.approx(expected, abs=0.02)  # the roll changes over the dwell
        drawn.append(crossing.rcs_drawn_dbsm)
    assert len(set(drawn)) == 7 and None in drawn


@pytest.mark.parametrize("scan", [0, 8640])
def test_the_power_of_a_point_lies_at_the_point_while_own_ship_rolls(scan: int) -> None:
    """The spokes are those of the tilted boresight, which is up to a degree off: 18 m at 1 km. Tolerance: the centroid of a gate
    of whole cells and spokes, a tenth of either, here 0.6 m along and 5 m across."""
    places = [(150.0, -700.0), (-800.0, 500.0), (600.0, 750.0)]
    bodies = [point(f"{up}", *place, up) for place, up in zip(places, (2.0, 15.0, 120.0), strict=True)]
    own_ship = {"roll_deg": 12, "roll_period_s": 9, "pitch_deg": 5, "pitch_period_s": 7}
    made = scene(bodies, radar=RADAR | {"azimuths": 360, "beamwidth_deg": 3}, own_ship=own_ship)
    crossings = rs.Simulator(made, fidelity="balanced").crossings(scan, radiometric=True)
    for crossing in crossings:
        assert crossing.centroid_bearing == pytest.approx(crossing.boresight, abs=0.1 * made.radar.azimuth_step)
        offset = np.hypot(crossing.centroid_along or np.nan, crossing.centroid_across or np.nan)
        assert offset < 0.1 * np.hypot(crossing.range * made.radar.azimuth_step, made.radar.range_step)
    assert max(abs(one.boresight - one.bearing) for one in crossings) > 0.5 * made.radar.azimuth_step


def test_the_reflection_of_the_sea_is_in_the_cross_section() -> None:
    made = scene([point("p", 400, 300, 6, rcs_dbsm=0)], radar=RADAR, environment={"multipath": True})
    (crossing,) = rs.Simulator(made, fidelity="balanced").crossings(0, radiometric=True)
    power = three_scans(Alone(made), 0, 0).max()
    free = three_scans(Alone(made.with_world(environment=replace(made.environment, multipath=False))), 0, 0).max()
    gained = 10 * np.log10(power / free)
    assert crossing.rcs_dbsm == pytest.approx(gained, abs=0.05)  # the range of the path by the sea differs
    assert abs(crossing.rcs_dbsm or 0.0) > 1.0


def test_the_power_of_a_ship_lies_where_it_is_put_along_and_across_her() -> None:
    """A point 40 m ahead of another's origin, and 15 m to port; the body's frame is that of the heading."""
    for heading in (0.0, 75.0, 260.0):
        made = scene(
            [{"name": "ship", "shape": "box", "length_m": 1, "width_m": 1, "height_m": 1, "material": "wood",
              "position_m": [500, 400, 15], "heading_deg": heading, "speed_kn": 10}], radar=RADAR,
        )  # fmt: skip
        mesh = made.bodies[0].mesh
        assert mesh is not None
        offset = np.array([-15.0, 40.0, 0.0])
        ship = replace(made.bodies[0], mesh=replace(mesh, vertices=mesh.vertices + offset), is_vessel=False)
        (crossing,) = rs.Simulator(made.with_world(bodies=(ship,)), fidelity="balanced").crossings(0, radiometric=True)
        assert (crossing.centroid_along, crossing.centroid_across) == pytest.approx((40.0, -15.0), abs=1.0)


def test_a_plain_crossing_has_no_radiometric_part_and_documented_none_at_all() -> None:
    made = scene([point("p", 400, 300)], radar=RADAR)
    (plain,), (asked,) = (rs.Simulator(made).crossings(0, radiometric=asked) for asked in (False, True))
    radiometric = set(Radiometry.__dataclass_fields__)
    assert len(radiometric) == 11 and all(getattr(plain, name) is None for name in radiometric)
    same = {name: value for name, value in asdict(asked).items() if name not in radiometric}
    assert same == {name: value for name, value in asdict(plain).items() if name not in radiometric}
    with pytest.raises(ValueError, match="choose another fidelity"):
        rs.Simulator(made, fidelity="documented").crossings(0, radiometric=True)
