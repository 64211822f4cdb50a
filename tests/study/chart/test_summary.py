"""The chart in words."""

from radar_service.study.chart.figure import summary, summary_text
from radar_service.study.chart.point import Point


def test_the_summary_lists_presets_the_fastest_and_the_slow() -> None:
    points = [
        Point("field", "integer-delay chirps", "printed beam", (0.04,), True, -2.0, preset="documented"),
        Point("field", "integer-delay chirps", "12 beamwidths", (0.05,), True, -17.0),
        Point("field", "Kaiser-Bessel grid", "4 bins", (3.3e-4,), False, -62.0, preset="fast"),
        Point("field", "azimuth by azimuth", "3 beamwidths", (4e-4,), False, -60.0, preset="fast under way"),
    ]
    assert summary(points, 3.5e-3) == {
        "field": [
            "documented: -2 dB in 40 ms",
            "fast: -62 dB in 330 us; under way -60 dB in 400 us",
            "documented chain with corrected beam: -17 dB",
            "fastest within -40 dB: Kaiser-Bessel grid (4 bins), -62 dB in 330 us",
            "slower than real time (3.5 ms): 2 of 4 settings",
        ]
    }


def test_the_summary_names_misses_and_models() -> None:
    points = [
        Point("power", "scatterers", "4 per cell", (5e-4,), False, 0.2, 0.9, 0.0, "balanced"),
        Point("power", "documented rays", "2000", (6e-4,), False, 9.6, 4.9, 0.63, "documented"),
        Point("power", "uniform rays", "500", (1e-4,), False, None, None, 1.0),
        Point("power", "uniform rays", "8000", (1e-3,), False, 1.0, 2.0, 0.016),
        Point("scattering", "physical optics", "2 bounces", (1e-5,), False, 23.0, 18.0, 0.0, "fast"),
    ]
    lines = summary(points, 3.5e-3)
    assert lines["power"] == [
        "balanced: mean 0.2 dB, spread 0.9 dB, 500 us",
        "documented: mean 9.6 dB, spread 4.9 dB, 63 % missed, 600 us",
        "best rays, uniform rays (8000): mean 1 dB, spread 2 dB, 1.6 % missed, 1 ms",
        "miss more than half of their targets: 2 of 4 settings",
    ]
    assert lines["scattering"] == ["physical optics, 2 bounces = fast: mean 23 dB, spread 18 dB"]
    text = summary_text(lines)
    assert text.startswith("Samplers\n- balanced") and "\nScattering models\n- physical optics" in text
