"""Parts of the simulator: the engine of a scene, the stream of spokes with commands and errors, the power of sources."""
