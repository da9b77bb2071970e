"""Suggestions for a file name that does not exist."""

from pathlib import Path

from tissuec.core.hints import Edit, Hint


def nearby(path: Path, suffix: str, beside: Path | None = None) -> Hint:
    """Return a hint ``did you mean "…"?`` for the nearest file of its folder, or nothing.

    Args:
        path: What was written, perhaps without its suffix.
        suffix: Of the files that can be meant, such as ".tis".
        beside: Folder that is left out of the name that is proposed.
    """
    from difflib import get_close_matches  # late: most names are those of files

    try:
        names = [place.name for place in path.parent.glob(f"*{suffix}")]
    except OSError:
        return Hint("")
    whole = f"{path.name.removesuffix(suffix)}{suffix}"
    near = get_close_matches(whole, names, n=1, cutoff=0.8)
    if not near or not path.name:
        return Hint("")
    old, new = str(path), str(path.with_name(near[0]))
    if beside is not None:
        old, new = (name.replace(f"{beside}/", "") for name in (old, new))
    return Hint(f'did you mean "{new}"?', Edit(new, old=old))
