"""From pixels to files: encoding, captions and overlays. May import `optics`, `sheets`, `scene` and `rendering`."""
