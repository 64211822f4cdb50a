"""What a display shows: video, scan conversion, pictures, films."""
