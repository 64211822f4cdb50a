"""The in-process interface: order, records, determinism, truth."""

import hashlib
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.sources.numbers import FAINT
from tests.scenes import ONE_TARGET, point, scene

BUSY: dict[str, Any] = {"environment": {"noise": True}, "radar": {"range_max_m": 800, "azimuths": 90, "beamwidth_deg": 8}}


def busy(**sections: Any) -> rs.Scene:
    """Rest, motion, fluctuation, shadow and noise in one small scene."""
    hull = {"name": "h", "shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "position_m": [0, 300, 0]}
    return scene(
        [
            point("a", 100, 400), point("b", -300, 200, speed_kn=12, course_deg=40), point("c", 300, -200, swerling=2),
            {**hull, "material": "wood", "speed_kn": 10, "course_deg": 90},
        ],
        **BUSY, **sections,
    )  # fmt: skip


def samples(blocks: Iterable[rs.SpokeBlock]) -> str:
    """One hash over all samples and times."""
    total = hashlib.sha256()
    for block in blocks:
        for k in range(len(block)):
            total.update(block.field[k].tobytes() + block.power[k].tobytes() + block.time[k].tobytes())
    return total.hexdigest()


@pytest.mark.parametrize("fidelity", ["balanced", "documented"])
def test_same_seed_same_bytes_whatever_the_block_size(fidelity: str) -> None:
    made = busy()
    whole = samples(rs.Simulator(made, fidelity, seed=7).blocks(scans=2))
    for size in (1, 7, 1000):
        assert samples(rs.Simulator(made, fidelity, seed=7).blocks(scans=2, size=size)) == whole
    assert samples(rs.Simulator(made, fidelity, seed=8).blocks(scans=2)) != whole


def test_same_bytes_whatever_the_number_of_threads() -> None:
    """The busy scene from a moving ship, so that visibility snapshots and shadows pass between processes."""
    made = busy(own_ship={"speed_kn": 25, "course_deg": 70})
    alone = samples(rs.Simulator(made, "fast", seed=7).blocks(scans=2))
    assert samples(rs.Simulator(made, "fast", seed=7, threads=3).blocks(scans=2)) == alone


def test_scans_and_spokes_have_the_same_samples() -> None:
    """scan() and spokes() give the blocks' samples; numbers, times and bearings follow from the conventions."""
    made = busy()
    scans = [rs.Simulator(made).scan()]
    sim = rs.Simulator(made)
    spokes = list(sim.spokes(scans=1))
    assert [s.number for s in spokes] == list(range(90))
    np.testing.assert_array_equal(np.stack([s.field for s in spokes]), scans[0].field)
    np.testing.assert_array_equal(scans[0].azimuth, np.arange(90) * (2 * np.pi / 90))
    np.testing.assert_array_equal(scans[0].time, np.arange(90) * (60 / 24 / 90))
    np.testing.assert_allclose(scans[0].range, (np.arange(scans[0].field.shape[1]) + 0.5) * scans[0].range_step, rtol=1e-15)
    np.testing.assert_allclose(scans[0].power, np.abs(scans[0].field) ** 2, rtol=1e-6)  # float32
    following = next(sim.spokes(scans=1))
    assert (following.number, following.scan, following.index) == (90, 1, 0)
    assert following.time == pytest.approx(2.5, rel=1e-15)


def test_spokes_carry_own_ship_of_their_instant() -> None:
    made = scene([], own_ship={"speed_kn": 36, "course_deg": 90, "heading_deg": 80}, radar=BUSY["radar"])
    last = list(rs.Simulator(made).spokes(scans=1))[-1]
    assert last.position == pytest.approx((36 * 1852 / 3600 * last.time, 0.0))
    assert (last.course, last.heading) == pytest.approx((np.pi / 2, np.deg2rad(80)))
    assert last.speed == pytest.approx(18.52)


def test_an_empty_scene_is_silent_and_noise_alone_is_noise() -> None:
    assert rs.Simulator(scene([], radar=BUSY["radar"])).scan().power.max() == 0.0
    sim = rs.Simulator(scene([], **BUSY))
    mean = float(sim.scan().power.mean())
    assert mean == pytest.approx(sim.noise_power, rel=5 * 1.3 / np.sqrt(90 * 401))  # 5 sigma; neighbours correlate


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"threads": 0}, "threads: 0 is not allowed"),
        ({"fidelity": "sharp"}, 'fidelity: "sharp" is not one of auto, documented, fast, balanced, reference'),
        ({"fidelity": "documented", "labels": True}, "choose another fidelity"),
        ({"seed": -1}, "seed: -1 is not allowed"),
        ({}, "size: 0 is not allowed"),
    ],
)
def test_what_is_not_allowed_is_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        next(rs.Simulator(scene(), **arguments).blocks(size=0))


def test_a_skipped_scan_changes_nothing_but_which_scan_comes_next() -> None:
    """For bodies at rest; the visibility of moving ones is renewed from where the scan begins."""
    still = scene([point("a", 100, 400), point("c", 300, -200, swerling=2)], **BUSY)
    whole, later = rs.Simulator(still, seed=7), rs.Simulator(still, seed=7)
    whole.scan(), whole.scan()
    later.skip_to(2)
    expected, result = whole.scan(), later.scan()
    assert result.number == expected.number == 2 and np.array_equal(result.time, expected.time)
    assert np.array_equal(result.field, expected.field) and np.array_equal(result.power, expected.power)


def test_labels_go_with_spokes_scans_and_sectors_and_change_no_other_byte() -> None:
    made = rs.load_scene(
        ONE_TARGET | {"environment": {"noise": True, "sea_state": 1}, "radar": ONE_TARGET["radar"] | {"power_w": 10}}
    )
    plain, labelled = rs.Simulator(made, seed=2), rs.Simulator(made, seed=2, labels=True, threads=2)
    scan, with_labels = plain.scan(), labelled.scan()
    assert scan.labels is None and with_labels.labels is not None
    assert scan.field.tobytes() == with_labels.field.tobytes() and scan.power.tobytes() == with_labels.power.tobytes()
    assert with_labels.labels.shape == scan.power.shape and with_labels.labels.dtype == np.uint32
    assert (
        labelled.label_names[int(with_labels.labels[0, np.abs(scan.range - 300.0).argmin()])] == "p"
    )  # it stands to the north
    assert {labelled.label_names[n] for n in np.unique(with_labels.labels).tolist()} == {
        "noise",
        "sea",
        "p",
        "range sidelobes and faint parts",
    }
    labelled.skip_to(0)
    spokes = np.stack([spoke.labels for spoke in labelled.spokes(scans=1)])
    np.testing.assert_array_equal(spokes, with_labels.labels)
    sector = rs.Simulator(made, seed=2, labels=True, sector=(0.5, 1.0)).scan()
    inside = ~np.isnan(sector.time)
    assert 0 < inside.sum() < 10 and sector.labels is not None
    np.testing.assert_array_equal(sector.labels[inside], with_labels.labels[inside])
    assert not sector.labels[~inside].any()


def test_powers_of_sources_of_the_last_scan_add_up_to_its_labels() -> None:
    """The strongest of the powers is the label, or FAINT 30 dB below its body's peak in the spoke; but where two powers, or a
    power and that level, are equal to a twentieth."""
    made = busy(interference=[{"bearing_deg": 20, "level_db": 60, "prf_hz": 20e3, "beamwidth_deg": 60}])
    simulator = rs.Simulator(made, seed=1, labels=True)
    simulator.skip_to(3)
    scan = simulator.scan()
    powers = simulator.source_powers()
    assert set(powers) <= set(simulator.label_names) and {0, 3, 256, 257, 258} <= set(powers)
    assert all(power.shape == scan.power.shape and power.dtype == np.float32 for power in powers.values())
    np.testing.assert_allclose(powers[0], simulator.noise_power, rtol=1e-6)
    numbers, stacked = np.array(list(powers)), np.stack(list(powers.values()))
    ordered = np.sort(stacked, axis=0)
    clear = ordered[-1] > 1.05 * ordered[-2]
    assert clear.mean() > 0.9 and scan.labels is not None
    strongest = stacked.argmax(axis=0)
    expected, floor = numbers[strongest], 1e-3 * stacked.max(axis=-1, keepdims=True)
    over_floor = ordered[-1] / np.maximum(np.take_along_axis(floor, strongest[None], axis=0)[0], 1e-40)
    clear &= np.abs(over_floor - 1.0) > 0.05
    expected[(expected >= 256) & (over_floor < 1.0)] = FAINT
    assert 0.1 < (expected == FAINT).mean() < 0.9
    np.testing.assert_array_equal(expected[clear], scan.labels[clear])
    again = simulator.source_powers(3)
    np.testing.assert_array_equal(again[256], powers[256])
    with pytest.raises(ValueError, match="source_powers: the fidelity 'documented' has none"):
        rs.Simulator(busy(), fidelity="documented").source_powers()


@pytest.mark.parametrize("source", ["open-sea", {"name": "x"}])
def test_what_is_no_scene_is_refused_with_what_to_do(source: object) -> None:
    with pytest.raises(TypeError, match="is no Scene; load it first: Simulator\\(load_scene\\("):
        rs.Simulator(source)  # type: ignore[arg-type]


STEERED: dict[str, Any] = {
    "radar": {"azimuths": 32, "beamwidth_deg": 20, "range_max_m": 600, "pulse_s": 1e-6, "rpm": 60},
    "own_ship": {"steerable": {"max_speed_kn": 40}},
    "errors": {"gyro": {"bias_deg": 1.0}},
}


@pytest.fixture
def steered() -> rs.Simulator:
    return rs.Simulator(scene([point("p", 100, 200)], **STEERED), "fast")


def test_blocks_follow_each_other_and_are_reported_with_errors(steered: rs.Simulator) -> None:
    blocks = list(steered.blocks(2, 8))
    assert [block.first for block in blocks] == list(range(0, 64, 8)) and "next is scan 2" in repr(steered)
    assert all(block.true is not None for block in blocks)
    assert np.degrees(blocks[0].heading - blocks[0].true.heading) == pytest.approx(np.full(8, 1.0))


def test_a_command_cuts_the_blocks_where_it_acts(steered: rs.Simulator) -> None:
    steered.command(spoke=5, speed_kn=10, course_deg=90)
    blocks = list(steered.blocks(1, 8))
    assert sum(len(block) for block in blocks) == 32 and 5 in [block.first for block in blocks]
    speeds = np.concatenate([block.true.speed for block in blocks])
    assert (speeds[:5] == 0).all() and (speeds[5:] > 5).all()
    assert [block.commands for block in blocks] == [1] * len(blocks)
    assert steered.reported(np.array([0, 4, 6])).speed == pytest.approx([0.0, 0.0, 10 * 1852 / 3600])


def test_a_command_before_the_skip_is_followed_from_there(steered: rs.Simulator) -> None:
    """Nothing is computed that nobody asked for: an engine that goes on for another one gets its last commands late."""
    steered.skip_to(2)
    blocks = steered.blocks(1, 8)
    assert [next(blocks).first, next(blocks).first] == [64, 72]
    steered.command(time=40 / 32, speed_kn=20, course_deg=90)
    again = next(blocks)
    assert again.first == 64 and again.speed[0] == pytest.approx(20 * 1852 / 3600)


def test_a_request_acts_from_its_spoke_on_and_changes_no_byte(steered: rs.Simulator) -> None:
    """The simulator goes back for labels, but not where they are no longer requested."""
    whole = list(rs.Simulator(steered.scene, "fast", labels=True, powers="all").spokes(2))
    blocks = steered.blocks(2, 8)
    taken = [next(blocks), next(blocks)]
    steered.request_sources(labels=True, spoke=12)
    taken += [next(blocks), next(blocks)]
    steered.request_sources(powers=(256,))
    taken.append(next(blocks))
    steered.request_sources()
    taken += list(blocks)
    spans = [(block.first, len(block), block.labels is not None, block.powers is not None) for block in taken]
    assert spans[:6] == [(0, 8, False, False), (8, 8, False, False), (12, 8, True, False), (20, 8, True, False),
                         (28, 4, False, True), (32, 8, False, False)]  # fmt: skip
    assert [block.requests for block in taken[:6]] == [0, 0, 1, 1, 2, 3]
    for spoke in (spoke for block in taken for spoke in block.spokes()):
        expected = whole[spoke.number]
        assert spoke.field.tobytes() == expected.field.tobytes() and spoke.heading == expected.heading
        assert spoke.labels is None or spoke.labels.tobytes() == expected.labels.tobytes()
        assert spoke.powers is None or spoke.powers[256].tobytes() == expected.powers[256].tobytes()


def test_a_request_before_a_skip_adds_no_scan(steered: rs.Simulator) -> None:
    list(steered.blocks(1, 32))
    steered.request_sources(labels=True)
    steered.skip_to(4)
    assert [(block.scan, block.labels is not None) for block in steered.blocks(1, 32)] == [(4, True)]
