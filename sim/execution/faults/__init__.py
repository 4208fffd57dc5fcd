"""Faults to inject, written as `slip@2` or `move:pink@3`; each kind is a class in one file of this folder."""

import importlib
import pkgutil

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
