"""Readers of scene files, meshes, height maps and tracks, which may come from untrusted users."""
