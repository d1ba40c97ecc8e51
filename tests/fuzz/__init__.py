"""Any command line and any spec: povgen obeys (exit status 0), or refuses in one line (2) and touches no file.

Thousands of cases are made from povgen's own commands, options and models, so that new ones are tried as well. They run
in this process. Only POV-Ray and other slow parts are replaced.
"""
