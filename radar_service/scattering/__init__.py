"""Scattering models: fixed scatterers, sampled rays, physical optics of metal, Swerling fluctuation."""
