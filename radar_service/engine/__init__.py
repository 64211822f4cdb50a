"""The engine: preparation, the pipeline, several pulses, and the specification as printed."""
