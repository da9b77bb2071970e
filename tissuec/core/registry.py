"""Families: a member is a file in the folder of the family, or a plug-in of another package."""

import pkgutil
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from typing import Any, Generic, TypeVar

from tissuec.core import plugins

T = TypeVar("T")
M = TypeVar("M")


class Family(Mapping[str, T], Generic[T]):
    """A mapping from names to members, filled by importing the modules of a package.

    Plug-ins of other packages add members, too; see ``core.plugins``.

    Args:
        package: The folder that holds the members, as a package name.
        kind: What one member is called in messages, such as "mesh".

    Raises:
        BrokenPlugIn: On every use, if a plug-in cannot be imported.
    """

    def __init__(self, package: str, kind: str):
        self.package = package
        self.kind = kind
        self._members: dict[str, Any] = {}
        self._complete = False

    def member(self, name: str) -> Callable[[M], M]:
        """Return a decorator that enters its argument under ``name``."""

        def enter(member: M) -> M:
            if name in self._members:
                raise ValueError(f"two members of {self.package} are called {name!r}")
            self._members[name] = member
            return member

        return enter

    def _complete_members(self) -> dict[str, Any]:
        if not self._complete:
            self._complete = True  # for modules that look up members while they are imported
            try:
                for module in pkgutil.iter_modules(import_module(self.package).__path__):
                    import_module(f"{self.package}.{module.name}")
                plugins.load(self.kind)
            except BaseException:
                self._complete = False
                raise
        return self._members

    def __getitem__(self, name: str) -> T:
        return self._complete_members()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._complete_members()))

    def __len__(self) -> int:
        return len(self._complete_members())
