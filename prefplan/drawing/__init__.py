"""Pictures of plans as plain SVG, for notebooks."""
