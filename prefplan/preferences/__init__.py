"""Preference functions over task costs (Definition 5), and the contracts that a search relies on."""
