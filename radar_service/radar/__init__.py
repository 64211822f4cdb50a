"""The radar: parameters, antenna patterns, waveform."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.radar.antenna import AntennaPattern, azimuth_oversampling, grid_rows, interpolated_gain
    from radar_service.radar.aperture import FAINTEST, MAX_OFFSET, Aperture, ChangedPattern, FieldChange, aperture_of
    from radar_service.radar.crossing_times import STEPS, CrossingSearch
    from radar_service.radar.description import radar_lines
    from radar_service.radar.folding import (
        ALIASES, KERNEL_WIDTHS, chirp_error_db, least_chirp_error_db, remedies, sampling_error_db
    )  # fmt: skip
    from radar_service.radar.parameters import FIRST_ID, NearPulse, Radar, horizon, in_sector, max_rpm
    from radar_service.radar.patterns import (
        PATTERNS, Cosine, Cosine2, Gaussian, Printed, Sinc2, Table, Taylor, line_source, printed_two_way
    )  # fmt: skip
    from radar_service.radar.sets import radar_sets
    from radar_service.radar.waveform import chirp_spectrum, pulse_doppler_shift, window_coefficients
else:
    __getattr__, __dir__ = lazily(__name__)
