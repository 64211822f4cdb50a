"""The small radar and the plate that the tests of the chart share."""

SMALL = {"azimuths": 90, "beamwidth_deg": 12, "range_max_m": 1500, "pulse_s": 4e-6, "rpm": 60}
PLATE = {"name": "p", "shape": "plate", "width_m": 20, "height_m": 10, "position_m": [0, 800, 15], "heading_deg": 180,
         "material": "concrete", "scattering": "diffuse"}  # fmt: skip
