"""The run: from event to event, and what is recorded on the way."""
