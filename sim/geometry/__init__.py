"""Plain geometry: rectangles on the table, and solids with rounded edges."""
