"""Graphs from files: GraphML as OSMnx writes it, CSV, node-link JSON and the DIMACS format."""
