"""What teaches: the page and the paper's figures. May import all but `cli`."""
