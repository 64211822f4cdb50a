"""Plots: thresholds and CFAR, clusters, sidelobes, and of which source each plot is."""
