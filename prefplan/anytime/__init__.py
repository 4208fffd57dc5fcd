"""Anytime search: some plan or front soon, better ones while there is time, and how far they are from the best."""
