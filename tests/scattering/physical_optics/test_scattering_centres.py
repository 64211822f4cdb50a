"""Scattering centres: shares of points at the nodes of a lattice."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.scattering_centres import DROPPED, UPRIGHT, Lattice, strongest

K = 2 * np.pi / 0.03186
Floats = NDArray[np.float64]


def points_in(count: int, low: float, high: float) -> Floats:
    return np.random.default_rng(3).uniform([-20, -15, low], [20, 15, high], size=(count, 3))


def lattice(points: Floats, size: float | Floats, flattest: float = np.inf, lowest: float = -np.inf) -> Lattice:
    return Lattice.over(points, np.broadcast_to(size, len(points)), flattest, lowest)


def all_sums(made: Lattice, amplitude: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return made.sums(amplitude, np.zeros(len(amplitude), dtype=np.int64), 1)[0]


@pytest.mark.parametrize("lowest", [-np.inf, -1.37])
@pytest.mark.parametrize("mixed", [False, True])
def test_shares_reproduce_every_linear_weight(lowest: float, mixed: bool) -> None:
    """Shares are none below 0 and add up to 1, and weights that are linear have the same sums at nodes as at points, to
    rounding. So has every point by itself, whatever sizes the cells have."""
    points = points_in(3000, -1.37, 9.0)
    size = np.where(points[:, 0] > 3.0, 0.7, 1.9) if mixed else 1.9
    made = lattice(points, size, 1.5, lowest)
    assert made.share.min() >= 0.0
    np.testing.assert_allclose(made.share.sum(axis=0), 1.0, rtol=1e-12)
    np.testing.assert_allclose(np.einsum("cm,cmx->mx", made.share, made.nodes[made.corner]), points, atol=1e-11)
    amplitude = np.exp(1j * np.arange(3000.0))
    sums = all_sums(made, amplitude)
    np.testing.assert_allclose(sums.sum(), amplitude.sum(), atol=1e-9)
    np.testing.assert_allclose(sums @ made.nodes, amplitude @ points, atol=1e-7)


def test_sums_are_by_rows() -> None:
    points = points_in(100, 0.0, 5.0)
    made, amplitude, row = lattice(points, 2.0), np.arange(1.0, 101.0) + 0j, np.arange(100) % 3
    sums = made.sums(amplitude, row, 4)
    for number in range(4):
        np.testing.assert_allclose(sums[number], all_sums(made, np.where(row == number, amplitude, 0.0)), rtol=1e-12)


@pytest.mark.parametrize("lowest", [-0.4, 0.0, 2.3])
def test_no_node_lies_below_the_water(lowest: float) -> None:
    """Also where points round to just below it."""
    points = points_in(500, lowest, 4.0)
    points[:50, 2] = lowest - 1e-15
    made = lattice(points, 1.5, 1.0, lowest)
    assert made.nodes[:, 2].min() == lowest
    assert made.share.min() > -1e-12


def test_nodes_stay_where_they_are_on_the_body() -> None:
    """Other points add nodes and move none; every node is a corner of some point's cell."""
    points = points_in(200, 0.0, 9.0)
    few, many = (lattice(points[:n], 2.0, lowest=0.0) for n in (20, 200))
    assert {tuple(node) for node in few.nodes} <= {tuple(node) for node in many.nodes}
    np.testing.assert_allclose(few.nodes[few.corner[:, :20]], many.nodes[many.corner[:, :20]])
    assert (np.bincount(many.corner.ravel(), minlength=len(many.nodes)) > 0).all()


def test_cells_are_upright_or_as_flat_as_asked() -> None:
    points = points_in(500, 0.0, 9.0)
    for flattest, height in ((np.inf, 1.5 * UPRIGHT), (0.9, 0.9)):
        levels = np.unique(lattice(points, 1.5, flattest, 0.0).nodes[:, 2])
        np.testing.assert_allclose(np.diff(levels), height)


def test_a_held_node_errs_with_the_square_of_its_phase() -> None:
    """A side of 12 m that turns about the vertical: with theta the change of phase from node to node, its field is that of
    its points to theta^2 / 12 (theta^4 / 240 more). Points that lie at one node each would err by theta."""
    points = np.linspace([-6.0, 0.0, 0.0], [6.0, 0.0, 0.0], 4801)
    made = lattice(points, 0.75)
    sums = all_sums(made, np.full(4801, 1.0 / 4801 + 0j))
    errors = []
    for theta in (0.1, 0.2, 0.4):
        gradient = theta / 0.75
        field = [np.sum(a * np.exp(1j * gradient * p[:, 0])) for a, p in ((1.0 / 4801, points), (sums, made.nodes))]
        errors.append(1.0 - abs(field[1] / field[0]))
    np.testing.assert_allclose(errors, np.array([0.1, 0.2, 0.4]) ** 2 / 12.0, rtol=0.05)


def test_nothing_stays_nothing() -> None:
    made = lattice(np.zeros((0, 3)), 2.0)
    assert len(made.nodes) == 0 and len(all_sums(made, np.zeros(0, dtype=np.complex128))) == 0
    assert len(strongest(np.zeros(0))) == 0


@pytest.mark.parametrize(("total", "left"), [(0.99, 1), (1.5, 335)])
def test_what_is_left_out_is_faint_even_together(total: float, left: int) -> None:
    """One strong centre and a thousand faint ones whose powers add up to just under -60 dB of its power: gone; over: only what
    is over stays."""
    level = np.full(1001, np.sqrt(total * DROPPED / 1000))
    level[500] = 1.0
    kept = strongest(level)
    assert abs(len(kept) - left) <= 1 and 500 in kept and (np.diff(kept) > 0).all()


def test_values_between_nodes_are_linear() -> None:
    points = np.random.default_rng(3).uniform(-3.0, 3.0, (40, 3))
    lattice = Lattice.over(points, np.full(40, 0.5), np.inf, -np.inf)
    np.testing.assert_allclose(lattice.between(lattice.nodes @ [1.0, -2.0, 0.5] + 4.0), points @ [1.0, -2.0, 0.5] + 4.0)
