"""Arithmetic that all share: constants, types, frames of reference, random numbers, threads, caches."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.numerics.arithmetic_name import arithmetic
    from radar_service.numerics.constants import (
        BOLTZMANN, DISPLAY_RANGES, EARTH_RADIUS, GRAVITY, KNOT, MAX_COORDINATE, NAUTICAL_MILE, REFERENCE_TEMPERATURE,
        SPEED_OF_LIGHT
    )  # fmt: skip
    from radar_service.numerics.frames import (
        Polar, bearing_text, body_rotation, direction, distances_from_map, effective_earth_radius, map_from_body,
        map_from_deck, polar_from_map, turned, wrap_angle, wrap_bearing
    )  # fmt: skip
    from radar_service.numerics.gamma_law import clutter_level_factor, known_level_factor
    from radar_service.numerics.kaiser_bessel import kernel_transform, shape_parameter
    from radar_service.numerics.parallel import BLAS_LIMIT
    from radar_service.numerics.ragged import batches, spans
    from radar_service.numerics.random import (
        BIASES, CAST, CHART, FEED, FLUCTUATION, HULL_PARTS, LEAN, NEAR_PULSE, NOISE, ORDER_STATISTIC, PLOT_ERRORS, RAYS,
        SCATTER, SCENARIO, SEAWAY, SENSOR, SPECKLE, STAGE, SWEEP_DRAW, SWEEP_LIST, SWEEP_SEED, TEXTURE, generator, name_key,
        normals, quantiles
    )  # fmt: skip
    from radar_service.numerics.result_cache import STEADY, ResultCache, Revision
    from radar_service.numerics.types import Complexes, Flags, Floats, Gain, Indices, Profiles, Singles
else:
    __getattr__, __dir__ = lazily(__name__)
