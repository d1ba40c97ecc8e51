"""The page's QR codes, read by ZXing."""

import numpy as np
import pytest
import zxingcpp

TEXT = "https://example.org/demo.html#alpha=66&L=0,-0.85&ü" * 20


@pytest.mark.parametrize(
    ("length", "version"), [(17, 1), (18, 2), (106, 5), (134, 6), (230, 9), (271, 10), (458, 14), (858, 20)]
)
def test_a_code_is_read_again(node, length, version):
    """The longest and the shortest texts of some versions: one block and more, of one length and of two."""
    text = TEXT.encode()[:length].decode("utf-8", "ignore")
    text += "x" * (length - len(text.encode()))
    dark = np.array(node.evaluate("qr", text))
    assert dark.shape == (17 + 4 * version,) * 2
    picture = np.where(np.pad(dark, 4).repeat(4, 0).repeat(4, 1), 0, 255).astype(np.uint8)
    (found,) = zxingcpp.read_barcodes(picture)
    assert found.text == text and not found.error


def test_a_text_that_is_too_long_has_no_code(node):
    assert node.evaluate("qr", "x" * 859) is None
