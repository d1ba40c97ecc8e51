"""From pixels to files: encoding, captions and overlays. May import `rendering`, `scene` and `optics`."""
