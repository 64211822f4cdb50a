"""Sea and rain clutter in a scene: their keys; rain cells, how they move, and how much of a ray lies in one."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydantic import Field

from radar_service.numerics import KNOT, Flags, Floats, Indices
from radar_service.propagation import rain_db_per_km
from radar_service.radar import Radar
from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import DEGREE, Bearing, EastNorth, Number, Section
from radar_service.world import Attenuator, SightLines

if TYPE_CHECKING:
    from radar_service.world import Scene

SEA, RAIN = 1, 2  # numbers of its sources
TEXTURE_SHAPE = "sea_texture_shape"  # nu of the gamma texture
RAIN_CELL = "rain_cell"
MAX_CELLS, MAX_CORNERS = 50, 100
MIN_AREA = 1e4  # m^2


class RainCellModel(Section):
    """Rain inside a circle or an outline, which keeps its shape as it moves; it adds to `rain_mm_h` of the environment."""

    rain_mm_h: Number = Field(gt=0, le=300)
    position_m: EastNorth | None = Field(None, description="of its centre at t = 0: east, north")
    radius_m: Number | None = Field(None, ge=50, le=1e6)
    outline_m: tuple[EastNorth, ...] | None = Field(
        None, max_length=MAX_CORNERS, description="or its corners at t = 0, in order; the last may repeat the first"
    )
    course_deg: Bearing = 0.0
    speed_kn: Number = Field(0.0, ge=0, le=100)

    def problems(self) -> Iterator[str]:
        if self.outline_m is None:
            for key in ("position_m", "radius_m"):
                if getattr(self, key) is None:
                    yield f"{key}: a rain cell needs position_m and radius_m, or outline_m; add {key}"
            return
        for key in ("position_m", "radius_m"):
            if getattr(self, key) is not None:
                yield f"{key}: outline_m already says where the cell is; remove one of the two"
        corners = _corners(self.outline_m)
        if len(corners) < 3:
            yield f"outline_m: {len(corners)} corners enclose nothing; give 3 to {MAX_CORNERS}"
        elif len(np.unique(corners, axis=0)) < len(corners) or _crosses_itself(corners):
            yield "outline_m: it crosses or touches itself; give the corners in order around the cell, each once"
        elif abs(_area(corners)) < MIN_AREA:
            yield f"outline_m: it encloses {abs(_area(corners)):.4g} m2; give {MIN_AREA:g} m2 or more"


@dataclass(frozen=True)
class RainCell:
    """Rain inside a circle, or an outline within that circle.

    rain_mm_h: rate. centre: east, north at t = 0 [m]. radius: [m]. velocity: east, north [m/s].
    outline: corners from the centre [m], clockwise on the map; none: all of the circle.
    """

    rain_mm_h: float
    centre: tuple[float, float]
    radius: float
    velocity: tuple[float, float]
    outline: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(cls, model: RainCellModel) -> "RainCell":
        """Returns the cell of a model."""
        course, speed = model.course_deg * DEGREE, model.speed_kn * KNOT
        velocity = float(speed * np.sin(course)), float(speed * np.cos(course))
        if model.outline_m is None:
            assert model.position_m is not None and model.radius_m is not None
            return cls(model.rain_mm_h, model.position_m, model.radius_m, velocity)
        corners = _corners(model.outline_m)
        corners = corners if _area(corners) < 0.0 else corners[::-1]
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
        radius, outline = float(np.hypot(*(corners - middle).T).max()), tuple(map(tuple, (corners - middle).tolist()))
        return cls(model.rain_mm_h, (float(middle[0]), float(middle[1])), radius, velocity, outline)

    def position(self, time: Floats | float) -> Floats:
        """Returns the centre (..., 2) [m] on the map at times of any shape [s]."""
        return np.asarray(self.centre + np.multiply.outer(time, self.velocity))

    def db_per_m(self, radar: Radar) -> float:
        """Returns the one-way attenuation of its rain [dB/m] (ITU-R P.838)."""
        return rain_db_per_km(self.rain_mm_h, radar.polarization, radar.frequency) / 1000.0

    def paths(self, offset: Floats, sine: Floats, cosine: Floats, distance: Floats) -> tuple[Indices, Floats]:
        """Which rays (R,) meet the cell's circle, and how much of these lies in the cell up to distances: (R, N) [m].

        offset: (2,) or (M, 2) of its centre from the antenna [m]; sine, cosine: (M,) of azimuths; distance: (1 or M, N) [m].
        """
        along = offset[..., 0] * sine + offset[..., 1] * cosine
        across = offset[..., 0] * cosine - offset[..., 1] * sine
        rows = np.flatnonzero((np.abs(across) < self.radius) & (along > -self.radius))
        far = distance if len(distance) == 1 else distance[rows]
        inside = np.zeros((len(rows), far.shape[1]))
        for crossed, where, sign in self._crossings(along[rows], across[rows], sine[rows], cosine[rows]):
            until = far if len(far) == 1 else far[crossed]
            inside[crossed] += sign * np.minimum(np.maximum(where, 0.0)[:, None], until)
        return rows, inside

    def _crossings(
        self, along: Floats, across: Floats, sine: Floats, cosine: Floats
    ) -> Iterator[tuple[Indices | slice, Floats, Floats | float]]:
        """Yields rays, the distances (X,) [m] at which they cross an edge, and -1 for the way in, 1 for the way out."""
        if not self.outline:
            half = np.sqrt(self.radius**2 - across**2)
            yield slice(None), along - half, -1.0
            yield slice(None), along + half, 1.0
            return
        east, north = np.array(self.outline).T[..., None]
        ahead, right = along + east * sine + north * cosine, across + east * cosine - north * sine
        is_right: Flags = right > 0.0
        for k in range(len(self.outline)):
            crossed = np.flatnonzero(is_right[k - 1] != is_right[k])
            u, v = ahead[:, crossed], right[:, crossed]
            where = u[k - 1] - v[k - 1] * (u[k] - u[k - 1]) / (v[k] - v[k - 1])
            yield crossed, where, np.where(is_right[k, crossed], 1.0, -1.0)[:, None]


class CellPath(NamedTuple):
    """A cell, the rays (R,) that meet its circle, and how much of these lies in it up to some distances (R, N) [m]."""

    cell: RainCell
    rows: Indices
    inside: Floats


@dataclass(frozen=True)
class RainCells(Attenuator):
    """The rain cells of a scene."""

    cells: tuple[RainCell, ...]

    def paths(self, antenna: Floats, time: Floats | float, azimuth: Floats, distance: Floats) -> Iterator[CellPath]:
        """Yields the path in each cell of rays (M,). antenna, time, azimuth: as of `SightLines`; distance: (1 or M, N) [m]."""
        sine, cosine = np.sin(azimuth), np.cos(azimuth)
        for cell in self.cells:
            rows, inside = cell.paths(cell.position(time) - antenna[..., :2], sine, cosine, distance)
            if len(rows):
                yield CellPath(cell, rows, inside)

    def one_way_db(self, radar: Radar, lines: SightLines) -> Floats:
        """Returns the attenuation (E,) [dB] as of uniform rain (ITU-R P.838), over the part of each line inside cells."""
        lost = np.zeros(len(lines.azimuth))
        for cell, rows, inside in self.paths(lines.antenna, lines.time, lines.azimuth, lines.distance[:, None]):
            lost[rows] += cell.db_per_m(radar) * inside[:, 0]
        return lost

    @property
    def text(self) -> str:
        """What it is, in a few words."""
        most = max(cell.rain_mm_h for cell in self.cells)
        return f"{len(self.cells)} rain cell{'s' if len(self.cells) > 1 else ''} up to {most:g} mm/h"


def _corners(outline: tuple[tuple[float, float], ...]) -> Floats:
    """Corners (V, 2) [m], without one at the end that repeats the first."""
    closed = len(outline) > 1 and outline[0] == outline[-1]
    return np.array(outline[:-1] if closed else outline, dtype=np.float64).reshape(-1, 2)


def _area(corners: Floats) -> float:
    """Area [m^2]; negative where the corners (V, 2) go clockwise on the map."""
    following = np.roll(corners, -1, axis=0)
    return float(np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0])) / 2.0


def _crosses_itself(corners: Floats) -> bool:
    """Whether an edge crosses another one, or touches it between its ends."""
    ends = np.roll(corners, -1, axis=0)

    def side(point: Floats) -> Floats:
        """Twice the area of each edge with each point (V, V): its sign is the side."""
        edge, arm = (ends - corners)[:, None], point[None] - corners[:, None]
        return np.sign(edge[..., 0] * arm[..., 1] - edge[..., 1] * arm[..., 0])

    between = side(corners) * side(ends)
    return bool(((between < 0.0) & (between.T <= 0.0)).any())


class ClutterEffect(Effect):
    """Echoes of the sea and of rain. Sea state, wind and rain are of the environment, as they act on other echoes too."""

    name = "clutter"
    stage_at = "radar_service.stages.clutter.stage:ClutterStage"
    environment_keys = {
        TEXTURE_SHAPE: (
            Number | None,
            Field(None, ge=0.05, le=1000, description="K distribution: small is spiky; default by grazing angle and cell"),
        ),
        RAIN_CELL: (tuple[RainCellModel, ...], Field((), max_length=MAX_CELLS, description="rain with edges that move")),
    }
    sources = (Source("sea", "clutter", SEA), Source("rain", "clutter", RAIN))

    def environment_value(self, key: str, value: Any) -> Any:
        if key != RAIN_CELL:
            return value
        return RainCells(tuple(map(RainCell.of, value))) if value else ()

    def scene_text(self, scene: "Scene") -> str:
        cells = scene.environment.effect_keys.get(RAIN_CELL)
        return "" if cells is None else cells.text

    def is_in(self, scene: "Scene") -> bool:
        return True  # the plan of every scene says whether it has any
