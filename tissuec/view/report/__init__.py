"""A page about one run, made from its result file alone.

``ReportContent`` collects the content as values; ``head`` and functions that return a
``Section`` write the parts of the page; ``page`` combines them. ``markup`` turns text into HTML
and escapes it.
"""
