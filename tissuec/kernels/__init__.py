"""Arithmetic on bare arrays and SI numbers: the floor that both tiers stand on.

``vector`` holds each operation as a few NumPy calls, ``scalar`` the same operation as a plain
loop, which ``building`` translates. Stepping code is written once against these names;
``binding`` decides which of the two it meets.
"""
