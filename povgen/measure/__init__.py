"""What is measured: accuracy, stability and speed, and charts of it. May import all but `page`, `paper` and `cli`."""
