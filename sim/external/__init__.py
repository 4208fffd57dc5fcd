"""Files that a user provides with a scenario: meshes of objects, an MJCF scene, and both packed into logs."""
