"""Which file was meant by a name that no file has."""

from pathlib import Path


def nearby(path: Path, suffix: str) -> str:
    """Return a hint ``did you mean "…"?`` for the nearest file of its folder, or nothing.

    Args:
        path: What was written, perhaps without its suffix.
        suffix: Of the files that can be meant, such as ".tis".
    """
    from difflib import get_close_matches  # late: most names are those of files

    try:
        names = [place.name for place in path.parent.glob(f"*{suffix}")]
    except OSError:
        return ""
    whole = f"{path.name.removesuffix(suffix)}{suffix}"
    near = get_close_matches(whole, names, n=1, cutoff=0.8)
    return f'did you mean "{path.with_name(near[0])}"?' if near and path.name else ""
