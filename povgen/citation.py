"""How to cite povgen: BibTeX entries of povgen and of the paper that it follows."""

from povgen.version import __version__

HOME = "https://github.com/povgen/povgen"
CITE = f"{HOME}; please cite povgen and doi:10.1088/1464-4258/11/8/085705: `povgen cite` prints BibTeX"
ENTRIES = f"""@software{{povgen,
  title = {{povgen: POV-Ray scenes and movies of Dove-prism sheets that rotate the direction of light rays}},
  author = {{{{The povgen authors}}}},
  version = {{{__version__}}},
  year = {{2026}},
  url = {{{HOME}}},
}}

@article{{hamilton2009local,
  title = {{Local light-ray rotation}},
  author = {{Hamilton, Alasdair C. and Sundar, Bhuvanesh and Nelson, John and Courtial, Johannes}},
  journal = {{Journal of Optics A: Pure and Applied Optics}},
  volume = {{11}},
  pages = {{085705}},
  year = {{2009}},
  doi = {{10.1088/1464-4258/11/8/085705}},
}}
"""
