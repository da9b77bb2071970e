"""Measured data: tables as text, results of runs, and H5MD files become series of numbers.

Shared arguments:
    axis: Column of times or displacements.
    fit: What is compared with data.
    fits: All that is compared with data of one file.
    network: The network.
    complaints: Takes errors in the data.
    dialect: Separators of the table and where its rows begin.
    text: The text of the table.
"""
