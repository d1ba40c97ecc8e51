"""The mathematics: ray rotation, Dove prisms, the ray trace. Imports numpy alone."""
