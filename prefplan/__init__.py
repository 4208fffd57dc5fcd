"""Optimal cost-preference trade-off planning with multiple temporal tasks.

After P. Amorese and M. Lahijanian, "Optimal Cost-Preference Trade-off Planning with Multiple Temporal Tasks",
IROS 2023.

The package's public names are those that `prefplan.api` imports. They are loaded at their first use: pytest loads this
package wherever it is installed, for `prefplan.pytest_plugin`, and other tests should not wait for the planner.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from prefplan.api import *  # noqa: F403

    __version__: str
else:

    def __getattr__(name):
        """Return a public name, loading all of them at the first use, or the version."""
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
        """Return all names, including the public ones that are not loaded yet."""
        import prefplan

        return sorted({*globals(), *prefplan.__all__, "__version__"})
