"""From antenna to target: radar equation, multipath, diffraction, sea surface, attenuation."""
