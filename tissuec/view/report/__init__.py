"""A page about one run, made from its result file alone.

``Story`` gathers what there is to tell, as values; each file of ``sections`` writes one part of
it; ``page`` puts them together. Whatever is text becomes HTML in ``markup``, which escapes it.
"""
