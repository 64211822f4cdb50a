"""Scene files: their model (one file a table), readers of meshes, height maps and tracks, checks, and what they become."""
