"""The outline of many triangles before a body, as the antenna has it: a few quads that cast the same shadow.

On a plane across the way to the body, at a distance of 1, a virtual position has coordinates u to the right and v up. Straight
edges stay straight there. The outline is what lies between the lowest and the highest point of the triangles at each u.
"""

from typing import NamedTuple, Self

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Floats, Indices
from radar_service.scattering.physical_optics.picture import NEAREST, Picture

SHARE, FINEST = 0.002, 0.02  # of the body's height, and m at the body: an outline errs by the larger of both at most
MARGIN = 0.02  # of the body's width and height by which outlines reach beyond it
SLIVER = 1e-3  # of the tolerance: triangles of an outline that are less high are left out
NARROW = 1e-7  # of the width: cuts of an outline that are nearer to each other are one
COLUMNS = 128  # between the sides of a body, in which gaps between groups are looked for
APART, APART_SHARE = 0.01, 1e-5  # m and share of its distance in front of a body where outlines stand at the latest
WIDEST = 10.0  # u: of what lies further aside of the middle of a body there is no outline


class Outlook(NamedTuple):
    """A body as the antenna has it, in the plane of its outline.

    ahead: (2,) unit vector in plan to its middle.
    left, right, low, high: u and v between which it lies.
    nearest, middle: distances along `ahead` [m].
    tolerance: of outlines, in v.
    """

    ahead: Floats
    left: float
    right: float
    low: float
    high: float
    nearest: float
    middle: float
    tolerance: float

    @classmethod
    def of(cls, box: Floats, picture: Picture) -> Self | None:
        """The outlook on the corners (8, 3) of a box around a body on the map [m]; None where it lies about the antenna."""
        virtual = picture.virtual(box)
        middle = virtual[:, :2].mean(axis=0)
        ahead = middle / max(float(np.hypot(*middle)), NEAREST)
        along = virtual[:, :2] @ ahead
        nearest = float(along.min()) * (1.0 - APART_SHARE) - APART
        if nearest < NEAREST:
            return None
        u, v = virtual[:, :2] @ [ahead[1], -ahead[0]] / along, virtual[:, 2] / along
        if np.abs(u).max() > WIDEST:
            return None
        left, right, low, high = (float(bound) for bound in (u.min(), u.max(), v.min(), v.max()))
        wider, higher = MARGIN * (right - left), MARGIN * (high - low)
        bounds = (left - wider, right + wider, low - higher, high + higher)
        tolerance = max(SHARE * (high - low), FINEST / float(along.max()))
        return cls(ahead, *bounds, nearest=nearest, middle=float(along.mean()), tolerance=tolerance)

    def outlines(self, virtual: Floats, group: Indices, distance: float) -> Floats:
        """Triangles (N, 3, 3) at a distance along `ahead` [m] that hide what triangles (T, 3, 3) of groups (T,) do before it, all
        at virtual positions. Groups that overlap at all u are one; a group that has fewer triangles stays itself."""
        order = np.argsort(group, kind="stable")
        virtual, group = virtual[order], group[order]
        strips, of_strip = self._strips(virtual, virtual, group)
        if group.any() and len(strips):
            layer = self._layers(strips, of_strip, 1 + int(group.max()))
            group = layer[group]
            below, above = (self._in_space(strips[:, [0, edge]].transpose(0, 2, 1))[:, [0, 1, 1]] for edge in (1, 2))
            strips, of_strip = self._strips(above, below, layer[of_strip])
        u, low, high = strips.transpose(1, 0, 2)
        drawn, most = (high - low)[:, ::-1] > SLIVER * self.tolerance, 1 + int(group.max(initial=0))
        fewer = np.bincount(of_strip, drawn.sum(axis=1), most) < np.bincount(group, minlength=most)
        corner = np.stack([np.concatenate([u, u[:, ::-1]], axis=1), np.concatenate([low, high[:, ::-1]], axis=1)], axis=2)
        triangle = corner[:, [[0, 1, 2], [2, 3, 0]]][drawn & fewer[of_strip, None]]
        return np.concatenate([virtual[~fewer[group]], distance * self._in_space(triangle)])

    def _strips(self, above: Floats, below: Floats, group: Indices) -> tuple[Floats, Indices]:
        """Strips (S, 3, 2) of the outlines of groups, (u, u), (lowest v, v) and (highest v, v), and the group of each (S,).

        above, below: triangles (T, 3, 3) of groups (T,) at virtual positions, for the highest and the lowest points.
        """
        pitch = 2.0 * (self.right - self.left)
        shift: Floats = pitch * group.astype(np.float64)
        upper, lower = self._skyline(above, shift), self._skyline(below, shift, -1.0)
        cuts = np.unique(np.concatenate([upper[:, :, 0], lower[:, :, 0]]))
        cuts = cuts[np.diff(cuts, prepend=-np.inf) > NARROW * pitch]
        within = (cuts[1:] + cuts[:-1]) / 2.0
        top, bottom = _piece_at(upper[:, :, 0], within), _piece_at(lower[:, :, 0], within)
        strip = np.flatnonzero((top >= 0) & (bottom >= 0))
        u = np.stack([cuts[strip], cuts[strip + 1]], axis=1)
        of_strip = np.rint((within[strip] - self.left) / pitch - 0.25).astype(np.int64)
        ends = [_between(c[..., 0], c[..., 1], u) for c in (lower[bottom[strip]], upper[top[strip]])]
        return np.stack([u - pitch * of_strip[:, None], *ends], axis=1), of_strip

    def _layers(self, strips: Floats, of_strip: Indices, groups: int) -> Indices:
        """The layer (G,) of each group with strips (S, 3, 2) of groups (S,): within one, no gap between groups is filled."""
        shift = 2.0 * (self.right - self.left) * np.arange(groups)
        u = (np.linspace(self.left, self.right, COLUMNS + 2)[1:-1] + shift[:, None]).ravel()
        ends = strips[:, 0] + shift[of_strip, None]
        piece = _piece_at(ends, u)
        lows, highs = (_between(ends[piece], strips[piece, edge], u[:, None])[:, 0] for edge in (1, 2))
        bounds = np.where(piece < 0, np.nan, [lows, -highs]).reshape(2, groups, COLUMNS)
        layers: list[Floats] = []
        result = np.zeros(groups, dtype=np.int64)
        for group in np.unique(of_strip):
            own = bounds[:, group]
            fits = (k for k, layer in enumerate(layers) if not (np.maximum(layer, own).sum(axis=0) > self.tolerance).any())
            result[group] = number = next(fits, len(layers))
            layers[number:] = [np.fmin(layers[number], own) if number < len(layers) else own, *layers[number + 1 :]]
        return result

    def _in_space(self, points: Floats) -> Floats:
        """Virtual positions (..., 3) of (u, v) (..., 2) at a distance of 1."""
        plan = self.ahead + points[..., :1] * [self.ahead[1], -self.ahead[0]]
        return np.concatenate([plan, points[..., 1:]], axis=-1)

    def _skyline(self, virtual: Floats, shift: Floats, up: float = 1.0) -> Floats:
        """Chords (C, 2, 2) of (u, v) along the highest points of triangles (T, 3, 3) at virtual positions, shifted in u by (T,);
        up: -1 for the lowest."""
        low, high = (self.low, self.high) if up > 0.0 else (-self.high, -self.low)
        bounds, turned = (self.left, self.right, low, high, self.tolerance / 2.0), virtual * [1.0, 1.0, up]
        room = 256 + len(virtual)
        while True:
            chords = np.empty((room, 2, 2))
            count = KERNELS.skyline(len(virtual), room, *bounds, self.ahead, np.ascontiguousarray(turned), shift, chords)
            if count <= room:
                return chords[:count] * [1.0, up]
            room = count


def _piece_at(ends: Floats, u: Floats) -> Indices:
    """The piece (M,), of those with ends (C, 2), over each u (M,); -1: none."""
    piece = np.searchsorted(ends[:, 0], u, side="right") - 1
    return np.where((piece >= 0) & (ends[piece, 1] > u), piece, -1) if len(ends) else np.full(len(u), -1)


def _between(ends: Floats, v: Floats, u: Floats) -> Floats:
    """v (M, N) at u (M, N) between ends (M, 2) where it is v (M, 2)."""
    share = (u - ends[:, :1]) / (ends[:, 1:] - ends[:, :1])
    return np.asarray((1.0 - share) * v[:, :1] + share * v[:, 1:])
