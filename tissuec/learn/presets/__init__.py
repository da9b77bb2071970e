"""Learnt results as text of the language: presets, vocabularies, tables.

Shared arguments:
    learnt: Result of the learning.
    compiled: The compiled scene.
    request: What the scene was compiled from.
    network: The network.
    target: The file of the preset.
    text: Text of the preset.
    drafts: Tissues of the preset.
    word: Name of the entry.
    law: The law as written.
    learned: Learnt constants by name.
    value, low, high: A number and its interval, in SI units.
    dimension: Its dimension.
    percent: Whether it is written in percent.
    mark: First comment of written files.
    scene, fit_problem: Names of the scene and of the ``learn`` block.
    seed: Seed of the learning.
"""
