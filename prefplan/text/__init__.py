"""What is read and shown as text: names, how values are written, numbers, plans and tables."""
