"""Speed against accuracy: every method of the engine on one scene, one point for each setting.

`chart` measures up to three panels (`field_panel`: the signal chain, `power_panel`: samplers of diffuse surfaces,
`scattering_panel`: scattering models) against references of their own. `figure` draws them, and puts them into words.
"""
