"""What was learnt as text for people."""
