"""Parts of the simulator: the engine set up for a scene, the stream of spokes with commands and errors, the power of sources."""
