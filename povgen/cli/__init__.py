"""The command line: reads options, calls the package, reports. May import everything else."""
