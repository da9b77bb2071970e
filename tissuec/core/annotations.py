"""Annotations of members of families, from which the language follows, and what is wrong there.

A member can come from another package, whose author needs its file, line and annotation.
"""

import sys
from typing import Any, ForwardRef, NoReturn, get_args, get_origin, get_type_hints

from tissuec.core.errors import TissueError


class WrongAnnotation(TissueError, TypeError):
    """A field of a member does not say how it is written; the message names file and line."""


def hints_of(member: type) -> dict[str, Any]:
    """Return the annotations of the fields of a member, with what they say beside types.

    Raises:
        WrongAnnotation: One of them cannot be evaluated.
    """
    hints = dict[str, Any]()
    for base in reversed(member.__mro__):
        hints |= getattr(base, "__annotations__", {})
    if not any(map(_is_text, hints.values())):  # nothing has to be evaluated, which takes long
        return hints
    try:
        return get_type_hints(member, include_extras=True)
    except Exception as error:  # whatever an annotation of another package does
        name = getattr(error, "name", None)
        field = next((one for one, hint in _own(member) if name and name in str(hint)), "")
        refuse(member, field, f"cannot be evaluated: {type(error).__name__}: {error}")


def refuse(member: type, field: str, reason: str) -> NoReturn:
    """Reject the annotation of a field.

    Args:
        member: The class.
        field: The field; empty if it is not known which.
        reason: What is wrong, after "the annotation of …".

    Raises:
        WrongAnnotation: Always.
    """
    of = f'"{field}" in {member.__name__}' if field else f"a field of {member.__name__}"
    raise WrongAnnotation(f"{_place(member, field)}: the annotation of {of} {reason}")


def refuse_field(member: type, field: str, hint: Any, says: str, examples: str) -> NoReturn:
    """Reject a field that does not say how it is written.

    Args:
        member: The class.
        hint: Its annotation.
        says: What annotations have to say, and where that is defined.
        examples: How the field could be written.

    Raises:
        WrongAnnotation: Always.
    """
    way = f"for example: {examples}"
    if _is_around(hint):
        way = f"put None inside: {field}: Annotated[float | None, …]"
    refuse(member, field, f"does not say {says}; {way}")


def _is_around(hint: Any) -> bool:
    """Return whether an annotation has None outside, as ``Annotated[…] | None``."""
    parts = get_args(hint) if get_origin(hint) is not None else ()
    return type(None) in parts and any(hasattr(one, "__metadata__") for one in parts)


def _is_text(hint: Any) -> bool:
    """Return whether an annotation, or the type in it, is written as a text."""
    return isinstance(getattr(hint, "__origin__", hint), str | ForwardRef)


def _own(member: type) -> list[tuple[str, Any]]:
    return list(vars(member).get("__annotations__", {}).items())


def _place(member: type, field: str) -> str:
    """Return the file and the line of a field, as far as they are known."""
    import inspect  # late: only for members that are wrong

    home = next((one for one in member.__mro__ if field in dict(_own(one))), member)
    file = getattr(sys.modules.get(home.__module__), "__file__", None) or home.__module__
    try:
        lines, first = inspect.getsourcelines(home)
    except (OSError, TypeError):
        return str(file)
    starts = (n for n, line in enumerate(lines) if line.lstrip().startswith(f"{field}:"))
    return f"{file}:{first + next(starts, 0)}"
