"""The report: a folder with a page that shows the trade-offs of a scenario, and how the robot carries out its plans."""
