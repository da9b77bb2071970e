"""tissuec: words for tissue into physics, and physics into motion that can be trusted."""

__version__ = "0.1.0"
