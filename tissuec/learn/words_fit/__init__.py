"""The fit of a vocabulary to numbers of tissues: model, optimiser and outcome.

Shared arguments:
    theta: Parameters: those of words, then logarithms of changes of weights,
        dimensionless, shape (number,).
    words: The program with the block, as far as it needs no bodies.
    fit: The ``learn`` block.
    learnt: The finished fit.
"""
