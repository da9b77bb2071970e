"""The script: timed sentences to a plan of actions."""
