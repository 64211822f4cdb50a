"""Where every method and model fails, found by driving it there: one small study to a region, one finding to a study."""

from radar_service.study.stability import path, picture, pulse, running, sampling, tracing, turning
from radar_service.study.stability.finding import Study

STUDIES: tuple[Study, ...] = (
    tracing.float32_range,
    tracing.triangle_size,
    tracing.sliver_width,
    tracing.shared_edges,
    tracing.grazing_sight,
    tracing.wide_maps,
    sampling.missed_targets,
    sampling.undersampled_facet,
    pulse.sampling_rate,
    pulse.short_chirps,
    pulse.far_end,
    pulse.range_ends,
    pulse.dynamic_range,
    pulse.single_precision,
    turning.north,
    turning.narrow_beam,
    turning.headings,
    path.range_to_zero,
    path.two_ray_null,
    path.null_depth,
    path.flat_earth,
    path.horizon,
    path.divergence_edge,
    path.roughness,
    picture.pixel_size,
    picture.spokes_lost,
    picture.numbered_anew,
    running.fast_targets,
    running.slow_turns,
    running.doppler_in_the_pulse,
    running.months,
    running.numbers_at_the_end,
)
