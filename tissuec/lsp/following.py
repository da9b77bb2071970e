"""Reserved words that can follow in a statement, by its block and first word."""

FOLLOWING: dict[tuple[str, str], tuple[str, ...]] = {
    ("", "set"): ("of", "where", "in"),
    ("", "tissue"): ("like",),
    ("", "property"): ("from", "to"),
    ("", "quantity"): ("from", "to", "on"),
    ("", "param"): ("between", "and"),
    ("", "table"): ("of", "in", "with"),
    ("", "expect"): (
        "at", "from", "to", "until", "over", "between", "and", "or", "not", "along", "of",
    ),
    ("tissue", ""): ("is", "in", "of", "between", "and", "per", "from", "to", "by"),
    ("law", ""): ("is", "of", "and"),
    ("body", ""): ("is", "where"),
    ("region", ""): ("is",),
    ("mesh", ""): ("is", "from", "to", "in"),
    ("joint", ""): ("is", "from", "to"),
    ("tool", ""): ("is",),
    ("force", ""): ("is", "on"),
    ("environment", ""): ("is",),
    ("simulate", ""): ("is",),
    ("integrator", ""): ("is",),
    ("surface", ""): ("is",),
    ("output", ""): ("is", "of", "to", "every"),
    ("rules", ""): ("is",),
    ("quantity", ""): ("to", "is", "from", "until", "of"),
    ("property", ""): ("from", "to", "until"),
    ("learn", ""): (
        "using", "in", "every", "to", "weighing", "with", "along", "of", "from", "around", "by",
        "per", "is",
    ),
    ("script", ""): ("to", "every", "and", "or", "not", "between", "along"),
}  # fmt: skip
