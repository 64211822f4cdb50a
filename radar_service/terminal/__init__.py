"""What commands share at a terminal: arguments, output files, progress, extras that are absent."""
