"""What a user gives to scenes: files of pieces, meshes and pictures, and the types of the scenes' parameters."""
