"""Learning of words: scales whose words move, and rules that are revised.

Shared arguments:
    theta: Parameters of words, dimensionless, shape (number,).
    scene: The scene.
"""
