"""The paper's figures. May import all but `cli`."""
