"""Speed against accuracy: every method of the engine on one scene, one point for each setting.

`chart` measures and writes. It has up to three panels of points: `field_panel` (the signal chain), `power_panel` (samplers of
diffuse surfaces) and `scattering_panel` (scattering models).
`figure` draws them, and puts them into words. The references are independent of the engine: `reference_surface` (compressed
pulse, mean power of a surface), `scattering_panel` (cross-sections of theory).
"""
