"""The page's QR codes, read again by the rules of ISO/IEC 18004."""

import pytest

CHECKS = {1: (1, 7), 2: (1, 10), 5: (1, 26), 6: (2, 18), 9: (2, 30), 10: (4, 18), 14: (4, 30), 17: (6, 28), 20: (8, 28)}
FORMAT = "111011111000100"  # level L, mask 0


def power_table():
    table, x = [], 1
    for _ in range(255):
        table.append(x)
        x = (x << 1) ^ (0x11D if x & 0x80 else 0)
    return table


POWERS = power_table()


def times(a, b):
    return POWERS[(POWERS.index(a) + POWERS.index(b)) % 255] if a and b else 0


def fixed(version):
    """Return the places that hold no data."""
    side = 17 + 4 * version
    found = {(x, y) for x in range(9) for y in range(9)}
    found |= {(side - 1 - x, y) for x in range(8) for y in range(9)} | {
        (x, side - 1 - y) for x in range(9) for y in range(8)
    }
    found |= {(k, 6) for k in range(side)} | {(6, k) for k in range(side)}
    centres = {
        2: [18],
        5: [30],
        6: [34],
        9: [26, 46],
        10: [28, 50],
        14: [26, 46, 66],
        17: [30, 54, 78],
        20: [34, 62, 90],
    }
    places = [6, *centres.get(version, [])]
    for x in places if version > 1 else ():
        for y in places:
            if (x, y) not in ((6, 6), (6, side - 7), (side - 7, 6)):
                found |= {(x + u, y + v) for u in range(-2, 3) for v in range(-2, 3)}
    if version >= 7:
        found |= {(side - 11 + a, b) for a in range(3) for b in range(6)}
        found |= {(b, side - 11 + a) for a in range(3) for b in range(6)}
    return found


def bytes_of(dark):
    """Return all bytes, in the order in which they are drawn. The two formats have to be right."""
    side = len(dark)
    places = fixed((side - 17) // 4)
    first = [(8, k) for k in (0, 1, 2, 3, 4, 5, 7, 8)] + [(k, 8) for k in (7, 5, 4, 3, 2, 1, 0)]
    second = [(side - 1 - k, 8) for k in range(8)] + [(8, side - 7 + k) for k in range(7)]
    for line in (first, second):
        assert "".join(str(int(dark[y][x])) for x, y in reversed(line)) == FORMAT
    bits = []
    right, upwards = side - 1, True
    while right > 0:
        if right == 6:
            right = 5
        for y in reversed(range(side)) if upwards else range(side):
            bits += [int(dark[y][x] != ((x + y) % 2 == 0)) for x in (right, right - 1) if (x, y) not in places]
        right, upwards = right - 2, not upwards
    return [int("".join(map(str, bits[k : k + 8])), 2) for k in range(0, len(bits) // 8 * 8, 8)]


def read(dark):
    """Return the text of a code. Its check bytes have to be right."""
    version, every = (len(dark) - 17) // 4, bytes_of(dark)
    count, check = CHECKS[version]
    sizes = [len(every) // count - check + (k >= count - len(every) % count) for k in range(count)]
    stream = iter(every)
    blocks, tails = [[] for _ in range(count)], [[] for _ in range(count)]
    for n in range(max(sizes)):
        for block in (block for block, size in zip(blocks, sizes, strict=True) if n < size):
            block.append(next(stream))
    for tail in tails * check:
        tail.append(next(stream))
    for block, tail in zip(blocks, tails, strict=True):
        for k in range(check):
            total = 0
            for byte in block + tail:
                total = times(total, POWERS[k]) ^ byte
            assert total == 0
    text = "".join(f"{byte:08b}" for block in blocks for byte in block)
    assert text[:4] == "0100"
    head = 12 if version < 10 else 20
    length = int(text[4:head], 2)
    return bytes(int(text[head + 8 * k : head + 8 * k + 8], 2) for k in range(length)).decode()


@pytest.mark.parametrize(
    ("length", "version"), [(17, 1), (18, 2), (106, 5), (134, 6), (230, 9), (271, 10), (458, 14), (858, 20)]
)
def test_a_code_is_read_again(node, length, version):
    text = (
        ("https://example.org/demo.html#alpha=66&L=0,-0.85&ü" * 20)
        .encode()[:length]
        .decode("utf-8", "ignore")
        .ljust(length, "x")
    )
    text = text.encode()[:length].decode("utf-8", "ignore")
    dark = node.evaluate("qr", text)
    assert len(dark) == 17 + 4 * version
    assert read(dark) == text


def test_a_text_that_is_too_long_has_no_code(node):
    assert node.evaluate("qr", "x" * 859) is None
