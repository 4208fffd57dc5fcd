"""Sentinel values that the kernels share."""

from __future__ import annotations

from prefplan.models.kernels import Integer, bare_kernel, kernel

__all__ = ["INFINITE", "NO_EDGE", "UNBOUNDED", "UNREACHABLE", "Integer", "bare_kernel", "kernel"]

INFINITE = 2**60
"""Cost-to-go where there is no path. A search that meets a cost this large starts again with Python's integers."""

NO_EDGE = 2**61
"""Cost of an edge that does not exist; larger than any finite cost-to-go plus the cost of an edge."""

UNREACHABLE = 2**31 - 1
"""Stands for INFINITE in tables, whose entries have 32 bits: with 64 a front of eight tasks takes a tenth longer."""

UNBOUNDED = 2**62
"""A bound that no cost or mu reaches: a label's value plus what one step adds is less than 2^61."""
