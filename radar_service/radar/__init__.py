"""The radar: parameters, antenna patterns, waveform."""
