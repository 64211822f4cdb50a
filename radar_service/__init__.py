"""A simulated marine radar: triangle meshes in, the live feed of a rotating X-band radar out."""
