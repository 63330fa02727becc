"""Image and film files from arrays of pixels."""

import io
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.extras import required

Picture = UInt8[np.ndarray, "height width 3"]

_QUALITY = "20"  # of H.264: lower is better and larger


def check_path(path: Path, extension: str) -> None:
    """Raise UserError unless the file has that extension and can be written."""
    if path.suffix.lower() != extension:
        raise UserError(f"{path} does not end in {extension}")
    files.require_file(path)


def write_png(path: Path, picture: Picture) -> None:
    """Replace `path` with the picture."""
    with files.replacing_file(path) as file:
        Image.fromarray(picture).save(file, "PNG")


def gif_of_mp4(path: Path, *, every: int = 4, width: int = 160) -> tuple[bytes, int, int]:
    """A film as a GIF of every `every`-th frame, at its own pace, with height and width in pixels.

    Raises UserError if the package `av`, of the extra `render`, is not installed.
    """
    (av,) = required("av", extra="render")
    with av.open(path) as film:
        stream = film.streams.video[0]
        height = width * stream.height // stream.width
        pictures = [
            frame.to_image(width=width, height=height)
            for number, frame in enumerate(film.decode(stream))
            if number % every == 0
        ]
        milliseconds = 1000 * every / stream.average_rate
    content = io.BytesIO()
    first, *others = pictures
    first.save(content, "GIF", save_all=True, append_images=others, duration=float(milliseconds))
    return content.getvalue(), height, width


def write_mp4(path: Path, pictures: Iterable[Picture], *, rate: int) -> None:
    """Replace `path` with a film of `rate` pictures per second; height and width must be even.

    Raises UserError if the package `av`, of the extra `render`, is not installed.
    """
    (av,) = required("av", extra="render")
    content = io.BytesIO()  # PyAV does not report why it cannot write a file, as on a full disk
    with av.open(content, "w", format="mp4") as film:
        stream = film.add_stream("libx264", rate=rate, options={"crf": _QUALITY})
        stream.pix_fmt = "yuv420p"
        for number, picture in enumerate(pictures):
            if number == 0:
                stream.height, stream.width = picture.shape[:2]
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            film.mux(stream.encode(frame))
        film.mux(stream.encode())
    with files.replacing_file(path) as file:
        file.write(content.getbuffer())
