"""Parts of the simulator: the engine of a scene, tiles in several processes, the power of sources."""
