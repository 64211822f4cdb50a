"""No range sidelobes stand behind the ships of the basin; they do behind a linear chirp with a window."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import radar_service as rs
from tests.scenes import SHIPPED, basin

SHIPS = ("tanker at anchor", "ferry", "coaster")
LENGTHS = {"tanker at anchor": 180.0, "ferry": 100.0, "coaster": 90.0}  # m, upper bounds: streaks are sought beyond


def ships(**radar: Any) -> tuple[rs.Simulator, rs.Scan]:
    """The first scan of these ships alone, in noise and on a calm sea; radar: settings that replace those of the basin."""
    source = basin(**radar)
    source["body"] = [body for body in source["body"] if body["name"] in SHIPS]
    source["environment"] |= {"sea_state": 0}
    sim = rs.Simulator(rs.load_scene(source, folder=SHIPPED), fidelity="fast")
    return sim, sim.scan()


def behind(sim: rs.Simulator, scan: rs.Scan, name: str) -> tuple[float, NDArray[np.float64]]:
    """A ship's strongest cell over the noise [dB], and the mean power over the noise [dB] of ten stretches of 100 m behind it in
    that spoke."""
    truth = next(body for body in sim.truth(0.0).bodies if body.name == name)
    east, north = truth.position[0], truth.position[1]  # own ship lies at the origin
    spokes = len(scan.power)
    power = np.roll(scan.power, 20 - round(np.arctan2(east, north) / (2 * np.pi) * spokes), axis=0)[:40] / sim.noise_power
    near = np.abs(scan.range - np.hypot(east, north)) < LENGTHS[name]
    spoke = power[int(power[:, near].max(axis=1).argmax())]
    peak = int(np.flatnonzero(near)[spoke[near].argmax()])
    edges = scan.range[peak] + LENGTHS[name] + 100.0 * np.arange(11)
    stretches = [spoke[(scan.range >= a) & (scan.range < b)].mean() for a, b in zip(edges[:-1], edges[1:], strict=True)]
    return float(10 * np.log10(spoke[peak])), 10 * np.log10(np.array(stretches))


def test_there_is_noise_alone_behind_a_ship_of_the_basin() -> None:
    """A stretch has 50 cells, of which neighbours correlate: about 20 independent ones, so its mean scatters by 1 dB; 3 dB. The
    sidelobes themselves are 93 dB below the peak at first, and 110 dB after 20 cells."""
    sim, scan = ships()
    for name in SHIPS:
        peak, stretches = behind(sim, scan, name)
        assert peak > 75.0 and np.abs(stretches).max() < 3.0, name


def test_a_linear_chirp_leaves_streaks_of_a_kilometre() -> None:
    """Blackman's window on the reference: the ends of the chirp leave 58 to 66 dB below the peak."""
    sim, scan = ships(modulation="lfm", compression="matched", window="blackman")
    for name in SHIPS:
        peak, stretches = behind(sim, scan, name)
        assert stretches[:8].min() > 10.0 and peak - stretches.max() < 66.0, name
