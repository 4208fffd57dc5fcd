"""The world of a manipulation model: layout, furniture, objects and how they look."""
