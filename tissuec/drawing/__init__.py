"""What every picture is made of: pages, axes with units, named curves, nets, words.

Nothing here imports matplotlib before something is drawn.
"""
