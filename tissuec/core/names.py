"""Normal form of names, for comparison."""

from functools import lru_cache

#: Other words for what the language has a name for.
SYNONYMS = {"fraction force": "breaking force", "mobility": "shiftability"}


@lru_cache(maxsize=16_384)
def key_of(text: str) -> str:
    """Return the form under which names are compared.

    That is small letters, single blanks, and no synonym.
    """
    key = " ".join(text.lower().split())
    return SYNONYMS.get(key, key)
