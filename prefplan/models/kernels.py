"""Kernels: numba functions, compiled once and cached on disk, and the sentinel values that they share."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import numba
import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

Integer: TypeAlias = "int | np.integer[Any]"

COMPILED: bool = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]
"""Whether kernels are compiled: `NUMBA_DISABLE_JIT=1` runs them in Python, for a debugger."""

if not COMPILED:
    np.seterr(over="ignore")  # machine code wraps round silently, and hashes rely on it

INFINITE = 2**60
"""Cost-to-go where there is no path. A search that meets a cost this large starts again with Python's integers."""

NO_EDGE = 2**61
"""Cost of an edge that does not exist; larger than any finite cost-to-go plus the cost of an edge."""

UNREACHABLE = 2**29
"""Stands for INFINITE in tables, whose entries have 32 bits: with 64 a front of eight tasks takes a tenth longer. Sums
of three of them fit."""

UNBOUNDED = 2**62
"""A bound that no cost or mu reaches: a label's value plus what one step adds is less than 2^61."""


def kernel(function: F) -> F:
    """Compile a function that may allocate arrays."""
    return _compiled(function)


def bare_kernel(function: F) -> F:
    """Compile a function that allocates no arrays, without reference counting, and inline it into its callers.

    Small functions take half the time without reference counts, and inlining, which avoids passing tuples of arrays,
    saves another third.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _compiled(function: F, **options: Any) -> F:
    # C code calls none of them.
    options |= {"no_cfunc_wrapper": True}
    dispatcher = numba.njit(cache=True, nogil=True, **options)(function)
    if not COMPILED:
        return function
    forget_outdated(Path(dispatcher.stats.cache_path))
    return cast(F, dispatcher)


KERNEL_SOURCES = (
    "models/kernels.py",
    "models/manipulation/slots.py",
    "models/manipulation/successors.py",
    "product/*.py",
    "heuristics/*.py",
    "search/**/*.py",
)
"""Files of `prefplan` that hold all kernels and the constants that these use."""


@cache
def _digest_of_sources() -> str:
    digest = hashlib.sha256()
    root = Path(__file__).parents[1]
    for source in sorted(source for pattern in KERNEL_SOURCES for source in root.glob(pattern)):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def forget_outdated(folder: Path) -> None:
    """Remove machine code of outdated sources: numba checks a function's own file only, not those of its callees."""
    stamp = folder / "sources.sha256"
    if not stamp.exists() or stamp.read_text() != _digest_of_sources():
        folder.mkdir(parents=True, exist_ok=True)
        for index in folder.glob("*.nbi"):
            index.unlink(missing_ok=True)
        temporary = folder / f"{stamp.name}.{os.getpid()}"
        temporary.write_text(_digest_of_sources())
        temporary.rename(stamp)
