"""The models of a transmitted pulse in a scene file, and of one that serves the nearer ranges."""

from typing import Literal

from pydantic import Field

from radar_service.scene_file.model.fields import Number, Section


class WaveformModel(Section):
    """A pulse and the filter that compresses it."""

    modulation: Literal["lfm", "nlfm", "none"] = Field(
        "lfm",
        description='"nlfm": a nonlinear chirp, whose power spectrum is the window; "none": a plain pulse, as of a magnetron',
    )
    bandwidth_hz: Number | None = Field(
        None, ge=1e5, le=2e9, description='default 50e6; with modulation = "none" the receiver\'s, default 1.2 / pulse_s'
    )
    pulse_s: Number = Field(10e-6, ge=1e-8, le=1e-3)
    window: Literal["none", "hamming", "hann", "blackman", "blackman-harris", "nuttall", "taylor"] = Field(
        "hamming", description='on the reference of the chirp; with "nlfm" or "inverse" on the spectrum'
    )
    compression: Literal["matched", "inverse"] = Field(
        "matched",
        description='of a chirp; "inverse": by a filter that leaves the range sidelobes of the window alone',
    )

    @property
    def band_hz(self) -> float:
        """The bandwidth [Hz], given or by default; 1.2 / T is usual for the receiver of a plain pulse (Skolnik 2001)."""
        if self.bandwidth_hz is not None:
            return self.bandwidth_hz
        return 1.2 / self.pulse_s if self.modulation == "none" else 50e6


class PulseModel(WaveformModel):
    """One of several pulses, each of which serves the ranges from the end of the one before."""

    range_max_m: Number | None = Field(
        None,
        ge=10,
        le=200_000,
        description="end of the ranges that it serves; of the last pulse that of the radar, left out",
    )


WAVEFORM_KEYS = tuple(WaveformModel.model_fields)
