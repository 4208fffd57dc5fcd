"""A plan carried out many times."""
