"""Faults to inject, written as `slip@2` or `move:pink@3`; each kind is a class in one file of this folder."""
