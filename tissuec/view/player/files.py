"""A run as a still picture, an animated picture or a video, drawn without a browser."""

import shutil
import struct
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from tempfile import TemporaryFile
from zlib import compress, crc32

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.core.files import replacing
from tissuec.model.network import Floats
from tissuec.view.player.facts import pace
from tissuec.view.player.film import PlayerData
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter

GIF_RATE, VIDEO_RATE = 20, 30  # pictures in a second
_COLOURS, _SAMPLES = 192, 6  # of the palette of a GIF; pictures that it is made for
_REST = 0.6  # [s] for which the end stays
Progress = Callable[[int, int], None]


def moments(times: Floats, rate: float, speed: float | None) -> Floats:
    """Return the moments of a film to be drawn, counted in frames, shape (picture,).

    Args:
        times: Of the frames [s], shape (frame,).
        rate: Pictures per second.
    """
    duration = float(times[-1] - times[0])
    shown = duration / (speed or pace(duration))
    count = max(2, round(shown * rate) + 1) if duration > 0.0 else 1
    at = np.linspace(float(times[0]), float(times[-1]), count)
    return np.interp(at, times, np.arange(len(times)))


def rate_of(painter: Painter, usual: float, speed: float | None, still: float = 0.0) -> float:
    """Return the number of pictures per second: fewer than usual if few frames are requested.

    Args:
        usual: Pictures per second otherwise.
        speed: Playback speed.
        still: How long pictures of the end are repeated [s].
    """
    times, most = painter.film.times, painter.options.frames
    duration = float(times[-1] - times[0])
    if most is None or not duration > 0.0:
        return usual
    return min(usual, (most - 1) / (duration / (speed or pace(duration)) + still))


def write_gif(painter: Painter, path: Path, speed: float | None, told: Progress) -> int:
    """Write an animated GIF, and return how many pictures it has."""
    from PIL import Image

    rate = rate_of(painter, GIF_RATE, speed)
    chosen = moments(painter.film.times, rate, speed)
    # One palette serves all, so that nothing flickers; it knows the colours of all times.
    few = chosen[np.unique(np.linspace(0, len(chosen) - 1, _SAMPLES).astype(int))]
    drawn = {float(at): painter.pixels(float(at)) for at in few}
    together = np.concatenate(list(drawn.values()))
    palette = Image.fromarray(together).quantize(_COLOURS, kmeans=1)
    pictures: list[Image.Image] = []
    for number, at in enumerate(chosen):
        told(number, len(chosen))
        own = drawn.pop(float(at), None)
        picture = Image.fromarray(painter.pixels(float(at)) if own is None else own)
        pictures.append(picture.quantize(palette=palette, dither=Image.Dither.NONE))
    pause = [round(1000 / rate)] * len(pictures)
    pause[-1] += round(1000 * _REST)
    with replacing(path) as beside:
        pictures[0].save(
            beside, format="GIF", save_all=True, append_images=pictures[1:], duration=pause,
            loop=0,
        )  # fmt: skip
    return len(pictures)


def need_ffmpeg() -> str:
    """Return the encoder of videos: that of the extra, or one that is installed.

    Raises:
        TissueError: There is none; says what to install.
    """
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingTypeStubs]
    except ImportError as error:
        if found := shutil.which("ffmpeg"):
            return found
        raise TissueError(
            'a video needs ffmpeg; install it separately or by pip install "tissuec[animate]"'
        ) from error
    return str(imageio_ffmpeg.get_ffmpeg_exe())


def write_video(painter: Painter, path: Path, speed: float | None, told: Progress) -> int:
    """Write an MP4 (H.264), and return how many pictures it has.

    Raises:
        TissueError: There is no encoder, or it failed; says why.
        OSError: The file cannot be written.
    """
    rate = rate_of(painter, VIDEO_RATE, speed, _REST)
    chosen = moments(painter.film.times, rate, speed)
    rest = round(rate * _REST)
    if painter.options.frames is not None:
        rest = min(rest, painter.options.frames - len(chosen))
    width, height = (length // 2 * 2 for length in painter.size)  # as the codec wants it
    command = [
        need_ffmpeg(), "-y", "-loglevel", "error",
        "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{rate:g}",
        "-i", "-", "-an", "-c:v", "libx264", "-crf", "10", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart",
    ]  # fmt: skip
    pictures = _pictures(painter, chosen, (width, height), rest, told)
    with replacing(path) as beside, TemporaryFile() as said:
        command.append(str(beside.absolute()))
        with Popen(command, stdin=PIPE, stdout=DEVNULL, stderr=said) as encoder:
            assert encoder.stdin is not None
            with suppress(BrokenPipeError):  # it says why below
                for picture in pictures:
                    encoder.stdin.write(picture)
                encoder.stdin.close()
        if encoder.returncode:
            said.seek(0)
            reason = said.read().decode(errors="replace").strip()
            raise TissueError(f'cannot write "{path}": {reason}')
    return len(chosen) + rest


def _pictures(
    painter: Painter, chosen: Floats, size: tuple[int, int], rest: int, told: Progress
) -> Iterator[bytes]:
    """Yield the pixels of moments, and those of the last one again while it stays."""
    last = b""
    for number, at in enumerate(chosen):
        told(number, len(chosen))
        last = np.ascontiguousarray(painter.pixels(float(at))[: size[1], : size[0]]).tobytes()
        yield last
    yield from (last for _ in range(rest))


LARGEST = 30_000  # bytes, 40 kB in a page
_SIZES = ((640, 400), (480, 300), (320, 200))  # [px]


def still(film: PlayerData, options: Options, field: FieldValues | None = None) -> str:
    """Return the initial moment of a film as the address of a picture that contains it.

    Args:
        film: What there is.
        field: What colours the skin; its tissues if None.
    """
    time = film.times[0] if options.time is None else options.time
    at = film.moment_at(time)
    data = b""
    for size in _SIZES:
        data = png(Painter(film, options, size, "", field=field).scene(at))
        if len(data) <= LARGEST:
            break
    return f"data:image/png;base64,{b64encode(data).decode()}"


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Return a picture as a PNG file.

    Pages do not need the packages that plots need, Pillow among them. Each byte is stored as
    the difference to the pixel on its left, filter 1 of PNG (ISO/IEC 15948), which suits
    shaded surfaces.

    Args:
        pixels: Red, green, blue from the top left, shape (height, width, 3).
    """
    height, width, _ = pixels.shape
    change = pixels.copy()
    change[:, 1:] -= pixels[:, :-1]
    lines = np.ones((height, 1 + 3 * width), dtype=np.uint8)
    lines[:, 1:] = change.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", compress(lines.tobytes(), 9)), (b"IEND", b""))
    parts = (
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", crc32(name + data))
        for name, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
