"""Many quick cases in one test: what surrounds a test takes longer than each of them."""

import inspect
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any

import pytest


def every(
    names: str | tuple[str, ...],
    cases: Iterable[Any],
    ids: Callable[[Any], str] = str,
    parts: int = 1,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Call a test with every case, and tell all cases that fail.

    Cases share the fixtures of the test, so none may leave anything in them.

    Args:
        names: Of the parameters, as ``pytest.mark.parametrize`` takes them.
        cases: Values of the parameters: one, or as many as there are names.
        ids: How a value is told.
        parts: Number of tests that share the cases, if they take long together.
    """
    keys = (names,) if isinstance(names, str) else names
    rows = [(case,) if isinstance(names, str) else tuple(case) for case in cases]

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @wraps(test)
        def run(part: int, **fixtures: Any) -> None:
            failed: list[BaseException] = []
            for row in rows[part::parts]:
                try:
                    test(**dict(zip(keys, row, strict=True)), **fixtures)
                except pytest.skip.Exception:
                    continue
                except (Exception, pytest.fail.Exception) as error:
                    error.add_note(f"case: {'-'.join(map(ids, row))}")
                    failed.append(error)
            if failed:
                raise BaseExceptionGroup("cases fail", failed)

        given = inspect.signature(test)
        left = [one for name, one in given.parameters.items() if name not in keys]
        part = inspect.Parameter("part", inspect.Parameter.KEYWORD_ONLY)
        run.__signature__ = given.replace(parameters=[*left, part])  # pyright: ignore
        return pytest.mark.parametrize("part", range(parts))(run)

    return decorate
