"""Named profiles of errors on purpose: tables of a scene file.

imo-a823: IMO resolution A.823(19), appendix 3, "Sensor errors". Of the gyro compass: calibration error 0.5 degrees, normal
distribution about this with sigma = 0.12 degrees. Of the log: calibration error 0.5 knots, normal distribution about this with
3 sigma = 0.2 knots. Of the antenna: backlash rectangular, +-0.05 degrees at most; bearing quantisation rectangular, +-0.1
degrees at most; encoder normal, sigma = 0.03 degrees. It has no position and no correlation times: those are the defaults.
What it says of targets, of roll and pitch, and of beam and pulse comes from the scene: the engine computes these.
"""

from typing import Any

PROFILES: dict[str, dict[str, dict[str, Any]]] = {
    "imo-a823": {
        "gyro": {"bias_deg": 0.5, "noise_deg": 0.12},
        "log": {"bias_kn": 0.5, "noise_kn": 0.2 / 3.0},
        "antenna": {"backlash_deg": 0.05, "encoder_step_deg": 0.2, "encoder_noise_deg": 0.03},
    },
}
