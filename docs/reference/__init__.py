"""The tables of the reference pages, made from the tables that the compiler itself reads.

A page holds marked places, ``<!-- generated: verbs -->`` to ``<!-- end of verbs -->``; whatever
stands between the two marks is replaced. ``python -m docs.reference`` does so for every page
of ``docs/``; with ``--check`` it only says which pages are out of date.
"""
