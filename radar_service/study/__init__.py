"""Studies of the simulator: speed against accuracy on a scene (`chart`), and where every method fails (`stability`)."""
