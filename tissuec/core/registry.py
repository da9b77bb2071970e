"""Families: members are in the folder of the family, or plug-ins of another package."""

import pkgutil
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from importlib.util import find_spec
from threading import RLock
from typing import Any, Generic, TypeVar

from tissuec.core import plugins

T = TypeVar("T")
M = TypeVar("M")
# One for all families: while one is filled, its modules look up members of others.
_filling = RLock()


class Family(Mapping[str, T], Generic[T]):
    """A mapping from names to members, filled by importing the modules of a package.

    Modules whose names end in ``_kernel`` have no members; those that use them import them.
    Plug-ins of other packages add members, too; see ``core.plugins``. The thread that looks up
    a member first imports them all, or only the module that has its name; others wait until
    they are there.

    Args:
        package: The folder that holds the members, as a package name.
        kind: What one member is called in messages, such as "mesh".

    Raises:
        BrokenPlugIn: Whenever all members are needed and a plug-in cannot be imported.
    """

    def __init__(self, package: str, kind: str):
        self.package = package
        self.kind = kind
        self._members: dict[str, Any] = {}
        self._begun = self._complete = False

    def member(self, name: str) -> Callable[[M], M]:
        """Return a decorator that enters its argument under ``name``."""

        def enter(member: M) -> M:
            if name in self._members:
                raise ValueError(f"two members of {self.package} are called {name!r}")
            self._members[name] = member
            return member

        return enter

    def _own(self) -> dict[str, Any]:
        """Return the members, all of which are imported."""
        if not self._complete:
            with _filling:
                # Begun already: a module looks up members while it is imported.
                if not self._complete and not self._begun:
                    self._fill()
        return self._members

    def _fill(self) -> None:
        self._begun = True
        try:
            path, prefix = import_module(self.package).__path__, f"{self.package}."
            for module in pkgutil.walk_packages(path, prefix):
                if not module.name.endswith("_kernel"):
                    import_module(module.name)
            plugins.load(self.kind)
            self._complete = True
        finally:
            self._begun = False

    def __getitem__(self, name: str) -> T:
        if not self._complete and name.isidentifier() and not name.startswith("_"):
            with _filling:
                self._import(name)
        return self._members[name] if name in self._members else self._own()[name]

    def _import(self, name: str) -> None:
        """Import the module of a name, where there is one: others take time to import."""
        module = f"{self.package}.{name}"
        if name not in self._members and find_spec(module) is not None:
            import_module(module)

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._own()))

    def __len__(self) -> int:
        return len(self._own())
