"""How to cite tissuec and the work that it implements; CITATION.cff states the same."""

from tissuec.core.version import __version__

SOFTWARE = (
    f"The tissuec authors: tissuec {__version__}, a tissue-description language, its compiler, "
    "and a validated soft-tissue simulator."
)
PAPER = (
    "A. Nürnberger, A. Radetzky, R. Kruse: The Simulation of Elastic Tissues in Virtual "
    "Medicine Using Neuro-Fuzzy Systems. SPIE Medical Imaging 1998."
)
