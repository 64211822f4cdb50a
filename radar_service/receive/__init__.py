"""The receiver: gridding, beam filter, compression, noise, eclipsing, interference, detection."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.receive.beam import azimuth_kernel, beam_filter, beam_spectrum
    from radar_service.receive.compression import (
        Compression, compression_for, noise_spectrum, range_kernel, receiver_noise_power, waveform_spectra
    )  # fmt: skip
    from radar_service.receive.documented_receiver import (
        beam_spread, chirp, chirp_sum, compress, detect, exact_chirp_sum, impulse_sum, printed_phase, pulse_times,
        sample_delay, window
    )  # fmt: skip
    from radar_service.receive.gridding import Kernel, KernelTable, spread
    from radar_service.receive.noise import GaussianSpectrum, integrate
    from radar_service.receive.plain_pulse import PulseKernel
else:
    __getattr__, __dir__ = lazily(__name__)
