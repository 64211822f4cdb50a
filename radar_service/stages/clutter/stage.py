"""Sea and rain clutter as a stage."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Self

from radar_service.receive import compression_for
from radar_service.records import Fidelity, PlanItem
from radar_service.stages.clutter.clutter import RAIN_HEIGHT, RAYS, Clutter, prepare_clutter
from radar_service.stages.clutter.effect import RAIN_CELL, TEXTURE_SHAPE, RainCells
from radar_service.stages.clutter.resolution_cell import MIN_CLUTTER_TO_NOISE, resolution_cell
from radar_service.stages.clutter.sea import MAX_MEASURED_STATE, beyond_measured_shapes
from radar_service.stages.effect import EffectTruth
from radar_service.stages.registry import changed_pattern
from radar_service.stages.stage import Context, Stage, Tile
from radar_service.trace import OcclusionScene
from radar_service.world import Scene


class RainTruth(EffectTruth):
    """The truth of rain cells."""

    def __init__(self, cells: RainCells) -> None:
        self._cells = cells

    def at_end(self, time: float) -> Mapping[str, Any]:
        """Returns the rate, and the circle or the corners of each cell on the map [m]."""
        cells = []
        for cell in self._cells.cells:
            at = cell.position(time)
            corners = [(at + corner).tolist() for corner in cell.outline]
            shape = {"outline": corners} if corners else {"position": at.tolist(), "radius": cell.radius}
            cells.append({"rain_mm_h": cell.rain_mm_h, **shape})
        return {"rain_cells": cells}


class ClutterStage(Stage):
    """The clutter of a scene; None where neither sea nor rain is strong enough."""

    def __init__(self, context: Context, clutter: Clutter | None) -> None:
        self.context, self.clutter = context, clutter

    @classmethod
    def of(cls, context: Context) -> Self:
        of, seeds = (context.scene, context.line_of_sight, context.compression), (context.seed, context.noise_seed)
        return cls(context, prepare_clutter(*of, *seeds))

    @classmethod
    def plan(cls, scene: Scene, fidelity: Fidelity, microseconds: float | None) -> Sequence[PlanItem]:
        environment = scene.environment
        sea, rain = environment.sea_state, environment.rain_mm_h
        fit = "" if sea <= MAX_MEASURED_STATE else f" (as {MAX_MEASURED_STATE}, the highest measured)"
        level = f"NRL 2012 sigma0 of sea state {sea:.3g}{fit}, GIT wind factor"
        texture = _texture(scene, fidelity) if sea else ""
        sea_text = f"{level}, K-distributed: {texture}; shadows of resting bodies"
        everywhere, cells = f"{rain:g} mm/h everywhere", environment.effect_keys.get(RAIN_CELL)
        raining = rain > 0 or cells is not None
        if cells is not None:
            everywhere = f"{everywhere} and " * (rain > 0) + f"{cells.text}, cut at edges on {RAYS} rays a beam,"
        rain_text = f"Marshall-Palmer, {everywhere} up to {RAIN_HEIGHT:g} m, Rayleigh"
        floor = f"; none below {10 * math.log10(MIN_CLUTTER_TO_NOISE):g} dB of the noise" if environment.noise else ""
        error = 10.0 * math.log10(1.0 + MIN_CLUTTER_TO_NOISE) if environment.noise else None
        items = [
            PlanItem("sea clutter", sea > 0, sea_text + floor if sea else "sea state 0",
                   error if sea else None, microseconds=microseconds if sea else None),
            PlanItem("rain clutter", raining, rain_text + floor if raining else "no rain",
                   error if raining else None, microseconds=microseconds if raining and not sea else None),
        ]  # fmt: skip
        return [item for item in items if item.modelled or fidelity.engine != "documented"]

    @classmethod
    def truth(cls, scene: Scene, line_of_sight: OcclusionScene) -> "RainTruth | None":
        cells = scene.environment.effect_keys.get(RAIN_CELL)
        return None if cells is None else RainTruth(cells)

    def add(self, tile: Tile) -> None:
        azimuths = tile.azimuths
        rows = None if self.clutter is None else self.clutter.rows(azimuths.number, tile.transmitting[:, None])
        if rows is None:
            return
        scene = self.context.scene
        if (pattern := changed_pattern(scene.radar)) is not None:
            rows = rows.behind(pattern.clutter_power(azimuths.boresight - scene.platform.heading(azimuths.time)))
        tile.add_field(rows)


def _texture(scene: Scene, fidelity: Fidelity) -> str:
    """Says of the texture where its shape is from, in which cells before the horizon it is extrapolated, and that waves show."""
    environment, radar = scene.environment, scene.radar
    shape = environment.effect_keys[TEXTURE_SHAPE]
    waves = "" if environment.seaway is None else ", in the rows of the waves that move ships"
    if shape is not None:
        return f"shape {shape:g}{waves}"
    cell = resolution_cell(radar.azimuth_gain, compression_for(radar, fidelity.kernel_width), radar.range_step)
    farthest = min(radar.range_max, scene.horizon())
    beyond = beyond_measured_shapes(cell.length, (cell.width * radar.height, cell.width * farthest))
    return f"shape by grazing angle and cell (Ward){beyond}{waves}"
