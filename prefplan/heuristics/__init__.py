"""Lower bounds of the cost-to-go (equation 4) and of the preference's growth, tabulated before a search."""
