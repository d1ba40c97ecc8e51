"""What is measured: accuracy, stability and speed, and the charts of it. May import all but `teach` and `cli`."""
