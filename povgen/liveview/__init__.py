"""The live view and the page around it, for a browser. May import all but `measure`, `teach` and `cli`."""
