"""What stands in a scene. Each file of this folder that defines a class with a `kind` adds a kind of object."""
