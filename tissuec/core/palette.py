"""Colours that every picture shares: pages, plots and animations.

They can be distinguished with any colour vision: neighbours differ in lightness, and nothing is
said by colour alone. The colours of series are those of M. Okabe and K. Ito, "Color universal
design" (2008), without the yellow, which paper swallows.
"""

#: From the strongest pressure over nothing to the strongest tension.
TENSION = ("#08457e", "#4a90c4", "#a3a3a3", "#d9822b", "#8f2d04")
#: From little to much.
AMOUNT = ("#00224e", "#434e6c", "#7d7c78", "#bcaf6f", "#fee838")
#: Of curves, one after the other.
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#6b6b6b")
#: Of a tissue's skin, and of its inside.
SKIN, LUMEN = "#eaa08f", "#9c3a3d"
#: Of tools, threads, and fluids in jets.
STEEL, SILK, WATER = "#7f8c99", "#5d4a7e", "#7fb6dc"
#: Letters, lines of a grid, and what is behind them, on paper and in the dark.
INK, GRID, PAPER = "#222222", "#dddddd", "#ffffff"
INK_DARK, GRID_DARK, PAPER_DARK = "#e8e8e8", "#3a3d42", "#16181c"
