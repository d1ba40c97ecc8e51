"""Decodes a user's picture, in a process of its own (`readers`): `python -m povgen.inputs.picture_reader`.

The answer is the file for renderers, its name, its size and its mean colour.

What a file states about its colours is applied, or the file is refused: no colour is shown as another.
"""

import hashlib
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
from PIL import Image, ImageCms, ImageOps

from povgen import remedies
from povgen.errors import shown
from povgen.inputs import hdr, readers

FORMATS = ("PNG", "JPEG", "WEBP", "TIFF")
MAX_SIZE = (8192, 4096)  # pixels
MAX_MEMORY = 3 << 30  # bytes of address space
MAX_TIME = 30  # seconds of CPU time
EXR = b"v/1\x01"
BAND = 256  # rows of a picture that are converted at once
SRGB_GAMMA = 0.45, 0.46  # of a PNG file: means sRGB
CICP_SRGB = bytes((1, 13, 0, 1))  # the numbers of sRGB in a PNG file's chunk cICP
ADOBE_RGB = 256 / 563, (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329)  # gamma and chromaticities
TIFF_BITS, TIFF_MEANING, TIFF_SIGNS, TIFF_WHITE, TIFF_PRIMARIES = 258, 262, 339, 318, 319  # tags of TIFF
WHITE_IS_0 = 0  # for TIFF_MEANING
EXIF_INTEROPERABILITY = 0xA005


def main() -> None:
    """Decode a picture."""
    readers.serve(decoded, MAX_MEMORY, MAX_TIME)


def decoded(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the answer. Raises ValueError with the fault of the user's file."""
    with readers.faults(f"picture: {', '.join(FORMATS)}; for the sky also HDR and EXR"):
        if data.startswith((hdr.MARK, EXR)):
            light = hdr.read(data) if data.startswith(hdr.MARK) else _exr_of(data)
            check_size(light.shape[1], light.shape[0])
            file = hdr.written(light)
            light = hdr.read(file)
            mean = light.mean((0, 1), float).tolist()
            return {"name": _name(file, "hdr"), "size": light.shape[1::-1], "mean": mean}, file
        image = colours(data)
        levels, count = hdr.linear(range(256)), image.width * image.height
        mean = [float(levels @ image.histogram()[k : k + 256]) / count for k in (0, 256, 512)]
        png = BytesIO()
        image.save(png, "png", compress_level=3)
        name = _name(image.tobytes() + repr(image.size).encode(), "png")
        return {"name": name, "size": image.size, "mean": mean}, png.getvalue()


def _name(content: bytes, ending: str) -> str:
    return f"picture-{hashlib.sha256(content).hexdigest()}.{ending}"


def check_size(width: int, height: int) -> None:
    """Raise ValueError for a picture that has too few or too many pixels."""
    if min(width, height) < 2 or width > MAX_SIZE[0] or height > MAX_SIZE[1]:
        raise ValueError("should be a picture of 2x2 to {}x{} pixels, not {}x{}".format(*MAX_SIZE, width, height))


def colours(data: bytes) -> Image.Image:
    """Return a picture of colours, upright and in sRGB."""
    with Image.open(BytesIO(data), formats=FORMATS) as image:
        check_size(max(image.size), min(image.size))  # before Exif data turn it
        _check_opaque(image, data)
        gamma, chromaticities = _stated(image, data)
        profile = image.info.get("icc_profile")
        try:
            upright = ImageOps.exif_transpose(image)
        except Exception:  # of any kind, for damaged Exif data
            upright = image.copy()
        tags = getattr(image, "tag_v2", {})
    check_size(*upright.size)
    if upright.mode.startswith("I;16") or (upright.mode, image.format) == ("I", "PNG"):
        # 16 bits, or 12: convert("L") would cut the numbers at 255
        white = 2 ** tags.get(TIFF_BITS, (16,))[0] - 1
        first, last = (255, 0) if tags.get(TIFF_MEANING) == WHITE_IS_0 else (0, 255)
        upright = upright.convert("I").point(lambda grey: grey * ((last - first) / white) + (first + 0.5)).convert("L")
    elif upright.mode in ("I", "F") or 2 in tags.get(TIFF_SIGNS, ()):  # 2: signed
        raise ValueError("should be a picture of 8 or 16 bits without sign; for light: .hdr or .exr")
    if profile or upright.mode == "LAB":
        return _by_profile(upright, profile)
    return _by_numbers(upright.convert("RGB"), gamma, chromaticities)


def _check_opaque(image: Image.Image, data: bytes) -> None:
    """Raise ValueError if a pixel is transparent, also partly."""
    if image.has_transparency_data:
        # of 16 bits, Pillow does not apply the transparent colour
        is_16_bit_png = image.format == "PNG" and data[24] == 16 and "transparency" in image.info
        if is_16_bit_png or any(image.convert("RGBA").getchannel("A").histogram()[:255]):
            raise ValueError("should be a picture without transparent pixels: draw it on a background first")


def _stated(image: Image.Image, data: bytes) -> tuple[float | None, Sequence[float]]:
    """Return the gamma (None for sRGB's curve) and the chromaticities that a file without a profile states."""
    info, tags = image.info, getattr(image, "tag_v2", {})
    place = data.find(b"\0\0\0\4cICP", 0, data.find(b"IDAT")) if image.format == "PNG" else -1
    if place >= 0:
        if data[place + 8 : place + 12] != CICP_SRGB:
            raise ValueError("should be a PNG file in sRGB: its chunk cICP states other colours")
        info.pop("icc_profile", None)  # cICP precedes it
    if place >= 0 or "srgb" in info:
        return None, hdr.SRGB
    gamma: Any = info.get("gamma")
    chromaticities: Sequence[float] = hdr.SRGB
    if gamma == 0:
        raise ValueError("should be a PNG file with a gamma above 0")
    if gamma and SRGB_GAMMA[0] < gamma < SRGB_GAMMA[1]:
        gamma = None
    if "chromaticity" in info:
        chromaticities = *info["chromaticity"][2:], *info["chromaticity"][:2]
    elif TIFF_PRIMARIES in tags:
        chromaticities = *map(float, tags[TIFF_PRIMARIES]), *map(float, tags.get(TIFF_WHITE, hdr.SRGB[6:]))
    try:
        if image.getexif().get_ifd(EXIF_INTEROPERABILITY).get(1) == "R03":
            return ADOBE_RGB
    except Exception:  # of any kind, for damaged Exif data
        pass
    return gamma, chromaticities


def _by_profile(image: Image.Image, profile: bytes | None) -> Image.Image:
    """Return a picture in sRGB, by its ICC profile. Without one, its colours are Lab of ICC's white, D50."""
    try:
        given = ImageCms.ImageCmsProfile(BytesIO(profile) if profile else ImageCms.createProfile("LAB"))
        space = given.profile.xcolor_space.strip()
        mode = {"GRAY": "L", "RGB": "RGB", "CMYK": "CMYK", "Lab": "LAB"}.get(space)
        kept = image.mode if image.mode in ("CMYK", "LAB") else "L" if image.mode in ("1", "L", "LA") else "RGB"
        if mode and (mode == kept or (mode, kept) == ("RGB", "L")):
            transform = ImageCms.buildTransform(given, ImageCms.createProfile("sRGB"), mode, "RGB")
            return transform.apply(image.convert(mode))
    except (OSError, ImageCms.PyCMSError):
        raise ValueError("should be a picture whose ICC profile is whole") from None
    raise ValueError(f"should be a picture whose ICC profile is for its colours, {kept}, not for {shown(space)}")


def _by_numbers(image: Image.Image, gamma: float | None, chromaticities: Sequence[float]) -> Image.Image:
    """Return a picture in sRGB. `gamma` and `chromaticities` are as for `_stated`."""
    if gamma is None and np.allclose(chromaticities, hdr.SRGB, atol=0.002):
        return image
    levels = hdr.linear(range(256)) if gamma is None else (np.arange(256) / 255) ** (1 / gamma)
    pixels = np.array(image)
    for top in range(0, len(pixels), BAND):
        band = hdr.converted(levels[pixels[top : top + BAND]], chromaticities)
        pixels[top : top + BAND] = hdr.as_bytes(band)
    return Image.fromarray(pixels)


def _exr_of(data: bytes) -> hdr.Light:
    """Return the light in an EXR file with this content: OpenEXR reads named files."""
    with TemporaryFile() as file:
        file.write(data)
        file.flush()
        file.seek(0)  # where /dev/fd/N shares the place in the file
        return exr(Path(f"/dev/fd/{file.fileno()}"))


def exr(path: Path) -> hdr.Light:
    """Return the light in an EXR file."""
    try:
        import OpenEXR
    except ImportError:
        raise ValueError(f"needs OpenEXR, which is not installed: {remedies.extra('exr')}") from None
    with OpenEXR.File(str(path), separate_channels=True) as file:  # its arrays are empty once it is closed
        header, channels = file.header(), file.channels()
        bounds = [np.array(header[name]).tolist() for name in ("dataWindow", "displayWindow")]
        is_whole = header["type"] in (OpenEXR.scanlineimage, OpenEXR.tiledimage) and bounds[0] == bounds[1]
        colours = [channels[name] for name in "RGB" if name in channels]
        if not is_whole or len(colours) < 3 or any((each.xSampling, each.ySampling) != (1, 1) for each in colours):
            raise ValueError("should be an EXR file whose first part has R, G and B for every pixel")
        light = np.dstack([each.pixels for each in colours]).astype(np.float32)
        return hdr.clipped(light, header.get("chromaticities", hdr.SRGB))


if __name__ == "__main__":
    main()
