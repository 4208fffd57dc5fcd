"""The report: one folder with a page that shows the trade-offs of a scenario and how the robot lives up to them."""
