"""MJCF, materials, and the library that shows reports in 3-D."""
