"""Optimal cost-preference trade-off planning with multiple temporal tasks.

After P. Amorese and M. Lahijanian, "Optimal Cost-Preference Trade-off Planning with Multiple Temporal Tasks",
IROS 2023.

What the package offers is what `prefplan.api` imports. It is loaded when it is first used: pytest loads this package
wherever it is installed, for the sake of `prefplan.pytest_plugin`, and nobody else's tests should wait for the planner.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from prefplan.api import *  # noqa: F403

    __version__: str
else:

    def __getattr__(name):
        """Load what the package offers, or its version."""
        from importlib import import_module, metadata

        if name == "__version__":
            try:
                return metadata.version("prefplan")
            except metadata.PackageNotFoundError:
                return "unknown"
        if not name.startswith("__") or name == "__all__":
            offered = {name: found for name, found in vars(import_module("prefplan.api")).items() if name[0].isalpha()}
            globals().update(offered, __all__=sorted(offered))
        try:
            return globals()[name]
        except KeyError:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None

    def __dir__():
        """Name what the package offers, too."""
        import prefplan

        return sorted({*globals(), *prefplan.__all__, "__version__"})
