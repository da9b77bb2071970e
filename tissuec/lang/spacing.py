"""Rules for blanks between two tokens on a line."""

_OPENING = frozenset({"LPAR", "LSQB"})
_CLOSING = frozenset({"COMMA", "SEMICOLON", "COLON", "RPAR", "RSQB", "RPAR_UNIT"})
_SIGNS = frozenset({"PLUS", "MINUS"})

#: After one of these a sign joins two operands; elsewhere it belongs to the next one.
_OPERAND_ENDS = frozenset(
    {"WORD", "STRING", "NUMBER", "QUANTITY", "STEPS", "RPAR", "RPAR_UNIT", "RSQB"}
)


def blank_between(before: str, previous: str, following: str) -> bool:
    """Return whether a blank separates two neighbours.

    Args:
        before: Kind of the token before ``previous``; empty at the beginning.
        previous: Kind of the left neighbour.
        following: Kind of the right neighbour.
    """
    if previous in _OPENING or following in _CLOSING:
        return False
    if following == "LPAR" and previous in ("WORD", "STRING"):
        return False  # a call
    if "CIRCUMFLEX" in (previous, following):
        # Without a blank, "3 m ^ 2" would become the unit m^2.
        return (previous if following == "CIRCUMFLEX" else before) in ("QUANTITY", "RPAR_UNIT")
    return previous not in _SIGNS or before in _OPERAND_ENDS
