"""From a scene's text to pixels: POV-Ray, the sandbox it runs in, the cache. May import `optics` and `scene`."""
