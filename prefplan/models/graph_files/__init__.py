"""Graphs from files: GraphML as written by OSMnx, CSV, node-link JSON and the DIMACS format."""
