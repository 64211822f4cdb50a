"""Speed against accuracy: every method of the engine on one scene, one point for each setting.

`chart` measures and writes. It has up to three panels of points: `field_panel` (the signal chain), `power_panel` (samplers of
diffuse surfaces) and `scattering_panel` (scattering models).
`figure` draws them, `summary` puts them into words. The references are independent of the engine: `closed_form` (compressed
pulse), `reference_surface` (mean power of a surface), `scattering_panel` (cross-sections of theory).
"""
