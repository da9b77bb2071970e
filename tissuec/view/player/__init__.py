"""The player: a result as one HTML page that moves, or as pictures.

Shared arguments:
    painter: Draws moments of the run.
    path: The file.
    speed: Playback speed, 1 is real time; chosen automatically if None.
    told: Called with the progress.
    film: What is drawn of the result.
    trajectory: The result.
    options: Options of the player.
    pack: Takes the arrays.
    points: Points [m], shape (point, 3).
    azimuth, elevation: Direction of the eye from the target [deg].
    aspect: Width over height of the picture.
"""
