"""The live view, the ray tracer in the browser. May import all but `page`, `measure`, `paper` and `cli`."""
