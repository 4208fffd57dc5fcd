"""Preference functions over task costs (Definition 5), and what a search may assume of them."""
