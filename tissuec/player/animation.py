"""A run as an animated picture or a video, drawn without a browser."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.network import Floats
from tissuec.player.pace import pace
from tissuec.player.picture import Painter

GIF_RATE, VIDEO_RATE = 20, 30  # pictures in a second
_COLOURS, _SAMPLES = 192, 6  # of the palette of a GIF; pictures that it is made for
_REST = 0.6  # [s] for which the end stays
Progress = Callable[[int, int], None]


def moments(times: Floats, rate: float, speed: float | None) -> Floats:
    """Return which moments of a film are drawn, in frames, for so many pictures in a second.

    Args:
        times: Of the frames [s], shape (frame,).
        speed: Playback speed, 1 is real time; chosen automatically if None.
    """
    duration = float(times[-1] - times[0])
    shown = duration / (speed or pace(duration))
    count = max(2, round(shown * rate) + 1) if duration > 0.0 else 1
    at = np.linspace(times[0], times[-1], count)
    return np.interp(at, times, np.arange(len(times)))


def rate_of(painter: Painter, usual: float, speed: float | None) -> float:
    """Return how many pictures a second shows: fewer than usual if few frames are asked for."""
    times, most = painter.film.times, painter.options.frames
    duration = float(times[-1] - times[0])
    if most is None or not duration > 0.0:
        return usual
    return min(usual, (most - 1) * (speed or pace(duration)) / duration)


def write_gif(painter: Painter, path: Path, speed: float | None, told: Progress) -> int:
    """Write an animated GIF, and return how many pictures it has."""
    from PIL import Image

    rate = rate_of(painter, GIF_RATE, speed)
    chosen = moments(painter.film.times, rate, speed)
    # One palette serves all, so that nothing flickers; it knows the colours of all times.
    few = chosen[np.unique(np.linspace(0, len(chosen) - 1, _SAMPLES).astype(int))]
    together = np.concatenate([painter.pixels(float(at)) for at in few])
    palette = Image.fromarray(together).quantize(_COLOURS, kmeans=1)
    pictures = []
    for number, at in enumerate(chosen):
        told(number, len(chosen))
        picture = Image.fromarray(painter.pixels(float(at)))
        pictures.append(picture.quantize(palette=palette, dither=Image.Dither.NONE))
    pause = [round(1000 / rate)] * len(pictures)
    pause[-1] += round(1000 * _REST)
    pictures[0].save(
        path, format="GIF", save_all=True, append_images=pictures[1:], duration=pause, loop=0
    )
    return len(pictures)


def need_ffmpeg() -> None:
    """Raise a TissueError that says what to install, where there is no encoder of videos."""
    try:
        import imageio_ffmpeg  # noqa: F401
    except ImportError as error:
        raise TissueError(
            'a video needs imageio-ffmpeg; pip install "tissuec[animate]" brings it'
        ) from error


def write_video(painter: Painter, path: Path, speed: float | None, told: Progress) -> int:
    """Write an MP4 (H.264), and return how many pictures it has."""
    import imageio_ffmpeg

    rate = rate_of(painter, VIDEO_RATE, speed)
    chosen = moments(painter.film.times, rate, speed)
    width, height = painter.size
    even = width // 2 * 2, height // 2 * 2  # as the codec wants it
    encoder = imageio_ffmpeg.write_frames(
        str(path), even, fps=rate, codec="libx264", quality=8, macro_block_size=2,
        pix_fmt_in="rgb24", output_params=["-movflags", "+faststart"],
    )  # fmt: skip
    encoder.send(None)
    try:
        picture: NDArray[np.uint8] | None = None
        for number, at in enumerate(chosen):
            told(number, len(chosen))
            picture = painter.pixels(float(at))[: even[1], : even[0]]
            encoder.send(np.ascontiguousarray(picture))
        assert picture is not None
        for _ in range(round(rate * _REST)):
            encoder.send(np.ascontiguousarray(picture))
    finally:
        encoder.close()
    return len(chosen) + round(rate * _REST)
