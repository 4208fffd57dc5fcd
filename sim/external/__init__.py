"""What users bring beside a scenario: meshes of objects, a scene of their own, and both packed into logs."""
